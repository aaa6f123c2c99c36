#include "src/contact/linearize.hpp"
#include <cmath>
#include "src/base/error.hpp"
#include "src/contact/restitution.hpp"

namespace quern {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw InputError(std::string("To linearize a power law, ") + what + ".");
}

struct State {
  double overlap, speed;        // x [m], ẋ [m/s]
  double xf = 0, xx = 0;        // ∫x f dt, ∫x² dt
  double vf = 0, vv = 0;        // ∫ẋ f dt, ∫ẋ² dt
};

State operator+(const State& a, const State& b) {
  return {a.overlap + b.overlap, a.speed + b.speed, a.xf + b.xf, a.xx + b.xx, a.vf + b.vf, a.vv + b.vv};
}
State operator*(double s, const State& a) { return {s * a.overlap, s * a.speed, s * a.xf, s * a.xx, s * a.vf, s * a.vv}; }

}  // namespace

Linearization linearize(const PowerLaw& law, double mass, double speed) {
  require(std::isfinite(mass) && mass > 0, "the mass must be positive");
  require(std::isfinite(speed) && speed > 0, "the speed must be positive");
  require(std::isfinite(law.stiffness) && law.stiffness > 0, "the stiffness k must be positive");
  require(law.stiffness_exponent > 0 && law.stiffness_exponent < 10, "the exponent r must be between 0 and 10");
  require(std::isfinite(law.damping) && law.damping >= 0, "the damping q must not be negative");
  require(law.damping_exponent >= 0 && law.damping_exponent < 10, "the exponent s must be between 0 and 10");

  const double r = law.stiffness_exponent;
  const double reach = std::pow((r + 1) * mass * speed * speed / (2 * law.stiffness), 1 / (r + 1));
  const double dt = reach / speed / 2000;
  const auto force = [&](const State& s) {
    const double x = std::max(0.0, s.overlap);
    return law.damping * std::pow(x, law.damping_exponent) * s.speed + law.stiffness * std::pow(x, r);
  };
  const auto rate = [&](const State& s) {
    const double f = force(s);
    return State{s.speed, -f / mass, s.overlap * f, s.overlap * s.overlap, s.speed * f, s.speed * s.speed};
  };

  State state{0, speed};
  double time = 0;
  for (int step = 0; step < 10000000; ++step) {
    const State a = rate(state), b = rate(state + 0.5 * dt * a), c = rate(state + 0.5 * dt * b), d = rate(state + dt * c);
    const State next = state + dt / 6 * (a + 2.0 * b + 2.0 * c + d);
    if (next.speed < 0 && (next.overlap <= 0 || force(next) <= 0)) {
      // The last step is cut where the force ends, found by a straight line.
      const double before = force(state), after = force(next);
      const double part = next.overlap <= 0 ? state.overlap / (state.overlap - next.overlap) : before / (before - after);
      state = state + part * (next + -1.0 * state);
      time += dt * part;
      break;
    }
    state = next;
    time += dt;
  }

  Linearization result{};
  result.stiffness = state.xf / state.xx;
  result.damping = state.vf / state.vv;
  result.loss = 0.5 * mass * (speed * speed - state.speed * state.speed);
  result.restitution = std::max(0.0, -state.speed / speed);
  result.duration = time;
  result.linear_loss = collide_head_on(Linearized{result.stiffness, result.damping, 0, 0}, 1, mass, speed).loss;
  return result;
}

}  // namespace quern
