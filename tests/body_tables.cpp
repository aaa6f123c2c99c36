// Forces on bodies that tables give, and how a case asks for them and for the effects of a medium.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "src/case/build.hpp"
#include "tests/folder.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

using Variable = TableForce::Variable;
using Direction = TableForce::Direction;

constexpr double g = 9.81;

Simulation alone(double time_step, std::vector<Field> fields, const Triple<double>& velocity = {0, 0, 0}, const Triple<double>& spin = {0, 0, 0}) {
  Simulation s = scene::free_space({"ball", 1000, 1e9, 0.3}, scene::linear(1e4, 0.9, 0.3), time_step);
  s.fields = std::move(fields);
  scene::add_ball(s, {0, 0, 0}, 0.01, velocity, spin);
  s.start(false);
  return s;
}

void run_to(Simulation& s, double time) {
  const auto steps = static_cast<std::int64_t>(std::llround(time / s.clock.time_step));
  while (s.clock.step < steps) s.step();
}

template <class Function>
TableForce tabulated(Variable variable, Direction direction, double from, double to, int count, const Function& function) {
  TableForce force{"learnt", variable, direction, {}, {}};
  for (int k = 0; k < count; ++k) {
    force.points.push_back(from + (to - from) * k / (count - 1));
    force.values.push_back(function(force.points.back()));
  }
  return force;
}

}  // namespace

TEST_CASE("a table is linear in between, constant beyond its ends, and knows every variable and direction", "[force]") {
  const Quad position{0.1, -0.2, 0.3, 0.01}, velocity{1, -2, 2, 0.004}, spin{3, 4, 12, 1e-6};
  const auto found = [&](Variable variable, Direction direction, double time = 0.7) {
    return TableForce{"t", variable, direction, {-1, 0.5, 20}, {-3, 0, 39}}.at(time, 1e-9)(position, velocity, spin).force;
  };
  CHECK(found(Variable::x, Direction::x).isApprox(Vec3(-0.8, 0, 0)));
  CHECK(found(Variable::y, Direction::x).isApprox(Vec3(-1.4, 0, 0)));
  CHECK(found(Variable::z, Direction::x).isApprox(Vec3(-0.4, 0, 0)));
  CHECK(found(Variable::vx, Direction::y).isApprox(Vec3(0, 1, 0)));
  CHECK(found(Variable::vy, Direction::y).isApprox(Vec3(0, -3, 0)));
  CHECK(found(Variable::vz, Direction::z).isApprox(Vec3(0, 0, 3)));
  CHECK(found(Variable::time, Direction::z).isApprox(Vec3(0, 0, 0.4)));
  CHECK(found(Variable::time, Direction::z, 99).isApprox(Vec3(0, 0, 39)));
  CHECK(found(Variable::speed, Direction::against_velocity).isApprox(-5 * Vec3(1, -2, 2) / 3));
  const Vec3 lift = Vec3(3, 4, 12).cross(Vec3(1, -2, 2)).normalized();
  CHECK(found(Variable::spin, Direction::lift).isApprox(25 * lift));
}

TEST_CASE("a drag that is tabulated finely falls as the drag itself", "[force]") {
  const double factor = 0.5 * 0.47 * 1.2 * std::numbers::pi * 1e-4;
  Simulation table = alone(1e-4, {tabulated(Variable::speed, Direction::against_velocity, 0, 40, 4001, [&](double v) { return factor * v * v; })}, {5, 0, 0});
  Simulation exact = alone(1e-4, {AirDrag{0.47, 1.2}}, {5, 0, 0});
  for (Simulation* s : {&table, &exact}) s->gravity = {0, 0, -g}, s->start(false), run_to(*s, 3);
  CHECK((vec(table.particles.position[0]) - vec(exact.particles.position[0])).norm() < 1e-6 * vec(exact.particles.position[0]).norm());
  CHECK((vec(table.particles.velocity[0]) - vec(exact.particles.velocity[0])).norm() < 1e-6 * vec(exact.particles.velocity[0]).norm());
  table.measure_energy();
  CHECK(std::abs(table.ledger.closure()) < 1e-6);
}

TEST_CASE("a tabulated spring swings with its frequency and keeps its energy", "[force]") {
  const double stiffness = 40, mass = 4.18879020478639e-3, period = 2 * std::numbers::pi * std::sqrt(mass / stiffness);
  Simulation s = alone(period / 4000, {TableForce{"spring", Variable::z, Direction::z, {-1, 1}, {stiffness, -stiffness}}}, {0, 0, 2});
  run_to(s, 10 * period);
  CHECK(std::abs(s.particles.position[0].z) < 1e-4 * 2 * period);
  CHECK(s.particles.velocity[0].z == Approx(2).epsilon(1e-6));
  s.measure_energy();
  CHECK(std::abs(s.ledger.closure()) < 1e-6);
}

TEST_CASE("a push by time gives its impulse, and a lift by spin turns the way", "[force]") {
  const double mass = 4.18879020478639e-3;
  Simulation push = alone(1e-4, {TableForce{"push", Variable::time, Direction::y, {0.1, 0.2, 0.3}, {0, 0.5, 0}}});
  run_to(push, 0.5);
  CHECK(push.particles.velocity[0].y == Approx(0.05 / mass).epsilon(1e-9));
  const double speed_now = 3, lift = 0.02, radius = mass * speed_now * speed_now / lift;
  Simulation turn = alone(1e-4, {TableForce{"lift", Variable::spin, Direction::lift, {0, 100}, {0, 2 * lift}}}, {speed_now, 0, 0}, {0, 0, 50});
  run_to(turn, 1);
  CHECK((vec(turn.particles.position[0]) - Vec3(0, radius, 0)).norm() == Approx(radius).epsilon(1e-6));
}

