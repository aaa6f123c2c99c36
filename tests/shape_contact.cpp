// Where two superquadrics touch, against searches and certificates that know nothing of how it was found.
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <numbers>
#include "shapes/touching.hpp"
#include "src/base/random.hpp"

using namespace quern;

namespace {

Vec3 random_direction(RandomStream& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi), ring = std::sqrt(1 - z * z);
  return {ring * std::cos(angle), ring * std::sin(angle), z};
}

Mat3 random_axes(RandomStream& random) { return Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix(); }

Superquadric random_shape(RandomStream& random, double largest_exponent) {
  const auto axis = [&] { return 1e-3 * std::pow(5.0, random.uniform()); };
  const auto exponent = [&] { return 2 * std::pow(0.5 * largest_exponent, random.uniform()); };
  return make_superquadric({axis(), axis(), axis()}, exponent(), exponent());
}

Vec3 support(const PlacedShape& s, const Vec3& n) { return s.axes * (s.size * s.shape->support.first(s.axes.transpose() * n).gradient); }

// Two ellipsoids' overlap by search alone: n over a grid of two angles, then a shrinking cross about the best.
struct Ellipsoids {
  Mat3 a, b;  // h = √(nᵀ M n)
  Vec3 apart;
  double overlap(const Vec3& n) const { return std::sqrt(n.dot(a * n)) + std::sqrt(n.dot(b * n)) - n.dot(apart); }
  double least() const {
    Vec3 best = Vec3::UnitX();
    double least = overlap(best);
    constexpr int rings = 12;
    for (int i = 0; i < rings; ++i) {
      const double z = -1 + (2 * i + 1.0) / rings, ring = std::sqrt(1 - z * z);
      for (int j = 0; j < 2 * rings; ++j) {
        const double angle = std::numbers::pi * j / rings;
        const Vec3 n(ring * std::cos(angle), ring * std::sin(angle), z);
        if (const double value = overlap(n); value < least) least = value, best = n;
      }
    }
    for (double step = 0.2; step > 1e-6;) {
      const Vec3 u = best.unitOrthogonal(), v = best.cross(u);
      bool moved = false;
      for (const Vec3& way : {u, Vec3(-u), v, Vec3(-v)}) {
        const Vec3 n = (best + step * way).normalized();
        if (const double value = overlap(n); value < least) least = value, best = n, moved = true;
      }
      if (!moved) step *= 0.5;
    }
    return least;
  }
};

void compare_ellipsoids(int pairs, double seconds) {
  RandomStream random(11);
  const auto begin = std::chrono::steady_clock::now();
  const auto ellipsoid_matrix = [](const PlacedShape& s) -> Mat3 { return s.axes * s.shape->semi_axes().cwiseAbs2().asDiagonal() * s.axes.transpose(); };
  int touching = 0, done = 0;
  double worst = 0;
  for (; done < pairs && std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < seconds; ++done) {
    const Superquadric a = random_shape(random, 2), b = random_shape(random, 2);
    PlacedShape first{&a, 1, Vec3::Zero(), random_axes(random)}, second{&b, 1, 1e-3 * random_direction(random), random_axes(random)};
    const double size = std::min(a.volume_radius, b.volume_radius);
    const Vec3 n = random_direction(random);
    first.centre = second.centre + support(first, n) + support(second, n) - random.uniform(-0.1, 0.1) * size * n;
    const double expected = Ellipsoids{ellipsoid_matrix(first), ellipsoid_matrix(second), first.centre - second.centre}.least();
    const ShapeContact found = touch(first, second);
    if (std::abs(expected) > 1e-9 * size && found.touching != (expected > 0)) FAIL("pair " << done << " is missed or false, overlap " << expected);
    if (!found.touching) continue;
    ++touching;
    worst = std::max(worst, std::abs(found.overlap - expected) / size);
  }
  CHECK(worst < 1e-6);
  CHECK(touching > done / 3);
  CHECK(done > 1000);
}

}  // namespace

TEST_CASE("the overlap of ellipsoids is the one that a search over all directions finds", "[shape_contact]") { compare_ellipsoids(40000, 10); }
TEST_CASE("the overlap of ellipsoids is the one that a search finds, 100,000 pairs", "[.][shape_contact_all]") { compare_ellipsoids(100000, 1e9); }

TEST_CASE("spheres as superquadrics touch as spheres do", "[shape_contact]") {
  const Superquadric ball = make_superquadric({1, 1, 1}, 2, 2);
  RandomStream random(12);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 n = random_direction(random);
    const PlacedShape first{&ball, 2e-3, Vec3::Zero(), random_axes(random)}, second{&ball, 3e-3, -4.99e-3 * n, random_axes(random)};
    for (const ShapeContact& c : {touch(first, second), touch_from(first, second, (n + 0.1 * random_direction(random)).normalized())}) {
      REQUIRE(c.touching);
      CHECK(c.overlap == Approx(1e-5).epsilon(1e-10));
      CHECK((c.normal - n).norm() < 1e-13);
      CHECK((c.on_first + 2e-3 * n).norm() < 1e-15);
      CHECK(c.radius_first == Approx(2e-3).epsilon(1e-12));
      CHECK(c.radius_second == Approx(3e-3).epsilon(1e-12));
    }
  }
}

