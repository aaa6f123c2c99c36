// What frames and pictures show of particles that are no spheres.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "src/base/random.hpp"
#include "src/observe/seat.hpp"
#include "src/output/shape_surfaces.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

Rotation random_turn(RandomStream& random) { return Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized(); }

// A ball, then one of each shape at twice its size, far apart and turned.
Simulation shapes_apart(RandomStream& random) {
  Simulation s = scene::free_space(scene::glass(), scene::hertz(scene::glass(), scene::glass(), 0.9, 0.3), 1e-6);
  s.shapes = {make_superquadric({1, 1, 1}, 2, 2), make_superquadric({9e-3, 7.5e-3, 6.25e-3}, 2, 2), make_superquadric({4e-3, 4e-3, 4e-3}, 8, 8),
              make_superquadric({2e-3, 2e-3, 6e-3}, 8, 2)};
  scene::add_ball(s, {0, 0, 0}, 5e-3, {0, 0, 0});
  for (std::uint8_t k = 1; k < s.shapes.size(); ++k) {
    const Index row = s.particles.add_shape({0.1 * k, 0.01, -0.02}, s.shapes[k], k, 2, s.materials[0].density, 0, 0);
    const Rotation turn = random_turn(random);
    s.particles.orientation[static_cast<std::size_t>(row)] = {turn.x(), turn.y(), turn.z(), turn.w()};
  }
  return s;
}

bool all(std::size_t) { return true; }

}  // namespace

TEST_CASE("the surfaces that are drawn of superquadrics enclose their volume and reach as far as they do, not as their bounding balls", "[shape_pictures]") {
  RandomStream random(41);
  const Simulation s = shapes_apart(random);
  const ShapeSurfaces surfaces = shape_surfaces(s, 16, all);
  std::vector<double> volume(4);
  for (const auto& t : surfaces.triangles) {
    const auto p = [&](int k) { return surfaces.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
    const std::size_t of = surfaces.particle[static_cast<std::size_t>(t[0])];
    const Vec3 centre = vec(s.particles.position[of]);
    volume[of] += (p(0) - centre).dot((p(1) - centre).cross(p(2) - centre)) / 6;
  }
  CHECK(volume[0] == 0);  // the ball is drawn as one
  CHECK(reach(s, 0, Vec3::UnitX()) == 5e-3);
  for (std::size_t k = 1; k < 4; ++k) {
    CAPTURE(k);
    CHECK(volume[k] == Approx(8 * s.shapes[k].volume).epsilon(0.01));
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3 n = random_turn(random) * Vec3::UnitX();
      double farthest = 0;
      for (std::size_t i = 0; i < surfaces.points.size(); ++i)
        if (surfaces.particle[i] == k) farthest = std::max(farthest, n.dot(surfaces.points[i] - vec(s.particles.position[k])));
      CHECK(farthest == Approx(reach(s, k, n)).epsilon(0.02));
      CHECK(farthest < (1 + 1e-12) * reach(s, k, n));
    }
    const Vec3 least = rotation_of(s.particles.orientation[k]) * (k == 1 ? Vec3::UnitZ() : Vec3::UnitX());
    CHECK(reach(s, k, least) == Approx(2 * s.shapes[k].semi_axes().minCoeff()).epsilon(1e-12));
  }
  for (std::size_t i = 0; i < surfaces.points.size(); ++i) {
    const Vec3 out = surfaces.points[i] - vec(s.particles.position[surfaces.particle[i]]);
    CHECK(surfaces.normals[i].dot(out) == Approx(reach(s, surfaces.particle[i], surfaces.normals[i])).epsilon(1e-6));
  }
  for (const std::size_t of : shape_surfaces(s, 4, [](std::size_t row) { return row == 2; }).particle) CHECK(of == 2);
}

TEST_CASE("superquadrics in the picture of a vial stand to it as in the mill", "[shape_pictures]") {
  RandomStream random(42);
  PlanetaryMill mill;
  mill.disc_diameter = 0.14, mill.vial_diameter = 0.05, mill.vial_length = 0.04, mill.vials = 1, mill.speed = 26;
  Simulation s = shapes_apart(random);
  s.clock.step = 70000;  // 104° of the disc's turn
  const Pose vial = vial_pose(mill, 0), disc = disc_pose(mill, s.clock.time());
  for (std::size_t k = 0; k < 4; ++k) set(s.particles.position[k], disc.to_fixed(Vec3(vial.origin + 1e-3 * Vec3(static_cast<double>(k), 0, 0))));
  const Simulation seen = first_vial(s, mill);
  REQUIRE(seen.particles.owned == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(seen.particles.mass(static_cast<Index>(k)) == Approx(s.particles.mass(static_cast<Index>(k))).epsilon(1e-12));
    for (int trial = 0; trial < 5; ++trial) {
      const Vec3 n = random_turn(random) * Vec3::UnitX();
      CHECK(reach(seen, k, n) == Approx(reach(s, k, disc.axes * n)).epsilon(1e-12));
    }
  }
}
