// shapes — surfaces of particles: what they measure and weigh, and where two of them touch. No particles, no forces.
//
// The superquadric (|x/a|^{n₂} + |y/b|^{n₂})^{n₁/n₂} + |z/c|^{n₁} = 1 with 2 ≤ n₁, n₂ ≤ 20: convex, from ellipsoids to rounded
// cylinders and cubes (Barr 1981; Jaklič, Leonardis & Solina 2000). Places and directions are in the body's own axes.
#pragma once
#include <array>
#include <vector>
#include "shapes/nested_norm.hpp"

namespace quern {

// How a surface bends at one place; convex is positive.
struct Curvature {
  double largest, smallest;  // principal curvatures [1/m]
  double mean() const { return 0.5 * (largest + smallest); }
  double gaussian() const { return largest * smallest; }
};

struct SurfaceMesh {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;  // seen from outside they turn left
};

struct Superquadric {
  static constexpr double least_exponent = 2, largest_exponent = 20;

  NestedNorm gauge;    // 1 on the surface, less inside; (gauge)^{n₁} − 1 is the inside–outside function of the books
  NestedNorm support;  // of a unit normal: how far the body reaches along it [m]; the gradient is the place where it does
  double bounding_radius;  // of the least ball about the centre that holds it [m]
  double volume;           // [m³]
  Vec3 inertia;            // about its axes at density 1 [m⁵]
  double volume_radius;    // of the ball of its volume [m]

  Vec3 semi_axes() const { return support.scale; }  // of its box, too
  double n1() const { return gauge.outer; }
  double n2() const { return gauge.inner; }
  bool sphere() const { return gauge.round() && support.scale.minCoeff() == support.scale.maxCoeff(); }

  // The outward unit normal at a place on the surface (elsewhere: where the ray from the centre leaves).
  Vec3 normal(const Vec3& place) const { return gauge.first(place).gradient.normalized(); }
  Curvature curvature(const Vec3& place) const;
};

// Semi-axes > 0 [m], exponents within their bounds.
Superquadric make_superquadric(const Vec3& semi_axes, double n1, double n2);

// A cube whose faces are cut into cells × cells, blown up to the surface.
SurfaceMesh surface_mesh(const Superquadric& shape, int cells);

}  // namespace quern
