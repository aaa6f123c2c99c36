#include "src/contact/restitution.hpp"
#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include "src/contact/with_effects.hpp"

namespace quern {
namespace {

ContactForce<double> force_at(const ContactLaw& law, double overlap, double closing_speed, double radius, double mass) {
  const Approach<double> approach = head_on(overlap, -closing_speed, radius, mass);
  return std::visit(
      [&](const auto& chosen) {
        TangentialSpring<double> spring{};
        return act(chosen, approach, spring);
      },
      law);
}

// Greatest overlap of the undamped collision: U(δ) = ½ m v².
double elastic_overlap(const ContactLaw& law, double radius, double mass, double speed) {
  const double energy = 0.5 * mass * speed * speed;
  double low = 0, high = radius;
  while (force_at(law, high, 0, radius, mass).elastic_energy < energy) high *= 2;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (force_at(law, middle, 0, radius, mass).elastic_energy < energy ? low : high) = middle;
  }
  return high;
}

// Finds x in [low, high] where the falling function f crosses `wanted`.
template <class Function>
double solve_falling(Function f, double wanted, double low, double high) {
  const auto above = [&](double x) { return f(x) - wanted; };
  if (!(above(low) > 0)) return low;
  if (!(above(high) < 0)) return high;
  std::uintmax_t most = 100;
  const auto [left, right] = boost::math::tools::toms748_solve(above, low, high, boost::math::tools::eps_tolerance<double>(48), most);
  return 0.5 * (left + right);
}

// Remembers the answers of a slow function: fits ask for the same ones again and again.
template <std::size_t count, class Function>
double remembered(const std::array<double, count>& question, Function&& answer) {
  static std::mutex guard;
  static std::map<std::array<double, count>, double> known;
  constexpr std::size_t most = 100000;
  {
    const std::lock_guard lock(guard);
    if (const auto found = known.find(question); found != known.end()) return found->second;
  }
  const double value = answer();
  const std::lock_guard lock(guard);
  if (known.size() > most) known.clear();
  return known[question] = value;
}

// What the linear law measures with the damping ratio β where its force never attracts (Schwager & Pöschel 2007, eqs. 20–21).
double linear_restitution(double beta) {
  if (beta == 0) return 1;
  if (beta == 1) return std::exp(-2.0);
  if (beta < 1) {
    const double omega = std::sqrt(1 - beta * beta);
    return std::exp(-beta / omega * (std::numbers::pi - std::atan2(2 * beta * omega, omega * omega - beta * beta)));
  }
  const double omega = std::sqrt(beta * beta - 1);
  return std::exp(-beta / omega * std::log((beta + omega) / (beta - omega)));
}

}  // namespace

HeadOnCollision collide_head_on(const ContactLaw& law, double radius, double mass, double speed) {
  const double dt = elastic_overlap(law, radius, mass, speed) / speed / 1000;
  HeadOnCollision result{};
  double overlap = 0, closing = speed;
  const auto deceleration = [&](double d, double v) { return force_at(law, std::max(d, 0.0), v, radius, mass).normal / mass; };
  for (int step = 0; step < 1000000; ++step) {
    const double a1 = deceleration(overlap, closing);
    const double v2 = closing - 0.5 * dt * a1, a2 = deceleration(overlap + 0.5 * dt * closing, v2);
    const double v3 = closing - 0.5 * dt * a2, a3 = deceleration(overlap + 0.5 * dt * v2, v3);
    const double v4 = closing - dt * a3, a4 = deceleration(overlap + dt * v3, v4);
    overlap += dt / 6 * (closing + 2 * v2 + 2 * v3 + v4);
    closing -= dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    result.duration += dt;
    result.peak_overlap = std::max(result.peak_overlap, overlap);
    const double force = overlap > 0 ? force_at(law, overlap, closing, radius, mass).normal : 0.0;
    result.peak_force = std::max(result.peak_force, force);
    if (closing > 0 && overlap > 0)
      result.damping_rate = std::max(result.damping_rate, (force - force_at(law, overlap, 0, radius, mass).normal) / (mass * closing));
    if (closing < 0 && force <= 0) break;
  }
  result.restitution = std::max(0.0, -closing / speed);
  result.loss = 0.5 * mass * (speed * speed - closing * closing);
  return result;
}

