// Which places of a body are farther from an axis than those around them: for touch_inside_cylinder, eight climbs at once.
#pragma once
#include "src/base/triple.hpp"

namespace quern {

// Seen along the axis: r is the direction from the axis to the body's centre, t across it, z along the axis, in the body's own axes.
struct BodyInJacket {
  Triple<double> scale;  // of its support function, with the exponents
  double outer, inner;
  Triple<double> r, t, z;
  double size, off;      // its semi-axes over those of scale [-]; of its centre from the axis [m]
  double bounding_radius, length;  // [m]; a length of it [m]
};

inline constexpr int climbs = 8;

struct FarPlaces {
  alignas(64) double c[climbs], s[climbs];               // the direction, along r and t
  alignas(64) double x[climbs], y[climbs], z[climbs];    // the place, in the body's own axes and size 1 [m]
  alignas(64) double distance[climbs];                   // from the axis; −1: none found from this start [m]
  alignas(64) double slope[climbs];                      // what is left of the distance's derivative with the angle [m]
  alignas(64) double along[climbs], across[climbs], rise[climbs];  // radii of curvature: along the circle, mixed, along the axis [m]
};

// False where certainly no place is as far from the axis as the radius. All instruction sets give the same bits.
namespace portable { bool find_far_places(const BodyInJacket&, double radius, FarPlaces&); }
namespace avx2 { bool find_far_places(const BodyInJacket&, double radius, FarPlaces&); }
namespace avx512 { bool find_far_places(const BodyInJacket&, double radius, FarPlaces&); }

}  // namespace quern
