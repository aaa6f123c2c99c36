// The mass that passes through a plane.
#include "src/observe/discharge.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include "tests/scene.hpp"

using namespace quern;

TEST_CASE("a train of balls passes a plane at the rate at which it is fed", "[discharge]") {
  // Ball k reaches the plane at (k + ½)/100 s: one per interval.
  constexpr double speed = 2, apart = 0.02;
  constexpr int balls = 80;
  Simulation s = scene::free_space(scene::glass(), scene::hertz(scene::glass(), scene::glass(), 0.9, 0.3), 1e-4);
  for (int k = 0; k < balls; ++k) scene::add_ball(s, {0, -apart * (k + 0.5), 0}, 2e-3 + 1e-4 * (k % 3), {0, speed, 0});
  scene::add_ball(s, {1, 0.5, 0}, 5e-3, {0, 0, 0});         // beyond from the start
  scene::add_ball(s, {-1, 0.05, 0}, 5e-3, {0, -speed, 0});  // comes back through it at 25 ms
  const double returned = s.particles.mass(balls + 1);
  s.start(false);
  ObserverSettings settings;
  settings.discharge = OutletPlane{Vec3(3, 0, -1), Vec3::UnitY()};
  settings.discharge_interval = 0.03;
  settings.start_time = 0.1;
  Discharge discharge;
  for (int k = 0; k <= 6000; ++k) {
    discharge.see(s, settings);
    s.step();
  }
  REQUIRE(discharge.time.size() == 20);
  double passed = -returned;
  for (std::size_t row = 0; row < discharge.time.size(); ++row) {
    CHECK(discharge.time[row] == Approx(0.03 * static_cast<double>(row + 1)).epsilon(1e-9));
    for (Index k = 3 * static_cast<Index>(row); k < 3 * static_cast<Index>(row) + 3; ++k) passed += s.particles.mass(static_cast<Index>(scene::row_of(s, k)));
    CHECK(discharge.mass[row] == Approx(passed).epsilon(1e-12));
  }
  // The mass of three balls in a row, every 30 ms; from the first interval that begins after 0.1 s.
  const double three = s.particles.mass(static_cast<Index>(scene::row_of(s, 0))) + s.particles.mass(static_cast<Index>(scene::row_of(s, 1))) +
                       s.particles.mass(static_cast<Index>(scene::row_of(s, 2)));
  const std::vector<Headline> lines = discharge.headlines(settings);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0].key == "discharged_mass");
  CHECK(lines[0].value == Approx(passed).epsilon(1e-12));
  CHECK(lines[1].key == "discharge_rate");
  CHECK(lines[1].value == Approx(three / 0.03).epsilon(1e-9));
  CHECK(discharge.tables()[0].columns[2].values[10] == Approx(three / 0.03).epsilon(1e-9));
}