namespace {

constexpr int steps_wanted = 400, most_steps = 40000;

// In steps of dt; `steps` becomes the number of them from first touch to parting. Of bodies that stay together the duration is twice
// the time to the greatest overlap.
HeadOnCollision collide_in_steps(const PairLaw& pair, double radius, double mass, double speed, double dt, int& steps) {
  HeadOnCollision result{};
  Remembered<double> memory{};
  double overlap = 0, velocity = -speed, acceleration = 0, to_peak = 0;
  for (steps = 1; steps <= most_steps; ++steps) {
    overlap -= dt * (velocity + 0.5 * dt * acceleration);
    const double predicted = velocity + dt * acceleration;
    Approach<double> approach = head_on(std::max(overlap, 1e-300), predicted, radius, mass, dt);
    approach.overlap = overlap;
    TangentialSpring<double> spring{};
    EffectForce<double> force;
    std::visit([&](const auto& law) { act_with_effects(law, pair.extras, approach, 0.0, memory, spring, force); }, pair.law);
    const double fresh = force.contact.normal / mass;
    velocity += 0.5 * dt * (acceleration + fresh);
    acceleration = fresh;
    if (overlap > result.peak_overlap) result.peak_overlap = overlap, to_peak = steps * dt;
    result.peak_force = std::max(result.peak_force, force.contact.normal);
    if (predicted < 0 && overlap > 0 && memory.touching > 0) {
      NormalPart<double> part;
      std::visit([&](const auto& law) { law.normal(approach, part); }, pair.law);
      const double damping = memory.touching * pair.extras.stiffening.damping_scale() * part.damping + pair.extras.viscoelastic_time * force.contact.normal_stiffness;
      result.damping_rate = std::max(result.damping_rate, damping / mass);
    }
    if (velocity > 0 && memory.touching == 0) break;
  }
  result.duration = steps <= most_steps ? steps * dt : 2 * to_peak;
  result.restitution = std::max(0.0, velocity / speed);
  result.loss = 0.5 * mass * (speed * speed - velocity * velocity);
  return result;
}

}  // namespace

HeadOnCollision collide_head_on(const PairLaw& pair, double radius, double mass, double speed) {
  if (!pair.extras.any()) return collide_head_on(pair.law, radius, mass, speed);
  double dt = elastic_overlap(pair.law, radius, mass, speed) / speed / steps_wanted;
  for (;; dt /= 4) {
    int steps = 0;
    const HeadOnCollision result = collide_in_steps(pair, radius, mass, speed, dt, steps);
    if (steps >= steps_wanted) return result;
  }
}

double linear_damping_ratio(double restitution) { return restitution >= 1 ? 0.0 : solve_falling(linear_restitution, restitution, 0, 20); }

double hertz_damping_ratio(double restitution) {
  if (restitution >= 1) return 0;
  return remembered(std::array{restitution}, [&] {
    return solve_falling([](double beta) { return collide_head_on(HertzMindlin{0.75, 1, beta, 0}, 1, 1, 1).restitution; }, restitution, 0, 20);
  });
}

double deresiewicz_damping_modulus(double young, double restitution, double radius, double mass, double speed) {
  if (restitution >= 1) return 0;
  return remembered(std::array{young, restitution, radius, mass, speed}, [&] {
    const auto law = [&](double modulus) { return Deresiewicz{young, modulus, 1, 0}; };
    // γ v R ~ F at the greatest overlap gives the scale.
    const double overlap = elastic_overlap(law(0), radius, mass, speed);
    const double scale = young * overlap / speed;
    return scale * solve_falling([&](double g) { return collide_head_on(law(g * scale), radius, mass, speed).restitution; }, restitution, 0, 50);
  });
}

}  // namespace quern
