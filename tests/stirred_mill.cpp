#include "mills/stirred.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "src/wall/solid.hpp"
#include "src/wall/stl.hpp"
#include "tests/folder.hpp"
#include "tests/scene.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

StirredMill with_discs() {
  StirredMill mill;
  mill.diameter = 0.15, mill.length = 0.15, mill.speed = 40, mill.shaft_diameter = 0.03;
  mill.discs.count = 3, mill.discs.diameter = 0.11, mill.discs.thickness = 0.01;
  mill.discs.holes = 5, mill.discs.hole_diameter = 0.02, mill.discs.hole_circle = 0.07;
  return mill;
}

StirredMill with_pins() {
  StirredMill mill;
  mill.diameter = 0.15, mill.length = 0.15, mill.speed = 40, mill.shaft_diameter = 0.03, mill.clearance = 0.01;
  mill.pins.rows = 4, mill.pins.per_row = 2, mill.pins.diameter = 0.012, mill.pins.tip_circle = 0.12;
  return mill;
}

double volume_of(const Mesh& mesh) {
  double sixfold = 0;
  for (const auto& t : mesh.triangles)
    sixfold += mesh.vertices[static_cast<std::size_t>(t[0])].dot(mesh.vertices[static_cast<std::size_t>(t[1])].cross(mesh.vertices[static_cast<std::size_t>(t[2])]));
  return sixfold / 6;
}

// What a polygon with its corners on a circle has of the circle's area.
double polygon(double diameter, int facets) { return 0.125 * diameter * diameter * facets * std::sin(2 * pi / facets); }

const Material steel{"steel", 7700, 1e9, 0.3};

Simulation in_mill(const StirredMill& mill, const PairLaw& law, double time_step) {
  Simulation s = scene::free_space(steel, law, time_step);
  s.frames = {frame_of(mill)};
  s.walls = walls_of(mill, 0);
  return s;
}

}  // namespace

TEST_CASE("A plate with holes is closed, looks outward and has the volume of its polygons") {
  const std::vector<Outline> holes = {circle(0.01, {0.035, 0}, 24), circle(0.01, {-0.035, 0}, 24), circle(0.004, {0, 0.02}, 11)};
  const Mesh mesh = plate(circle(0.055, {0, 0}, 120), holes, -0.005, 0.005);
  const double expected = 0.01 * (polygon(0.11, 120) - 2 * polygon(0.02, 24) - polygon(0.008, 11));
  CHECK(volume_of(mesh) == Approx(expected).epsilon(1e-12));
  Wall wall;
  wall.surface = mesh;
  const std::vector<Wall> walls{wall};
  const Solids solids(walls);
  CHECK(solids.contain({0.0, 0.05, 0.0}));
  CHECK(solids.contain({0.0, 0.0, 0.004}));
  CHECK_FALSE(solids.contain({0.035, 0.002, 0.0}));
  CHECK_FALSE(solids.contain({0.0, 0.02, 0.0}));
  CHECK_FALSE(solids.contain({0.0, 0.05, 0.006}));
}

TEST_CASE("A stirrer takes up the volume that its numbers say") {
  for (const StirredMill& mill : {with_discs(), with_pins()}) {
    Wall wall;
    wall.surface = stirrer_mesh(mill);
    const std::vector<Wall> walls{wall};
  const Solids solids(walls);
    RandomStream random(3);
    const double radius = 0.5 * mill.diameter;
    int inside = 0, all = 0;
    for (int k = 0; k < 40000; ++k) {
      const Vec3 place(random.uniform(-radius, radius), random.uniform(-radius, radius), random.uniform(-0.5, 0.5) * mill.length);
      if (std::hypot(place.x(), place.y()) > radius) continue;
      ++all;
      inside += solids.contain(place) ? 1 : 0;
    }
    const double vessel = 0.25 * pi * mill.diameter * mill.diameter * mill.length, share = 1 - volume(mill) / vessel;
    // Four standard errors of the count; the polygons' shortfall is a tenth of that.
    CHECK(static_cast<double>(inside) / all == Approx(share).margin(4 * std::sqrt(share / all)));
  }
}

TEST_CASE("A disc that turns under a ball brakes by the ball's weight times friction times radius") {
  constexpr double friction = 0.4, radius = 0.005, arm = 0.045;
  for (const double speed : {30.0, -30.0}) {
    StirredMill mill = with_discs();
    mill.discs.holes = 0;
    mill.speed = speed;
    Simulation s = in_mill(mill, scene::linear(1e5, 0.1, friction), 2e-6);
    s.gravity = Vec3(0, 0, -9.81);
    scene::add_ball(s, {arm, 0, 0.005 + radius}, radius, {0, 0, 0});  // on the middle disc
    s.start(false);
    double torque = 0;
    int samples = 0;
    for (int step = 0; step < 5000; ++step) {
      s.step();
      if (step < 2500) continue;  // until it rests in its contact
      torque += s.walls.back().torque.z, ++samples;
    }
    const double weight = s.particles.mass(0) * 9.81;
    CHECK(torque / samples == Approx(-std::copysign(friction * weight * arm, speed)).epsilon(0.005));
    // It moves with the disc, no farther than friction can have carried it.
    CHECK(s.particles.velocity[0].y == Approx(std::copysign(friction * 9.81 * s.clock.time(), speed)).epsilon(0.05));
  }
}

