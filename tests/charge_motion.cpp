// How much of a charge flies, and how far it lags behind the shell.
#include <catch2/catch.hpp>
#include <cmath>
#include "src/observe/charge.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

// A drum of 0.2 m across gravity, which turns at `speed` [rad/s].
struct Drum {
  Simulation s;
  ObserverSettings settings;
  Charge charge;

  Drum(double speed, double restitution, double friction) : s(scene::free_space({"steel", 7800, 0, 0}, scene::linear(1e5, restitution, friction), 2e-5)) {
    settings.mill = scene::add_drum(s, speed);
    settings.start_time = 1;
  }
  double watch(double until, const std::string& key) {
    s.start(true);
    while (s.clock.time() < until) s.step(), charge.see(s, settings);
    for (const Headline& h : charge.headlines(1))
      if (h.key == key) return h.value;
    return NAN;
  }
};

}  // namespace

TEST_CASE("balls that slide on a smooth shell lag wholly behind it, and balls that it carries round do not") {
  Drum smooth(6, 0.3, 0), fast(30, 0.3, 0.8);  // at 30 rad/s the shell pulls with nine times gravity
  fast.s.pair_laws[0].rolling = {RollingModel::elastic_plastic, 0.3, 0.3};  // or they would roll back a little in every turn
  for (int k = 0; k < 3; ++k) {
    const double x = -0.02 + 0.02 * k, z = -std::sqrt(0.092 * 0.092 - x * x);
    scene::add_ball(smooth.s, {x, 0.01 + 0.02 * k, z}, 0.008, {0, 0, 0});
    scene::add_ball(fast.s, {x, 0.01 + 0.02 * k, z}, 0.008, {30 * z, 0, -30 * x}, {0, 30, 0});  // at rest on the shell, as they could not climb it alone
  }
  CHECK(smooth.watch(2, "shell_slip") == Approx(1).margin(0.01));
  CHECK(fast.watch(3, "shell_slip") == Approx(0).margin(0.02));
}

TEST_CASE("a ball that bounces without loss flies but for its touches, one that lies does not fly") {
  Drum bouncing(6, 1, 0), lying(6, 0.3, 0);
  scene::add_ball(bouncing.s, {0, 0.03, -0.04}, 0.008, {0, 0, 0});
  scene::add_ball(lying.s, {0, 0.03, -0.0919}, 0.008, {0, 0, 0});
  // Falls of 52 mm last 0.206 s, touches π √(m/k) = 1.3 ms, and half of these go unseen between samples. The first flight seen and the last, of 9 s some 0.4 s each, are not whole.
  const double share = bouncing.watch(10, "flight_share");
  CHECK(share > 0.9);
  CHECK(share <= 1);
  CHECK(lying.watch(2, "flight_share") == 0);
}
