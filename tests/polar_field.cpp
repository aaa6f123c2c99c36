#include <catch2/catch.hpp>
#include <cmath>

#include "src/base/random.hpp"
#include "src/observe/charge.hpp"
#include "src/engine/simulation.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

ObserverSettings drum(double speed) {
  ObserverSettings settings;
  MillAxis mill;
  mill.speed = speed;
  mill.radius = 0.5;
  mill.length = 0.2;
  mill.centre = {1, 2, 3};
  settings.mill = mill;
  settings.charge_interval = 1e-3;
  return settings;
}

// Points all over the cross-section that turn as one body with the mill.
Simulation turning_cloud(const MillAxis& mill, int count, double ball_radius) {
  Simulation s;
  s.clock.time_step = 1e-3;
  RandomStream random(2);
  for (int k = 0; k < count; ++k) {
    const double r = (mill.radius - ball_radius) * std::sqrt(random.uniform()), a = 2 * pi * random.uniform();
    const Vec3 offset(r * std::cos(a), mill.length * (random.uniform() - 0.5), r * std::sin(a));
    const Vec3 place = mill.centre + offset, velocity = mill.speed * mill.axis.cross(offset);
    s.particles.add_sphere(triple(place), ball_radius, 1000, 0, 0);
    set(s.particles.velocity.back(), velocity);
  }
  return s;
}

double headline_or_nan(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line.value;
  return NAN;
}

}  // namespace

TEST_CASE("the cells of a polar grid fill the mill") {
  const PolarGrid grid{0.4, 0.3, 17, 90};
  double sum = 0;
  for (int ring = 0; ring < grid.radius_cells; ++ring) sum += grid.angle_cells * grid.volume(ring);
  CHECK(sum == Approx(pi * 0.4 * 0.4 * 0.3).epsilon(1e-12));
}

TEST_CASE("no particle volume is lost on the grid and a body that turns has the velocity ω r") {
  for (double speed : {2.0, -2.0}) {
    const ObserverSettings settings = drum(speed);
    Simulation s = turning_cloud(*settings.mill, 20000, 0.004);
    Charge charge;
    charge.see(s, settings);
    const std::vector<Table> tables = charge.tables(settings, 0);
    const Table& field = tables[0];
    REQUIRE(field.name == "charge_field");
    const auto &radius = field.columns[0].values, &fraction = field.columns[4].values, &tangential = field.columns[7].values, &radial = field.columns[8].values;
    double solid = 0;
    for (std::size_t k = 0; k < radius.size(); ++k) {
      const int ring = charge.grid.ring_of(radius[k]);
      solid += fraction[k] * charge.grid.volume(ring);
      if (fraction[k] == 0 || ring < 3) continue;
      // Velocities vary over a cell by ± half its size.
      CHECK(tangential[k] == Approx(2 * radius[k]).margin(2 * 0.5 * 0.5 / 20 + 2 * 0.004));
      CHECK(std::abs(radial[k]) < 2 * radius[k] * 3 * degree + 2 * 0.004);
    }
    CHECK(solid == Approx(20000 * 4.0 / 3.0 * pi * std::pow(0.004, 3)).epsilon(1e-9));

    const Table& profile = tables[2];
    REQUIRE(profile.name == "velocity_profile");
    for (std::size_t k = 0; k < profile.columns[0].values.size(); ++k) {
      const double distance = profile.columns[0].values[k];
      if (std::abs(distance) < 0.1 || std::abs(distance) > 0.45) continue;
      CHECK(profile.columns[1].values[k] == Approx(2 * distance).margin(0.03));
      CHECK(profile.columns[2].values[k] == Approx(0).margin(0.03));
    }
  }
}

TEST_CASE("a ball is spread over the grid with the second moment of a sphere") {
  ObserverSettings settings = drum(1.0);
  settings.radius_cells = 5000;
  Simulation s;
  s.clock.time_step = 1e-3;
  const double radius = 0.1, r = 0.3;
  s.particles.add_sphere(triple((settings.mill->centre + Vec3(r, 0, 0)).eval()), radius, 1000, 0, 0);
  Charge charge;
  charge.see(s, settings);
  const Table field = charge.tables(settings, 0)[0];
  double solid = 0, second = 0;
  for (std::size_t k = 0; k < field.columns[0].values.size(); ++k) {
    const double at = field.columns[0].values[k], part = field.columns[4].values[k] * charge.grid.volume(charge.grid.ring_of(at));
    solid += part;
    second += part * at * at;
  }
  CHECK(second / solid == Approx(r * r + 0.4 * radius * radius).epsilon(1e-3));
}

TEST_CASE("a bed of known solid fraction has its porosity and its slope") {
  // Small balls at random in the half-disc below a surface that rises by 30 degrees on the side beyond the bottom.
  const ObserverSettings settings = drum(1.0);
  const std::optional<MillView> view = view_of(*settings.mill, {0, 0, -9.81});
  Simulation s;
  s.clock.time_step = 1e-3;
  RandomStream random(9);
  const double middle = (180 + 30) * degree, ball_radius = 0.003;
  const Vec3 down = std::cos(middle) * view->up + std::sin(middle) * view->ahead;
  int inside = 0;
  constexpr int balls = 60000;
  while (inside < balls) {
    const Vec3 offset = random.uniform(-0.5, 0.5) * view->up + random.uniform(-0.5, 0.5) * view->ahead;
    if (offset.norm() > 0.5 || offset.dot(down) < 0) continue;
    s.particles.add_sphere(triple((view->centre + offset).eval()), ball_radius, 1000, 0, 0);
    ++inside;
  }
  Charge charge;
  charge.see(s, settings);
  const double volume = balls * 4.0 / 3.0 * pi * std::pow(ball_radius, 3), fraction = volume / (0.5 * pi * 0.25 * 0.2);
  CHECK(headline_or_nan(charge.headlines(0), "bed_porosity") == Approx(1 - fraction).margin(0.01));
  CHECK(headline_or_nan(charge.headlines(0), "angle_of_repose") == Approx(30).margin(1.0));
}
