// Superquadrics against cylinders and triangles, held against all places of their surfaces.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "src/base/random.hpp"
#include "src/wall/shape_walls.hpp"

using namespace quern;

namespace {

Mat3 random_axes(RandomStream& random) { return Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix(); }

Superquadric random_shape(RandomStream& random) {
  const auto axis = [&] { return 1e-3 * std::pow(3.0, random.uniform()); };
  const auto exponent = [&] { return 2 * std::pow(10.0, random.uniform()); };
  return make_superquadric({axis(), axis(), axis()}, exponent(), exponent());
}

Wall mesh_wall(std::vector<Vec3> vertices, std::vector<std::array<Index, 3>> triangles) {
  Wall wall;
  wall.name = "mesh";
  wall.surface = make_mesh(std::move(vertices), std::move(triangles));
  return wall;
}

// The square |x|, |y| ≤ half of the plane z = 0, in cells × cells cells.
Wall floor_of_triangles(double half, int cells) {
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) vertices.emplace_back(half * (2.0 * i / cells - 1), half * (2.0 * j / cells - 1), 0);
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Index a = i * (cells + 1) + j, b = a + cells + 1;
      triangles.push_back({a, b, a + 1});
      triangles.push_back({b, b + 1, a + 1});
    }
  return mesh_wall(std::move(vertices), std::move(triangles));
}

}  // namespace

TEST_CASE("a superquadric in a drum touches it with its place farthest from the axis", "[shape_walls]") {
  RandomStream random(21);
  constexpr double radius = 30e-3;
  int touching = 0, twice = 0;
  for (int k = 0; k < 300; ++k) {
    const Superquadric shape = random_shape(random);
    const double angle = random.uniform(0, 2 * std::numbers::pi), off = radius - random.uniform(0.7, 1) * shape.bounding_radius;
    const PlacedShape body{&shape, 1, {off * std::cos(angle), off * std::sin(angle), 0}, random_axes(random)};
    double farthest = 0;
    for (const Vec3& p : surface_mesh(shape, 60).points) farthest = std::max(farthest, (body.centre + body.axes * p).head<2>().norm());
    ShapeContact contacts[most_places];
    double gap = 0;
    const int count = touch_inside_cylinder(body, radius, contacts, gap);
    if (count == 0) CHECK(farthest <= radius - gap);
    twice += count > 1;
    if (farthest > radius) REQUIRE(count > 0);
    double overlap = 0;
    for (int c = 0; c < count; ++c) {
      ++touching;
      overlap = std::max(overlap, contacts[c].overlap);
      CHECK(contacts[c].on_first.head<2>().norm() == Approx(radius + contacts[c].overlap).epsilon(1e-12));
      CHECK(contacts[c].on_second.head<2>().norm() == Approx(radius).epsilon(1e-12));
      CHECK(shape.gauge.value(body.axes.transpose() * (contacts[c].on_first - body.centre)) == Approx(1).epsilon(1e-9));
      CHECK(contacts[c].residual < 1e-8 * shape.volume_radius);
    }
    if (count > 0) CHECK(overlap > farthest - radius - 1e-12 * radius);
    if (count > 0) CHECK(overlap < farthest - radius + 2e-3 * shape.bounding_radius);
  }
  CHECK(touching > 50);
  // A plate across the lowest line leans on two edges.
  const Superquadric plate = make_superquadric({8e-3, 2e-3, 2e-3}, 8, 8);
  ShapeContact contacts[most_places];
  double gap = 1;
  CHECK(touch_inside_cylinder({&plate, 1, {0, -27.4e-3, 0}, Mat3::Identity()}, radius, contacts, gap) == 2);
  CHECK(gap == 0);
}

TEST_CASE("a superquadric outside a shaft touches it where it is nearest to the axis", "[shape_walls]") {
  RandomStream random(22);
  for (int k = 0; k < 200; ++k) {
    const Superquadric shape = random_shape(random);
    constexpr double radius = 5e-3;
    const double off = radius + random.uniform(0.7, 1) * shape.bounding_radius;
    const PlacedShape body{&shape, 1, {off, 0, 1e-3}, random_axes(random)};
    double nearest = 1;
    for (const Vec3& p : surface_mesh(shape, 60).points) nearest = std::min(nearest, (body.centre + body.axes * p).head<2>().norm());
    const ShapeContact c = touch_outside_cylinder(body, radius);
    if (nearest < radius) CHECK(c.touching);
    if (c.touching) CHECK(std::abs(c.overlap - (radius - nearest)) < 2e-3 * shape.bounding_radius);
  }
}

TEST_CASE("a superquadric on a plane of triangles feels the plane", "[shape_walls]") {
  RandomStream random(23);
  const Wall fine = floor_of_triangles(20e-3, 37);
  Wall plane;
  plane.name = "plane";
  plane.surface = Plane{};
  for (int k = 0; k < 500; ++k) {
    const Superquadric shape = random_shape(random);
    PlacedShape body{&shape, 1, {random.uniform(-5e-3, 5e-3), random.uniform(-5e-3, 5e-3), 0}, random_axes(random)};
    body.centre.z() = shape.support.value(body.axes.transpose() * Vec3::UnitZ()) - random.uniform(-0.01, 0.03) * shape.volume_radius;
    ShapeContact on_plane[most_places], on_mesh[most_places];
    const int count = touch_shape(plane, body, on_plane);
    REQUIRE(touch_shape(fine, body, on_mesh) == count);
    if (count == 0) continue;
    CHECK(on_mesh[0].overlap == Approx(on_plane[0].overlap).epsilon(1e-9));
    CHECK((on_mesh[0].normal - on_plane[0].normal).norm() < 1e-9);
    CHECK((on_mesh[0].on_second - on_plane[0].on_second).norm() < 1e-9 * shape.volume_radius);
  }
}