TEST_CASE("superquadrics of any exponents and orientations always get an answer that certifies itself", "[shape_contact]") {
  // Apart: a direction along which they are. Touching: each one's deepest place lies in the other, so that they share a place.
  RandomStream random(13);
  int touching = 0;
  for (int k = 0; k < 20000; ++k) {
    const Superquadric a = random_shape(random, 20), b = random_shape(random, 20);
    const double size = std::min(a.volume_radius, b.volume_radius);
    PlacedShape first{&a, 1, Vec3::Zero(), random_axes(random)}, second{&b, 1, Vec3::Zero(), random_axes(random)};
    Vec3 n = random_direction(random);
    if (k % 2 == 0) {
      // Faces and edges on each other, parallel up to a tilt of any smallness.
      const Vec3 axis = random_direction(random);
      second.axes = Eigen::AngleAxisd(std::pow(10.0, random.uniform(-18, -0.5)), axis).toRotationMatrix() * first.axes;
      n = first.axes * a.normal(random_direction(random).cwiseProduct(a.semi_axes()));
      if (k % 4 == 0) n = first.axes * (Vec3::Unit(k / 4 % 3) + std::pow(10.0, random.uniform(-18, -1)) * random_direction(random)).normalized();
    }
    const double along = random.uniform(-0.04, 0.04) * size;
    first.centre = support(first, n) + support(second, n) - along * n;
    const ShapeContact found = touch(first, second);
    const auto over = [&](const Vec3& m) { return (support(first, m) + support(second, m) - first.centre + second.centre).dot(m); };
    REQUIRE(found.normal.norm() == Approx(1).epsilon(1e-12));
    if (!found.touching) {
      CHECK(over(found.normal) < 0);
      continue;
    }
    ++touching;
    REQUIRE(along > -1e-12 * size);
    CHECK(found.overlap == Approx(over(found.normal)).margin(1e-12 * size));
    CHECK(found.overlap < along + 0.01 * size);
    CHECK(found.uncertainty < 1e-6 * size);
    const auto inside = [](const PlacedShape& s, const Vec3& place) { return s.shape->gauge.value(s.axes.transpose() * (place - s.centre)) / s.size; };
    const Vec3 middle = 0.5 * (found.on_first + found.on_second);
    CHECK(inside(first, middle) < 1 + 1e-6);
    CHECK(inside(second, middle) < 1 + 1e-6);
  }
  CHECK(touching > 5000);
}

TEST_CASE("the overlap changes with the bodies as its normal and deepest places say", "[shape_contact]") {
  // What makes a force along the normal conservative: dδ = −n·(d(place on first) − d(place on second)).
  RandomStream random(14);
  int tried = 0;
  for (int k = 0; k < 3000; ++k) {
    const Superquadric a = random_shape(random, 8), b = random_shape(random, 8);
    const double size = std::min(a.volume_radius, b.volume_radius);
    PlacedShape first{&a, 1, Vec3::Zero(), random_axes(random)}, second{&b, 1, Vec3::Zero(), random_axes(random)};
    const Vec3 n = random_direction(random);
    first.centre = support(first, n) + support(second, n) - 0.003 * size * n;
    const ShapeContact found = touch_from(first, second, n);
    if (!found.touching) continue;
    ++tried;
    const Vec3 shift = 1e-6 * size * random_direction(random), turn = 1e-6 * random_direction(random);
    const auto moved = [&](double sign) {
      PlacedShape other = first;
      other.centre += sign * shift;
      other.axes = Eigen::AngleAxisd(sign * turn.norm(), turn.normalized()).toRotationMatrix() * first.axes;
      return touch_from(other, second, found.normal).overlap;
    };
    const Vec3 path = shift + turn.cross(found.on_first - first.centre);
    CHECK(0.5 * (moved(1) - moved(-1)) == Approx(-found.normal.dot(path)).margin(1e-5 * path.norm()));
  }
  CHECK(tried > 1000);
}

TEST_CASE("a superquadric touches a plane at its lowest place", "[shape_contact]") {
  RandomStream random(15);
  for (int k = 0; k < 50; ++k) {
    const Superquadric shape = random_shape(random, 20);
    const PlacedShape body{&shape, 1, Vec3(1e-3, 2e-3, 3e-3), random_axes(random)};
    const Vec3 n = random_direction(random), place = body.centre - 0.9 * support(body, n).dot(n) * n;
    const ShapeContact c = touch_plane(body, place, n);
    CHECK(c.touching);
    double deepest = -1;
    for (const Vec3& p : surface_mesh(shape, 60).points) deepest = std::max(deepest, -n.dot(body.centre + body.axes * p - place));
    CHECK(deepest <= c.overlap * (1 + 1e-12));
    CHECK(deepest > c.overlap - 2e-3 * shape.bounding_radius);
  }
  // A cube flat on it touches in the middle of its face.
  const Superquadric cube = make_superquadric({1, 1, 1}, 8, 8);
  const ShapeContact flat = touch_plane({&cube, 1, Vec3(0, 0, 0.99), Mat3::Identity()}, Vec3::Zero(), Vec3::UnitZ());
  CHECK(flat.overlap == Approx(0.01).epsilon(1e-12));
  CHECK(flat.on_first.head<2>().norm() == 0);
}
