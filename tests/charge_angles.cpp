#include <catch2/catch.hpp>
#include <cmath>

#include "src/base/random.hpp"
#include "src/observe/charge.hpp"
#include "src/engine/simulation.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

std::optional<Headline> headline(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line;
  return std::nullopt;
}

double value(const std::vector<Headline>& lines, const std::string& key) {
  const auto line = headline(lines, key);
  return line ? line->value : NAN;
}

ObserverSettings drum(double speed) {
  ObserverSettings settings;
  MillAxis mill;
  mill.speed = speed;
  mill.radius = 0.4;
  mill.length = 0.2;
  settings.mill = mill;
  settings.charge_interval = 5e-3;
  return settings;
}

Vec3 place_at(const MillView& view, double radius, double angle) {
  return view.centre + radius * (std::cos(angle * degree) * view.up + std::sin(angle * degree) * view.ahead);
}

}  // namespace

TEST_CASE("angles are counted from 12 o'clock in the sense of rotation, whichever way the mill turns") {
  MillAxis mill;  // about +y; seen from −y, the world's x points right, z up, and a positive speed takes the top to +x: clockwise
  mill.speed = 1;
  const MillView clockwise = *view_of(mill, {0, 0, -9.81});
  CHECK(clockwise.angle({0, 0, 1}) == Approx(0).margin(1e-9));
  CHECK(clockwise.angle({1, 0, 0}) == Approx(90));
  CHECK(clockwise.angle({0, 0, -1}) == Approx(180));
  CHECK(clockwise.angle({-1, 0, 0}) == Approx(270));
  mill.speed = -1;
  const MillView anticlockwise = *view_of(mill, {0, 0, -9.81});
  CHECK(anticlockwise.angle({1, 5, 0}) == Approx(270));
  CHECK(anticlockwise.radius({3, 5, 4}) == Approx(5));

  CHECK(from_three_oclock(312.5) == Approx(42.5));
  CHECK(from_three_oclock(126) == Approx(216));
  CHECK(from_twelve_oclock_anticlockwise(300, true) == Approx(300));
  CHECK(from_twelve_oclock_anticlockwise(300, false) == Approx(60));
  CHECK(beyond_six_oclock(170) == Approx(-10));
  CHECK_FALSE(view_of(mill, {0, -9.81, 0}).has_value());
}

TEST_CASE("toe and shoulder of a bed that covers a known arc of the shell are found within a cell") {
  for (double speed : {1.5, -1.5})
    for (const auto& [toe, shoulder] : {std::pair{140.0, 300.0}, {161.0, 283.5}, {95.0, 355.0}, {120.0, 370.0}}) {
      const ObserverSettings settings = drum(speed);
      const MillView view = *view_of(*settings.mill, {0, 0, -9.81});
      Simulation s;
      s.clock.time_step = 5e-3;
      RandomStream random(21);
      constexpr int balls = 3000;
      const double radius = 0.006;
      for (int k = 0; k < balls; ++k) s.particles.add_sphere({0, 0, 0}, radius, 7800, 0, 0);
      Charge charge;
      for (int sample = 0; sample < 50; ++sample, ++s.clock.step) {
        for (int k = 0; k < balls; ++k) {
          // A tenth of the balls fly anywhere.
          const double angle = k % 10 == 0 ? random.uniform(0, 360) : random.uniform(toe, shoulder);
          set(s.particles.position[static_cast<std::size_t>(k)], place_at(view, 0.4 - radius - 0.1 * random.uniform(), angle));
        }
        charge.see(s, settings);
      }
      const auto lines = charge.headlines(0);
      const double cell = 360.0 / settings.angle_cells;
      INFO("toe " << toe << " shoulder " << shoulder);
      CHECK(value(lines, "toe_angle") == Approx(toe).margin(cell));
      CHECK(value(lines, "shoulder_angle") == Approx(wrapped(shoulder)).margin(cell));
    }
}

TEST_CASE("a charge all around the shell has neither toe nor shoulder") {
  CHECK_FALSE(half_level_angles(std::vector<double>(120, 1.0)).has_value());
  CHECK_FALSE(half_level_angles(std::vector<double>(120, 0.0)).has_value());
}

