// What a fluid does to a body: each effect against its closed solution, the ledger, and the order of the scheme.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numbers>
#include "src/base/archive.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/engine/time_step.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

constexpr double pi = std::numbers::pi, g = 9.81;

// One ball of 2 mm on which fields act.
Simulation alone(double density, double time_step, std::vector<Field> fields, double diameter = 2e-3) {
  Simulation s = scene::free_space({"ball", density, 1e9, 0.3}, scene::linear(1e4, 0.9, 0.3), time_step);
  s.gravity = {0, 0, -g};
  s.fields = std::move(fields);
  scene::add_ball(s, {0, 0, 0}, 0.5 * diameter, {0, 0, 0});
  return s;
}

double mass_of(double density, double diameter) { return density * pi / 6 * diameter * diameter * diameter; }

void run_to(Simulation& s, double time) {
  const auto steps = static_cast<std::int64_t>(std::llround(time / s.clock.time_step));
  while (s.clock.step < steps) s.step();
}

double speed_down(const Simulation& s) { return -s.particles.velocity[0].z; }

}  // namespace

TEST_CASE("a ball falls through air as tanh and ln cosh say", "[medium]") {
  const double density = 400, d = 0.04, coefficient = 0.47, air = 1.2;
  const double terminal = std::sqrt(2 * mass_of(density, d) * g / (coefficient * air * pi / 4 * d * d));
  Simulation s = alone(density, 1e-4, {AirDrag{coefficient, air}}, d);
  s.start(false);
  for (const double time : {0.5, 2.0, 5.0}) {
    run_to(s, time);
    CHECK(speed_down(s) == Approx(terminal * std::tanh(g * time / terminal)).epsilon(1e-8));
    CHECK(-s.particles.position[0].z == Approx(terminal * terminal / g * std::log(std::cosh(g * time / terminal))).epsilon(1e-8));
  }
  s.measure_energy();
  CHECK(std::abs(s.ledger.closure()) < 1e-6);
  // What drag took is what the fall gave and is not in the motion.
  const double mass = mass_of(density, d);
  CHECK(s.ledger.field_work == Approx(0.5 * mass * terminal * terminal * std::pow(std::tanh(5 * g / terminal), 2) + mass * g * s.particles.position[0].z).epsilon(1e-6));
}

TEST_CASE("nested paper filters fall with a terminal speed as the root of their number", "[medium]") {
  const double d = 0.15, one = 0.9e-3, coefficient = 0.9;
  for (const int filters : {1, 2, 4, 8}) {
    const double density = filters * one / (pi / 6 * d * d * d);
    Simulation s = alone(density, 1e-3, {AirDrag{coefficient, 1.2}}, d);
    s.start(false);
    run_to(s, 5);
    CHECK(speed_down(s) == Approx(std::sqrt(filters * one * g / (0.5 * coefficient * 1.2 * pi / 4 * d * d))).epsilon(1e-6));
  }
}

TEST_CASE("a ball sinks through a viscous fluid as the exact solution of Stokes' drag says", "[medium]") {
  const double density = 2500, fluid = 1260, viscosity = 1.4, d = 2e-3;
  const double time_constant = density * d * d / (18 * viscosity), terminal = (density - fluid) * g * d * d / (18 * viscosity);
  Simulation s = alone(density, time_constant / 1000, {ViscousDrag{viscosity}, Buoyancy{fluid, {0, 0, -g}}});
  s.start(false);
  for (const double times : {0.5, 1.0, 3.0, 20.0}) {
    run_to(s, times * time_constant);
    CHECK(speed_down(s) == Approx(terminal * (1 - std::exp(-times))).epsilon(1e-6));
    CHECK(-s.particles.position[0].z == Approx(terminal * time_constant * (times - 1 + std::exp(-times))).epsilon(1e-6));
  }
  s.measure_energy();
  CHECK(std::abs(s.ledger.closure()) < 1e-6);
}

TEST_CASE("in a resting fluid a body starts with (m − ρV) g/(m + CρV)", "[medium]") {
  for (const double density : {1.2, 500.0, 1000.0, 7800.0})
    for (const double coefficient : {0.0, 0.5, 1.0}) {
      Simulation s = alone(density, 1e-5, {Buoyancy{1000, {0, 0, -g}}});
      s.carried_density = coefficient * 1000;
      s.start(false);
      run_to(s, 1e-3);
      CAPTURE(density, coefficient);
      CHECK(speed_down(s) == Approx(1e-3 * g * (density - 1000) / (density + coefficient * 1000)).epsilon(1e-11).margin(1e-14));
      s.measure_energy();
      CHECK(std::abs(s.ledger.gap()) <= 1e-10 * s.ledger.exchanged + 1e-25);
    }
}

