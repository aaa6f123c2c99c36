// Superquadrics of several sizes: one shape, its proportions the semi-axes', and diameters of the balls of the same volume.
#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <cmath>
#include <numbers>
#include "src/case/build.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

const std::string heading = R"(
duration = "0.1 s"
time_step.value = 5e-6
[material.stone]
density = 2500
young = "10 MPa"
[pair.default]
restitution = 0.6
friction = 0.4
[wall.floor]
type = "plane"
material = "stone"
[species.grain]
material = "stone"
shape = "superquadric"
exponents = [4, 3]
)";

Simulation built(const std::string& rest) {
  const Folder folder("shape_sizes");
  folder.write("grains.csv", "x [mm],y [mm],z [mm],diameter [mm]\n0,0,20,8\n30,0,20,12\n");
  return build(read_case(folder.write("case.toml", heading + rest)));
}

double ball(double diameter) { return std::numbers::pi / 6 * diameter * diameter * diameter; }

}  // namespace

TEST_CASE("a size distribution of superquadrics tells the balls of their volumes, and each keeps its proportions", "[shape_sizes]") {
  const Simulation s = built(R"(
semi_axes = ["6 mm", "5 mm", "4 mm"]
diameters = ["8 mm", "12 mm"]
counts = [3, 1]
[insert.grains]
species = "grain"
count = 40
region = {shape = "box", centre = [0, 0, 0.1], size = [0.1, 0.1, 0.18]}
)");
  REQUIRE(s.shapes.size() == 2);
  const Superquadric& shape = s.shapes[1];
  int small = 0;
  for (std::size_t k = 0; k < 40; ++k) {
    const double mass = s.particles.velocity[k].w, diameter = mass < 2500 * ball(10e-3) ? 8e-3 : 12e-3, size = 0.5 * diameter / shape.volume_radius;
    small += diameter == 8e-3;
    CHECK(mass == Approx(2500 * ball(diameter)).epsilon(1e-12));
    CHECK(s.particles.position[k].w == Approx(size * shape.bounding_radius).epsilon(1e-12));
    CHECK(s.particles.inertia[k].x == Approx(2500 * std::pow(size, 5) * shape.inertia.x()).epsilon(1e-12));
  }
  CHECK(small == 30);
}

TEST_CASE("a filling of superquadrics of several sizes counts their own volumes", "[shape_sizes]") {
  const Simulation s = built(R"(
semi_axes = ["6 mm", "5 mm", "4 mm"]
diameters = ["8 mm", "12 mm"]
mass_fractions = [0.5, 0.5]
[insert.grains]
species = "grain"
mass = "100 g"
region = {shape = "box", centre = [0, 0, 0.1], size = [0.1, 0.1, 0.18]}
)");
  double mass = 0, coarse = 0;
  for (const Quad& v : s.particles.velocity) mass += v.w, coarse += v.w > 2500 * ball(10e-3) ? v.w : 0;
  // To the nearest whole number of the mean grain, and of the larger ones.
  CHECK(mass == Approx(0.1).margin(2500 * ball(12e-3)));
  CHECK(coarse == Approx(0.5 * mass).margin(2500 * ball(12e-3)));
}

TEST_CASE("a superquadric of another size moves as one whose semi-axes are told", "[shape_sizes]") {
  const auto dropped = [](const std::string& size, double times) {
    Simulation s = built(fmt::format(R"(
semi_axes = ["{} mm", "{} mm", "{} mm"]
{}
[insert.one]
species = "grain"
positions = [[0, 0, 0.02]]
turn = [0.5, 0.7, 0.1]
)", 6 * times, 5 * times, 4 * times, size));
    s.start(false);
    for (int k = 0; k < 20000; ++k) s.step();
    return s;
  };
  const Simulation told = dropped("", 1.25);
  const Simulation scaled = dropped(fmt::format("diameter = {:.17g}", 2 * told.shapes[1].volume_radius), 1);
  CHECK((vec(told.particles.position[0]) - vec(scaled.particles.position[0])).norm() < 1e-9);
  CHECK(std::abs(told.particles.position[0].x) > 1e-4);  // it has rolled aside
}

TEST_CASE("a table of superquadrics may tell each one's diameter", "[shape_sizes]") {
  const Simulation s = built(R"(
semi_axes = ["6 mm", "5 mm", "4 mm"]
[insert.two]
species = "grain"
method = "list"
file = "grains.csv"
)");
  CHECK(s.particles.velocity[0].w == Approx(2500 * ball(8e-3)).epsilon(1e-12));
  CHECK(s.particles.velocity[1].w == Approx(2500 * ball(12e-3)).epsilon(1e-12));
}
