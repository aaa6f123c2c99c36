// The superquadric's own numbers: closed forms against fine meshes, derivatives against differences, at every exponent.
#include <catch2/catch.hpp>
#include <numbers>
#include "shapes/superquadric.hpp"
#include "src/base/random.hpp"

using namespace quern;

namespace {

struct Measured {
  double volume = 0;
  Vec3 inertia = Vec3::Zero();
};

// By the divergence theorem: sums over the tetrahedra that the triangles make with the centre, whose moments are exact.
Measured measured(const SurfaceMesh& mesh) {
  Measured m;
  Vec3 squares = Vec3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.points[static_cast<std::size_t>(t[0])], &b = mesh.points[static_cast<std::size_t>(t[1])], &c = mesh.points[static_cast<std::size_t>(t[2])];
    const double volume = a.dot(b.cross(c)) / 6;
    m.volume += volume;
    const Vec3 sum = a + b + c;
    squares += volume / 20 * (a.cwiseAbs2() + b.cwiseAbs2() + c.cwiseAbs2() + sum.cwiseAbs2());
  }
  m.inertia = {squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y()};
  return m;
}

Vec3 random_direction(RandomStream& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi), ring = std::sqrt(1 - z * z);
  return {ring * std::cos(angle), ring * std::sin(angle), z};
}

Superquadric random_shape(RandomStream& random) {
  const auto axis = [&] { return 1e-3 * std::pow(5.0, random.uniform(0, 1)); };
  const auto exponent = [&] { return 2 * std::pow(10.0, random.uniform(0, 1)); };
  return make_superquadric({axis(), axis(), axis()}, exponent(), exponent());
}

}  // namespace

TEST_CASE("volume and inertia of a superquadric are those of its mesh", "[superquadric]") {
  for (const auto& [n1, n2] : {std::pair(2.0, 2.0), {8.0, 8.0}, {20.0, 20.0}, {2.0, 20.0}, {20.0, 2.0}, {3.5, 6.0}}) {
    for (const Vec3& axes : {Vec3(1, 1, 1), Vec3(1, 2, 5), Vec3(5, 2, 1)}) {
      const Superquadric shape = make_superquadric(axes, n1, n2);
      const Measured mesh = measured(surface_mesh(shape, 240));
      CAPTURE(n1, n2, axes.transpose());
      CHECK(mesh.volume == Approx(shape.volume).epsilon(1e-4));
      for (int k = 0; k < 3; ++k) CHECK(mesh.inertia[k] == Approx(shape.inertia[k]).epsilon(1e-4));
    }
  }
}

TEST_CASE("an ellipsoid has the ellipsoid's volume, inertia and curvature", "[superquadric]") {
  const double a = 6e-3, b = 5e-3, c = 4e-3;
  const Superquadric shape = make_superquadric({a, b, c}, 2, 2);
  const double volume = 4.0 / 3.0 * std::numbers::pi * a * b * c;
  CHECK(shape.volume == Approx(volume).epsilon(1e-13));
  CHECK(shape.inertia.x() == Approx(volume / 5 * (b * b + c * c)).epsilon(1e-13));
  CHECK(shape.inertia.y() == Approx(volume / 5 * (a * a + c * c)).epsilon(1e-13));
  CHECK(shape.inertia.z() == Approx(volume / 5 * (a * a + b * b)).epsilon(1e-13));
  CHECK(shape.bounding_radius == Approx(a).epsilon(1e-15));
  const Curvature tip = shape.curvature({a, 0, 0});
  CHECK(tip.largest == Approx(a / (c * c)).epsilon(1e-12));
  CHECK(tip.smallest == Approx(a / (b * b)).epsilon(1e-12));
  // Elsewhere: K = h⁴/(abc)², h the distance of the tangent plane from the centre.
  RandomStream random(5);
  for (int k = 0; k < 100; ++k) {
    const Vec3 u = random_direction(random), place = Vec3(a, b, c).cwiseProduct(u);
    const double h = place.dot(shape.normal(place));
    CHECK(shape.curvature(place).gaussian() == Approx(std::pow(h, 4) / std::pow(a * b * c, 2)).epsilon(1e-10));
  }
}