TEST_CASE("added mass, drag and buoyancy together have the closed solution of a body that speeds up in water", "[medium]") {
  const double density = 2600, water = 998, coefficient = 0.44, d = 0.01, mass = mass_of(density, d), displaced = mass_of(water, d);
  const double terminal = std::sqrt(2 * (mass - displaced) * g / (coefficient * water * pi / 4 * d * d)), start = (mass - displaced) * g / (mass + 0.5 * displaced);
  Simulation s = alone(density, 2e-5, {AirDrag{coefficient, water}, Buoyancy{water, {0, 0, -g}}}, d);
  s.carried_density = 0.5 * water;
  s.start(false);
  for (const double time : {0.02, 0.05, 0.2}) {
    run_to(s, time);
    CHECK(speed_down(s) == Approx(terminal * std::tanh(start * time / terminal)).epsilon(1e-6));
    CHECK(-s.particles.position[0].z == Approx(terminal * terminal / start * std::log(std::cosh(start * time / terminal))).epsilon(1e-6));
  }
}

TEST_CASE("a spinning ball turns in the circle of the Magnus force", "[medium]") {
  const double density = 84, air = 1.2, d = 0.04, spin = 200, speed = 12, coefficient = 0.8;
  const double radius = 4 * density * speed / (3 * coefficient * air * spin), turn = 2 * pi * radius / speed;
  Simulation s = alone(density, turn / 20000, {Magnus{coefficient, air}}, d);
  s.gravity = Vec3::Zero();
  s.particles.velocity[0].x = speed;
  s.particles.spin[0].z = spin;  // ω×v: towards +y
  s.start(false);
  for (int quarter = 1; quarter <= 8; ++quarter) {
    run_to(s, quarter * turn / 4);
    const Vec3 expected(radius * std::sin(quarter * pi / 2), radius * (1 - std::cos(quarter * pi / 2)), 0);
    CHECK((vec(s.particles.position[0]) - expected).norm() < 1e-6 * radius);
    CHECK(vec(s.particles.velocity[0]).norm() == Approx(speed).epsilon(1e-9));
  }
  s.measure_energy();
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
}

TEST_CASE("the drag of a smooth sphere meets the measured drag curve and Stokes' law", "[medium]") {
  // Lapple & Shepherd (1940), table of the drag coefficient of spheres against the Reynolds number. Schiller and Naumann's fit is good to 5 %
  // up to 800; at the end of Newton's range the curve itself scatters by more.
  struct Point {
    double reynolds, drag, tolerance;
  };
  constexpr Point points[] = {{0.1, 240, 0.04}, {1, 26.5, 0.05}, {2, 14.4, 0.05}, {5, 6.9, 0.05}, {10, 4.1, 0.05}, {20, 2.55, 0.05}, {50, 1.5, 0.05}, {100, 1.07, 0.05},
                              {200, 0.77, 0.05}, {500, 0.55, 0.05}, {700, 0.50, 0.06}, {1e3, 0.46, 0.06}, {1e4, 0.40, 0.11}, {1e5, 0.48, 0.11}};
  const double d = 1e-3, air = 1.2, viscosity = 1.8e-5;
  const SphereDrag drag{1, air, viscosity};
  const auto force = [&](double reynolds) {
    const double speed = reynolds * viscosity / (air * d);
    const FieldLoad load = drag(Quad{0, 0, 0, 0.5 * d}, Quad{0, speed, 0, 1}, Quad{0, 0, 0, 1});
    CHECK(load.force.x() == 0);
    return std::pair(-load.force.y(), speed);
  };
  for (const Point& point : points) {
    const auto [found, speed] = force(point.reynolds);
    CAPTURE(point.reynolds);
    CHECK(found / (0.5 * air * pi / 4 * d * d * speed * speed) == Approx(point.drag).epsilon(point.tolerance));
  }
  const auto [creeping, slow] = force(1e-6);
  CHECK(creeping == Approx(3 * pi * viscosity * d * slow).epsilon(2e-5));
  CHECK(force(0).first == 0);
  // Where the two branches meet nothing jumps.
  for (double reynolds = 900; reynolds < 1100; reynolds *= 1.0001) CHECK(force(1.0001 * reynolds).first / force(reynolds).first < 1.00021);
}

TEST_CASE("with forces that depend on velocity half the step has a quarter of the error", "[medium]") {
  const double density = 2600, water = 998, d = 0.01;
  const auto fall = [&](int steps) {
    Simulation s = alone(density, 0.2 / steps, {SphereDrag{1, water, 0.05}, Buoyancy{water, {0, 0, -g}}, Magnus{1, water}}, d);
    s.carried_density = 0.5 * water;
    s.particles.velocity[0].x = 0.5;
    s.particles.spin[0].y = 20;
    s.start(false);
    run_to(s, 0.2);
    return std::pair(vec(s.particles.position[0]), vec(s.particles.velocity[0]));
  };
  const auto exact = fall(51200);
  double error = 0, error_of_velocity = 0;
  for (const int steps : {200, 400, 800, 1600}) {
    const auto found = fall(steps);
    const double now = (found.first - exact.first).norm(), of_velocity = (found.second - exact.second).norm();
    CAPTURE(steps);
    if (error > 0) {
      CHECK(error / now == Approx(4).epsilon(0.05));
      CHECK(error_of_velocity / of_velocity == Approx(4).epsilon(0.05));
    }
    error = now, error_of_velocity = of_velocity;
  }
}

