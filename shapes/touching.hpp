// Where two superquadrics touch: the direction along which they need the least way to part.
//
// Along a unit vector n from the second body to the first they overlap by φ(n) = h₁(n) + h₂(n) − n·(x₁ − x₂), with the support
// functions h. One n with φ < 0 is a plane between them: they do not touch, that is certain. Where there is none, the least φ is the
// overlap, the gradient of φ joins the deepest places of the two, which lie on one common normal, and the force along n by a
// potential of the overlap is conservative. (The same contact as by common normals of the surfaces; its curvature enters as radii,
// the Hessian of h, which flat faces make large where the Hessian of the surface's function makes it vanish.)
#pragma once
#include "shapes/superquadric.hpp"

namespace quern {

// A body where it stands.
struct PlacedShape {
  const Superquadric* shape;
  double size;   // its semi-axes over those of the shape [-]; 0: a point, as the second of two
  Vec3 centre;   // [m]
  Mat3 axes;     // columns: its axes in the fixed frame
};

struct ShapeContact {
  bool touching = false;
  Vec3 normal = Vec3::Zero();  // unit, from the second body to the first: of the contact, or of a plane between the two
  double overlap = 0;   // δ [m]; below zero: they are at least so far apart
  Vec3 on_first = Vec3::Zero(), on_second = Vec3::Zero();  // the deepest places of their surfaces, one overlap apart along the normal [m]
  double residual = 0;  // how far those two are from one common normal [m]
  double uncertainty = 0;  // by which the overlap may still fall, to second order [m]
  double radius_first = 0, radius_second = 0;  // 1/mean curvature there, not bounded [m]
  int steps = 0;        // of Newton's method that it took
};

// 1/mean curvature, from the radii of curvature in the tangential plane: a symmetric matrix, one of whose eigenvalues may be very large.
double mean_radius(const Eigen::Matrix2d& radii);

// From a direction that was right a short while ago. The overlap it finds is one that a move along the normal undoes, though where
// bodies are deep in each other perhaps not the least.
ShapeContact touch_from(const PlacedShape& first, const PlacedShape& second, const Vec3& normal);

// From nothing: whether they touch is decided for certain, the overlap is the least of those found from several sides.
ShapeContact touch(const PlacedShape& first, const PlacedShape& second);

// From a plane between two that are apart, towards that with the widest gap: a few steps, each of which widens it.
ShapeContact widened(const PlacedShape& first, const PlacedShape& second, const Vec3& normal);

// A superquadric and a half-space whose surface goes through a place, n out of the solid: closed form.
ShapeContact touch_plane(const PlacedShape& body, const Vec3& place, const Vec3& normal);

}  // namespace quern
