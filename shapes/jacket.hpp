// Which places of a body are farther from an axis than all around them: for touch_inside_cylinder, eight directions at once.
//
// Seen along the axis, n(θ) is a direction and p(θ) the body's farthest place along it, which lies in the direction ψ(θ). Where ψ = θ, and
// only there, p is a stationary place of the distance from the axis: a top where ψ − θ falls. Both p and ψ turn one way only while θ grows,
// as a convex outline does. So of an interval of θ whose ends are known, all tops lie in [θ₁, θ₂] ∩ [ψ₁, ψ₂] and no farther than the outline's two
// ends and the corner of the tangents there. Intervals are cut by that and divided until each is left out for certain or holds one top.
#pragma once
#include "src/base/triple.hpp"

namespace quern {

// Seen along the axis: r is a direction across it, t that across both, z along the axis, in the body's own axes. The centre lies on r, or behind.
struct BodyInJacket {
  Triple<double> scale;  // of its support function, with the exponents
  double outer, inner;
  Triple<double> r, t, z;
  double size, off;        // its semi-axes over those of scale [-]; of its centre along r [m]
  double bounding_radius;  // [m]
  double length;           // a length of it: tops that cannot stand out against each other by more than a millionth of it are taken for one [m]
};

inline constexpr int most_tops = 8;

struct FarPlaces {
  int count;                        // of tops at least as far as the radius
  double gap;                       // where there is none: by which all places are nearer, or more [m]
  double c[most_tops], s[most_tops];  // the direction, along r and t
  double x[most_tops], y[most_tops], z[most_tops];  // the place, in the body's own axes and size 1 [m]
  double distance[most_tops];       // from the axis [m]
  double slope[most_tops];          // what is left of the distance's derivative with the angle [m]
  double along[most_tops], across[most_tops], rise[most_tops];  // radii of curvature: along the circle, mixed, along the axis [m]
};

// In directions within the angle 2 atan(widest) ≤ π/2 of r. All instruction sets give the same bits.
namespace portable { void find_far_places(const BodyInJacket&, double radius, double widest, FarPlaces&); }
namespace avx2 { void find_far_places(const BodyInJacket&, double radius, double widest, FarPlaces&); }
namespace avx512 { void find_far_places(const BodyInJacket&, double radius, double widest, FarPlaces&); }

}  // namespace quern