TEST_CASE("A ball falls through the hole of a disc and lies on what is solid") {
  StirredMill mill = with_discs();
  mill.speed = 0;
  for (const bool over_hole : {true, false}) {
    Simulation s = in_mill(mill, scene::linear(1e5, 0.3, 0.3), 5e-6);
    s.gravity = Vec3(0, 0, -9.81);
    const double angle = over_hole ? 0 : pi / 5;
    scene::add_ball(s, {0.035 * std::cos(angle), 0.035 * std::sin(angle), 0.015}, 0.005, {0, 0, 0});
    s.start(false);
    while (s.clock.time() < 0.09) s.step();
    const double z = s.particles.position[0].z;
    if (over_hole) CHECK(z < -0.015);
    else CHECK(z == Approx(0.01).margin(1e-5));
  }
}

TEST_CASE("A pin throws a ball that lies in its way at twice its own speed") {
  StirredMill mill = with_pins();
  const Mesh mesh = stirrer_mesh(mill);
  Simulation s = in_mill(mill, scene::linear(1e6, 1.0, 0.0), 2e-7);
  constexpr double radius = 0.006, arm = 0.045;
  // At the height of the second row, whose first pin is turned by a quarter; the ball waits a little ahead of it.
  const double z = -0.5 * 0.03, ahead = pi / 2 + 0.4;
  scene::add_ball(s, {arm * std::cos(ahead), arm * std::sin(ahead), z}, radius, {0, 0, 0});
  s.start(false);
  scene::run_collision(s);
  const Vec3 velocity = vec(s.particles.velocity[0]);
  // The pin's side moves at ω times the distance of the contact along the pin; reach² = arm² − (sum of radii)².
  const double sum = radius + 0.5 * mill.pins.diameter, reach = std::sqrt(arm * arm - sum * sum);
  CHECK(velocity.norm() == Approx(2 * mill.speed * reach).epsilon(0.005));
  CHECK(std::abs(velocity.z()) < 0.01 * velocity.norm());
}

TEST_CASE("A stirred mill gives its charge what its drive delivers, and its walls hold it") {
  const std::string file = std::string(quern::source_directory) + "/cases/stirred_power/case.toml";
  const Case c = read_case(file, {"duration=0.1", "species.bead.diameter=0.012", "mill.ramp=0.02", "observe.start=0.05"});
  const Built built = build_case(c);
  CHECK(built.filling == Approx(0.4).epsilon(0.01));
  Simulation s = built.simulation;
  s.start(false);
  double drive = 0;
  while (s.clock.time() < 0.1) {
    s.step();
    drive -= s.clock.time_step * vec(s.walls.back().torque).dot(s.walls.back().pose.angular_velocity);
  }
  s.measure_energy();
  CHECK(drive > 0);
  CHECK(s.ledger.wall_work == Approx(drive).epsilon(1e-9));
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
  const Pose pose = pose_of(*c.stirred);
  for (Index i = 0; i < s.particles.owned; ++i) {
    const Vec3 own = pose.to_local(vec(s.particles.position[static_cast<std::size_t>(i)]));
    REQUIRE(std::hypot(own.x(), own.y()) < 0.075);
    REQUIRE(std::abs(own.z()) < 0.075);
  }
}

TEST_CASE("A stirrer read from an STL file is the stirrer that was written") {
  const Folder folder("stirrer");
  const StirredMill mill = with_pins();
  write_stl(folder.path / "stirrer.stl", stirrer_mesh(mill));
  const std::string file = folder.write("case.toml", R"(
duration = 1
[material.steel]
density = 7700
young = "1 GPa"
[pair.steel.steel]
restitution = 0.3
[mill]
type = "stirred"
diameter = "150 mm"
length = "150 mm"
speed = "100 rpm"
stirrer_file = "stirrer.stl"
[species.ball]
material = "steel"
diameter = "20 mm"
[insert.balls]
species = "ball"
filling = 0.1
)");
  const Built built = build_case(read_case(file));
  const Mesh& read = stirrer_of(built.simulation.walls);
  CHECK(volume_of(read) == Approx(volume_of(stirrer_mesh(mill))).epsilon(1e-5));  // a binary STL has floats
  CHECK(tip_radius(read) == Approx(std::hypot(0.5 * mill.pins.tip_circle, 0.5 * mill.pins.diameter)).epsilon(1e-5));
  CHECK(built.simulation.walls.back().frame == 0);
}

TEST_CASE("A stirred mill that cannot be is refused") {
  const auto refused = [](StirredMill mill, auto change) {
    CHECK_NOTHROW(check(mill));
    change(mill);
    CHECK_THROWS_AS(check(mill), InputError);
  };
  refused(with_discs(), [](StirredMill& m) { m.discs.diameter = 0.15; });
  refused(with_discs(), [](StirredMill& m) { m.discs.thickness = 0.04; });      // the discs meet
  refused(with_discs(), [](StirredMill& m) { m.discs.spacing = 0.08; });        // and reach beyond the vessel
  refused(with_discs(), [](StirredMill& m) { m.discs.hole_circle = 0.095; });   // through the rim
  refused(with_discs(), [](StirredMill& m) { m.discs.holes = 12; });            // the holes meet
  refused(with_discs(), [](StirredMill& m) { m.shaft_diameter = 0; });
  refused(with_discs(), [](StirredMill& m) { m.ramp = -1; });
  refused(with_pins(), [](StirredMill& m) { m.pins.per_row = 12; });            // they meet at the shaft
  refused(with_pins(), [](StirredMill& m) { m.pins.tip_circle = 0.16; });
  refused(with_pins(), [](StirredMill& m) { m.clearance = 0.06; });             // a row below the shaft's end
}