TEST_CASE("gradient and Hessian of gauge and support are their differences", "[superquadric]") {
  RandomStream random(6);
  for (int k = 0; k < 400; ++k) {
    const Superquadric shape = random_shape(random);
    for (const NestedNorm* norm : {&shape.gauge, &shape.support}) {
      const Vec3 x = random_direction(random);
      if (x.cwiseAbs().minCoeff() < 0.05) continue;  // kinks of the support function lie at zero
      const NestedNorm::Second at = norm->second(x);
      CHECK(at.value == norm->value(x));
      CHECK(at.gradient.dot(x) == Approx(at.value).epsilon(1e-12));  // Euler, degree 1
      CHECK((at.hessian * x).norm() < 1e-9 * at.hessian.norm());
      const double step = 1e-5;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 d = step * Vec3::Unit(axis);
        CHECK(std::abs((norm->value(x + d) - norm->value(x - d)) / (2 * step) - at.gradient[axis]) < 1e-6 * at.gradient.norm());
        const Vec3 column = (norm->first(x + d).gradient - norm->first(x - d).gradient) / (2 * step);
        CHECK((column - at.hessian.col(axis)).norm() < 1e-4 * at.hessian.norm() + 1e-9 * at.gradient.norm());
      }
    }
  }
}

TEST_CASE("support point and normal of a superquadric are each other's inverse", "[superquadric]") {
  RandomStream random(7);
  for (int k = 0; k < 2000; ++k) {
    const Superquadric shape = random_shape(random);
    const Vec3 n = random_direction(random), place = shape.support.first(n).gradient;
    CHECK(shape.gauge.value(place) == Approx(1).epsilon(1e-12));
    CHECK((shape.normal(place) - n).norm() < 1e-9);
    // No other place of the surface reaches farther along n, none is farther away than the bounding ball.
    const Vec3 ray = random_direction(random), other = ray / shape.gauge.value(ray);
    CHECK(other.dot(n) <= place.dot(n) * (1 + 1e-12));
    CHECK(other.norm() <= shape.bounding_radius * (1 + 1e-12));
  }
}

TEST_CASE("flat places, far places and places at the axes give finite numbers", "[superquadric]") {
  const Superquadric cube = make_superquadric({1e-3, 1e-3, 1e-3}, 20, 20);
  CHECK(cube.support.first({0, 0, 1}).gradient == Vec3(0, 0, 1e-3));
  CHECK(cube.gauge.value({1e200, 0, 0}) == Approx(1e203));
  CHECK(cube.gauge.value({1e-200, 1e-250, 0}) == Approx(1e-197));
  for (const Vec3& x : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(1e-300, 0, 1), Vec3(1, 1e-18, 1e-30), Vec3(1, 1, 1e-9)}) {
    for (const NestedNorm* norm : {&cube.gauge, &cube.support}) {
      const NestedNorm::Second at = norm->second(x);
      CHECK(std::isfinite(at.value));
      CHECK(at.gradient.allFinite());
      CHECK((at.hessian * at.hessian).allFinite());
    }
  }
  CHECK(cube.curvature({1e-3, 0, 0}).largest == 0);
}

TEST_CASE("the bounding radius of a superquadric is reached", "[superquadric]") {
  RandomStream random(8);
  for (int k = 0; k < 20; ++k) {
    const Superquadric shape = random_shape(random);
    double farthest = 0;
    for (const Vec3& p : surface_mesh(shape, 100).points) farthest = std::max(farthest, p.norm());
    CHECK(farthest <= shape.bounding_radius * (1 + 1e-12));
    CHECK(farthest > 0.999 * shape.bounding_radius);
  }
}