TEST_CASE("a ball as a superquadric touches edges and corners of a mesh as a ball does", "[shape_walls]") {
  RandomStream random(24);
  const Superquadric ball = make_superquadric({2e-3, 2e-3, 2e-3}, 2, 2);
  const Wall triangle = mesh_wall({{0, 0, 0}, {6e-3, 0, 0}, {0, 5e-3, 0}}, {{0, 1, 2}});
  int touching = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 centre(random.uniform(-2e-3, 7e-3), random.uniform(-2e-3, 6e-3), random.uniform(1e-3, 2.1e-3));
    Touch touches[most_touches];
    const int expected = touch_wall(triangle, centre, 2e-3, touches);
    ShapeContact contacts[most_places];
    REQUIRE(touch_shape(triangle, {&ball, 1, centre, random_axes(random)}, contacts) == expected);
    if (expected == 0) continue;
    ++touching;
    CHECK(contacts[0].overlap == Approx(2e-3 - touches[0].distance).margin(1e-10 * 2e-3));
    CHECK((contacts[0].normal - touches[0].normal).norm() < 1e-7);
    CHECK((contacts[0].on_second - touches[0].point).norm() < 1e-7 * 2e-3);
  }
  CHECK(touching > 500);
}

TEST_CASE("a ball as a superquadric touches face and edges of a disc with a hole as a ball does", "[shape_walls]") {
  RandomStream random(25);
  const Superquadric ball = make_superquadric({2e-3, 2e-3, 2e-3}, 2, 2);
  Wall disc;
  disc.name = "disc";
  disc.surface = Revolved{3e-3, 1e-3, 8e-3, 1e-3, Revolved::Side::both};
  int at_edges = 0;
  for (int k = 0; k < 5000; ++k) {
    const double off = random.uniform(0.5e-3, 10.5e-3), angle = random.uniform(-4, 4);
    const Vec3 centre(off * std::cos(angle), off * std::sin(angle), random.uniform(-1.1e-3, 3.1e-3));
    Touch touches[most_touches];
    const int expected = touch_wall(disc, centre, 2e-3, touches);
    ShapeContact contacts[most_places];
    CAPTURE(centre.transpose() * 1e3);
    REQUIRE(touch_shape(disc, {&ball, 1, centre, random_axes(random)}, contacts) == expected);
    if (expected == 0) continue;
    at_edges += off < 3e-3 || off > 8e-3;
    CHECK(contacts[0].overlap == Approx(2e-3 - touches[0].distance).margin(1e-9 * 2e-3));
    CHECK((contacts[0].normal - touches[0].normal).norm() < 1e-6);
    CHECK((contacts[0].on_second - touches[0].point).norm() < 1e-6 * 2e-3);
  }
  CHECK(at_edges > 500);
}

TEST_CASE("a superquadric touches a disc with a hole where the sheet is within it, and nowhere else", "[shape_walls]") {
  RandomStream random(26);
  constexpr double inner = 4e-3, outer = 9e-3;
  Wall disc;
  disc.name = "disc";
  disc.surface = Revolved{inner, 0, outer, 0, Revolved::Side::both};
  int touching = 0, through = 0;
  for (int k = 0; k < 1500; ++k) {
    const Superquadric shape = random_shape(random);
    const double off = random.uniform(0, 12e-3), angle = random.uniform(-4, 4);
    const PlacedShape body{&shape, 1, {off * std::cos(angle), off * std::sin(angle), random.uniform(-1, 1) * shape.bounding_radius}, random_axes(random)};
    double least = 2;
    for (int ring = 0; ring <= 20; ++ring)
      for (int around = 0; around < 240; ++around) {
        const double r = inner + (outer - inner) * ring / 20, turn = 2 * std::numbers::pi * around / 240;
        least = std::min(least, shape.gauge.value(body.axes.transpose() * (Vec3(r * std::cos(turn), r * std::sin(turn), 0) - body.centre)));
      }
    ShapeContact contacts[most_places];
    const int count = touch_shape(disc, body, contacts);
    CAPTURE(least, body.centre.transpose() * 1e3, shape.semi_axes().transpose() * 1e3, shape.n1(), shape.n2());
    if (least < 1) CHECK(count > 0);
    if (least > 1.2) CHECK(count == 0);
    through += count == 0 && std::abs(body.centre.z()) < shape.support.value(body.axes.transpose() * Vec3::UnitZ());
    for (int c = 0; c < count; ++c) {
      ++touching;
      CHECK(std::abs(contacts[c].on_second.z()) < 1e-12);
      CHECK(contacts[c].overlap >= 0);
      CHECK((contacts[c].on_first + contacts[c].overlap * contacts[c].normal - contacts[c].on_second).norm() < 1e-9 * shape.volume_radius);
    }
  }
  CHECK(touching > 300);
  CHECK(through > 50);
}