TEST_CASE("a torque in proportion to the spin lets it die out, one that is constant ends it", "[force]") {
  const double mass = 4.18879020478639e-3, inertia = 0.4 * mass * 1e-4, time = 0.5;
  const Vec3 spin{10, -20, 40};
  Simulation viscous = alone(1e-4, {TableForce{"oil", Variable::spin, Direction::against_spin, {0, 100}, {0, 100 * inertia / time}}}, {1, 0, 0}, {10, -20, 40});
  run_to(viscous, time);
  CHECK((vec(viscous.particles.spin[0]) - spin * std::exp(-1)).norm() < 1e-4 * spin.norm());
  CHECK(vec(viscous.particles.velocity[0]) == Vec3(1, 0, 0));
  viscous.measure_energy();
  CHECK(std::abs(viscous.ledger.closure()) < 1e-4);
  Simulation dry = alone(1e-4, {TableForce{"bearing", Variable::spin, Direction::against_spin, {0, 1}, {inertia, inertia}}}, {}, {0, 0, 0.5});
  run_to(dry, 0.25);
  CHECK(dry.particles.spin[0].z == Approx(0.25).epsilon(1e-6));
  run_to(dry, 1);
  CHECK(std::abs(dry.particles.spin[0].z) < 1e-9);
}

TEST_CASE("a friction that does not vanish with the speed ends in rest", "[force]") {
  const double mass = 4.18879020478639e-3, friction = 0.3 * mass * g;
  Simulation s = alone(1e-4, {TableForce{"friction", Variable::speed, Direction::against_velocity, {0, 1}, {friction, friction}}}, {1, 1, 0});
  run_to(s, 2);
  CHECK(vec(s.particles.velocity[0]).norm() < 1e-12);
  CHECK(vec(s.particles.position[0]).norm() == Approx(2 / (2 * 0.3 * g)).epsilon(1e-3));
}

namespace {

const char* const plain = R"(
duration = "0.1 s"
[material.plastic]
density = 1100
young = "1e8 Pa"
[pair.default]
restitution = 0.8
[species.ball]
material = "plastic"
diameter = "40 mm"
[insert.one]
species = "ball"
positions = [[0, 0, 1]]
)";

}  // namespace

TEST_CASE("a case turns each effect on by its key, and none without", "[force][case]") {
  const Folder folder("body_forces");
  const std::string file = folder.write("case.toml", plain);
  CHECK(read_case(file).fields.empty());
  CHECK(read_case(file, {"medium.density=1000"}).carried_density == 0);
  const auto with = [&](const std::vector<std::string>& keys) { return build_case(read_case(file, keys)).simulation; };
  const auto air = std::get<AirDrag>(with({"medium.drag_coefficient=0.4"}).fields.at(0));
  CHECK(air.coefficient == 0.4);
  CHECK(air.density == 1.2);
  const auto sphere = std::get<SphereDrag>(with({"medium.drag=schiller_naumann", "medium.drag_coefficient=1", "medium.viscosity=2e-5"}).fields.at(0));
  CHECK(sphere.factor == 1);
  CHECK(sphere.viscosity == 2e-5);
  CHECK(std::get<ViscousDrag>(with({"medium.viscous_drag=1.4"}).fields.at(0)).viscosity == 1.4);
  const auto buoyancy = std::get<Buoyancy>(with({"medium.buoyancy=998"}).fields.at(0));
  CHECK(buoyancy.density == 998);
  CHECK(buoyancy.gravity == Vec3(0, 0, -9.81));
  CHECK(with({"medium.density=998", "medium.added_mass_coefficient=0.5"}).carried_density == 499);
  CHECK(std::get<Magnus>(with({"medium.magnus_coefficient=-0.5"}).fields.at(0)).coefficient == -0.5);
  const auto force = std::get<TableForce>(with({"force.f.variable=spin", "force.f.direction=lift", "force.f.at=[0, 10, 30]", "force.f.values=[0, 1, 5]"}).fields.at(0));
  CHECK(force.variable == Variable::spin);
  CHECK(force.direction == Direction::lift);
  CHECK(force.value(20) == 3);
  CHECK(force.value(50) == 5);
}

TEST_CASE("a drag that would be unstable limits the step of a case", "[force][case]") {
  const Folder folder("strong_drag");
  const std::string file = folder.write("case.toml", plain);
  const double free = build_case(read_case(file)).limit.limit;
  const Built strong = build_case(read_case(file, {"medium.viscous_drag=5000"}));
  CHECK(strong.limit.limit < free);
  CHECK_THAT(strong.limit.reason, Catch::Contains("viscous_drag"));
  Simulation s = strong.simulation;
  s.start(false);
  run_to(s, 0.01);
  CHECK(-s.particles.velocity[0].z == Approx(1100 * 9.81 * 0.04 * 0.04 / (18 * 5000)).epsilon(1e-6));
}