TEST_CASE("the ledger of a ball that bounces under water closes, and the fluid that moves with it counts", "[medium]") {
  const double water = 998;
  Simulation s = alone(2600, 5e-6, {AirDrag{0.44, water}, ViscousDrag{1e-3}, Buoyancy{water, {0, 0, -g}}, Magnus{0.5, water}}, 0.01);
  s.carried_density = 0.5 * water;
  scene::add_floor(s);
  s.particles.position[0].z = 0.05;
  s.particles.velocity[0].x = 0.3;
  s.particles.spin[0].y = 30;
  s.start(false);
  double lowest = 1;
  for (int k = 0; k < 200000; ++k) {
    s.step();
    lowest = std::min(lowest, s.particles.position[0].z);
    if (k % 1000 != 0) continue;
    s.measure_energy();
    CHECK(std::abs(s.ledger.gap()) < 1e-3 * s.ledger.exchanged);
  }
  CHECK(lowest < 0.005);
  CHECK(s.ledger.normal_loss > 0);
  CHECK(s.ledger.field_work < 0);
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
}

TEST_CASE("the closure holds at the recommended step of a drag that limits it", "[medium]") {
  Simulation s = alone(2500, 1, {ViscousDrag{1.4}});
  s.pair_laws = {scene::linear(1, 0.9, 0.3)};  // soft: contacts limit nothing
  s.particles.velocity[0].x = 1;
  const double mass = s.particles.mass(0), time_constant = mass / (3 * pi * 1.4 * 2e-3);
  const TimeStepLimit limit = time_step_limit(s, 2, 0.2);
  CHECK(limit.limit == Approx(time_constant / 5));
  CHECK_THAT(limit.reason, Catch::Contains("viscous_drag"));
  CHECK(limit.recommended == Approx(time_constant / 20));
  s.clock.time_step = limit.recommended;
  s.start(false);
  run_to(s, 20 * time_constant);
  s.measure_energy();
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
  CHECK(vec(s.particles.velocity[0]).x() < 1e-6);
  // Air drag limits it by the speed that is to be expected; added mass slows what drag can do.
  Simulation air = alone(2500, 1, {AirDrag{50, 1000}});
  air.pair_laws = s.pair_laws;
  CHECK(time_step_limit(air, 2, 0.2).limit == Approx(mass / (50 * 1000 * pi * 1e-6 * 2) / 5));
  air.carried_density = 2500;
  CHECK(time_step_limit(air, 2, 0.2).limit == Approx(2 * mass / (50 * 1000 * pi * 1e-6 * 2) / 5));
}

namespace {

// Many balls in water above a floor, spinning.
Simulation cloud(int threads, const Kernels& kernels) {
  const double water = 998;
  Simulation s = scene::free_space({"glass", 2500, 5e7, 0.3}, scene::hertz({"glass", 2500, 5e7, 0.3}, {"glass", 2500, 5e7, 0.3}, 0.6, 0.4), 1e-5);
  s.gravity = {0, 0, -g};
  s.fields = {SphereDrag{1, water, 1e-3}, ViscousDrag{1e-3}, Buoyancy{water, {0, 0, -g}}, Magnus{1, water},
              TableForce{"wind", TableForce::Variable::time, TableForce::Direction::x, {0, 0.02}, {0, 1e-4}}};
  s.carried_density = 0.5 * water;
  scene::add_floor(s);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 5; ++z) scene::add_ball(s, {0.0041 * x + 1e-4 * z, 0.0041 * y, 0.0021 + 0.0041 * z}, (x + y) % 2 ? 0.002 : 0.0015, {0, 0, -0.1 - 0.3 * z}, {0, 10.0 * x, 5.0 * y});
  s.team = std::make_shared<ThreadTeam>(threads);
  s.kernels = &kernels;
  return s;
}

std::string state_of(Simulation& s) {
  return ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
}

}  // namespace

TEST_CASE("fields give the same bits for any threads and instruction set, and after a break", "[medium]") {
  Simulation first = cloud(1, best_kernels());
  first.start(true);
  for (int k = 0; k < 400; ++k) first.step();
  const std::string midway = state_of(first);
  CHECK(first.contacts.sums.pair_contacts + first.contacts.sums.wall_contacts > 20);
  for (int k = 0; k < 400; ++k) first.step();
  const std::string end = state_of(first);
  Simulation threads = cloud(2, best_kernels()), portable = cloud(2, *find_kernels("portable"));
  for (Simulation* s : {&threads, &portable}) {
    s->start(true);
    for (int k = 0; k < 800; ++k) s->step();
    CHECK(std::memcmp(s->particles.position.data(), first.particles.position.data(), first.particles.position.size() * sizeof(Quad)) == 0);
    CHECK(s->ledger.field_work == first.ledger.field_work);
  }
  Simulation resumed = cloud(2, best_kernels());
  resumed.start(true);
  ArchiveReader reader(midway);
  archive_state(reader, resumed);
  for (int k = 0; k < 400; ++k) resumed.step();
  CHECK(state_of(resumed) == end);
}