TEST_CASE("balls that leave the shell at one angle and land at another show the angles and heights of their path") {
  // Every ball rides with the shell until gravity takes it off (cos α = ω² r/g before 12 o'clock), flies on a parabola, lands and rides on.
  const double speed = 3.8, radius = 0.005, ride = 0.4 - radius, leave = 360 - std::acos(speed * speed * ride / 9.81) / degree;
  ObserverSettings settings = drum(speed);
  settings.charge_interval = 1e-3;
  const MillView view = *view_of(*settings.mill, {0, 0, -9.81});
  // (ahead, up) where it leaves, its velocity there, and the flight until it is back at the shell.
  const double x0 = ride * std::sin(leave * degree), y0 = ride * std::cos(leave * degree);
  const double vx = speed * ride * std::cos(leave * degree), vy = -speed * ride * std::sin(leave * degree);
  double flight = 0.05;
  const auto x = [&](double t) { return x0 + vx * t; };
  const auto y = [&](double t) { return y0 + vy * t - 0.5 * 9.81 * t * t; };
  while (std::hypot(x(flight), y(flight)) < ride) flight += 1e-5;
  const double landing = wrapped(std::atan2(x(flight), y(flight)) / degree);
  const double riding = wrapped(leave - landing) * degree / speed, circuit = flight + riding;
  const double apex = y0 + vy * vy / (2 * 9.81), drop = apex - y(flight);

  Simulation s;
  s.clock.time_step = 1e-3;
  constexpr int balls = 40;
  for (int k = 0; k < balls; ++k) s.particles.add_sphere({0, 0, 0}, radius, 7800, 0, 0);
  Charge charge;
  RandomStream random(8);
  std::vector<double> phase(balls), before(balls);
  for (double& p : phase) p = random.uniform() * circuit;
  const int steps = 6000;
  for (int step = 0; step < steps; ++step, ++s.clock.step) {
    s.contacts.ended.clear();
    for (int k = 0; k < balls; ++k) {
      const auto row = static_cast<std::size_t>(k);
      const double t = std::fmod(phase[row] + s.clock.time(), circuit);
      const bool flies = t < flight;
      const double angle = landing + speed * (t - flight) / degree;
      set(s.particles.position[row], flies ? (view.centre + x(t) * view.ahead + y(t) * view.up).eval() : place_at(view, ride, angle));
      set(s.particles.acceleration[row], flies ? s.gravity : (s.gravity + Vec3(0, 0, 20)).eval());
      if (!flies && before[row] < flight && step > 0) {
        Collision c{};
        c.first_id = k;
        c.second_id = -1;
        c.second_species = 255;
        c.first_mass = c.record.effective_mass = 0.1;
        c.record.normal_speed = 3;
        c.place = xyz(s.particles.position[row]);
        s.contacts.ended.push_back(c);
        // Many weak collisions on the way up do not move the impact angle.
        c.record.normal_speed = 0.05;
        c.place = triple(place_at(view, ride, random.uniform(180, 300)));
        for (int weak = 0; weak < 100; ++weak) s.contacts.ended.push_back(c);
      }
      before[row] = t;
    }
    charge.see(s, settings);
  }
  const auto lines = charge.headlines(0);
  CHECK(value(lines, "departure_angle") == Approx(leave).margin(3));
  CHECK(value(lines, "impact_angle") == Approx(landing).margin(1));
  CHECK(value(lines, "shoulder_angle") == Approx(leave).margin(3));
  const double fall_speed = std::sqrt(2 * 9.81 * drop);
  CHECK(value(lines, "fall_height_max") == Approx(drop).margin(2 * fall_speed * 1e-3));
  CHECK(value(lines, "fall_height_mean") == Approx(drop).margin(2 * fall_speed * 1e-3));
  // A revolution is longer than a circuit: each ball shows its whole range, from the bottom to the apex.
  REQUIRE(2 * pi / speed > circuit);
  CHECK(value(lines, "release_height") == Approx(apex + ride).margin(0.01));
}

TEST_CASE("the interval of an angle covers the scatter between spans of time") {
  const ObserverSettings settings = drum(1.5);
  const MillView view = *view_of(*settings.mill, {0, 0, -9.81});
  Simulation s;
  s.clock.time_step = 5e-3;
  RandomStream random(5);
  constexpr int balls = 400;
  for (int k = 0; k < balls; ++k) s.particles.add_sphere({0, 0, 0}, 0.01, 7800, 0, 0);
  Charge charge;
  for (int sample = 0; sample < 6000; ++sample, ++s.clock.step) {
    RandomStream second(1, static_cast<std::uint64_t>(s.clock.time()));
    const double shoulder = 300 + second.uniform(-5, 5);
    for (int k = 0; k < balls; ++k) set(s.particles.position[static_cast<std::size_t>(k)], place_at(view, 0.385, random.uniform(150, shoulder)));
    charge.see(s, settings);
  }
  CHECK(charge.blocks.blocks.size() >= 15);
  const auto line = headline(charge.headlines(0), "shoulder_angle");
  REQUIRE(line);
  REQUIRE(line->ci95);
  CHECK((*line->ci95)[0] < 300);
  CHECK((*line->ci95)[1] > 300);
  CHECK((*line->ci95)[1] - (*line->ci95)[0] < 5);
}
