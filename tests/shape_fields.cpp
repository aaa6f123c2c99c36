// A fluid acts on a superquadric as on the ball of its volume.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

const std::string sinking = R"(
duration = "1 s"
time_step.value = 5e-6
gravity = [0, 0, -9.81]
[material.stone]
density = 2500
young = "10 MPa"
[pair.default]
restitution = 0.5
[species.grain]
material = "stone"
shape = "superquadric"
semi_axes = ["1 mm", "2 mm", "0.5 mm"]
exponents = [8, 4]
[insert.one]
species = "grain"
positions = [[0, 0, 0]]
turn = [0.3, 0.4, 0]
)";

Simulation built(const std::string& rest) {
  const Folder folder("shape_fields");
  return build(read_case(folder.write("case.toml", sinking + rest)));
}

}  // namespace

TEST_CASE("a superquadric sinks in a viscous fluid as the ball of its volume does, and does not turn", "[shape_fields]") {
  constexpr double viscosity = 0.1, fluid = 1000;
  Simulation s = built("[medium]\nviscous_drag = 0.1\nbuoyancy = 1000\n");
  const Superquadric& shape = s.shapes[1];
  CHECK(shape.volume == Approx(4.0 / 3 * std::numbers::pi * std::pow(shape.volume_radius, 3)));
  s.start(false);
  // m v' = (m − ρ V) g − 6π η R v.
  const double mass = 2500 * shape.volume, fading = mass / (6 * std::numbers::pi * viscosity * shape.volume_radius), last = fading * 9.81 * (1 - fluid / 2500);
  for (int k = 1; k <= 20000; ++k) {
    s.step();
    if (k % 1000 != 0) continue;
    const double t = 5e-6 * k;
    CHECK(s.particles.velocity[0].z == Approx(-last * (1 - std::exp(-t / fading))).epsilon(1e-5));
    CHECK(s.particles.position[0].z == Approx(-last * (t - fading * (1 - std::exp(-t / fading)))).epsilon(1e-5));
  }
  CHECK(s.particles.velocity[0].z < -0.9 * last);
  CHECK(length(xyz(s.particles.spin[0])) == 0);
}

TEST_CASE("what is not known of a fluid about superquadrics is refused", "[shape_fields]") {
  CHECK_THROWS_WITH(built("[medium]\ndensity = 1000\nadded_mass_coefficient = 0.5\n"), Catch::Contains("superquadrics") && Catch::Contains("added mass"));
}
