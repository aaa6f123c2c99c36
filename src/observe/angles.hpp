// The one convention in which quern gives angles in a tumbling mill, and the ways to others (docs/angles.md).
//
// An angle is counted from the 12 o'clock position in the sense in which the mill turns, in degrees, 0 ≤ angle < 360. The charge rests
// at the bottom (180) and is carried on towards 270: a toe is near 140, a shoulder near 310.
#pragma once
#include <cmath>
#include <optional>
#include "src/observe/observer_settings.hpp"

namespace quern {

inline constexpr double degree = 0.017453292519943295;  // [rad]

inline double wrapped(double degrees) {
  const double r = std::fmod(degrees, 360.0);
  return r < 0 ? r + 360 : r;
}

// The mill seen along its axis.
struct MillView {
  Vec3 centre, axis;  // the axis so directed that the mill turns right-handed about it
  Vec3 up;            // against gravity, in the cross-section
  Vec3 ahead;         // where 12 o'clock moves to: the 90 degree position

  double angle(const Vec3& place) const {
    const Vec3 r = place - centre;
    return wrapped(std::atan2(r.dot(ahead), r.dot(up)) / degree);
  }
  double radius(const Vec3& place) const { return std::hypot((place - centre).dot(ahead), (place - centre).dot(up)); }
  double height(const Vec3& place) const { return (place - centre).dot(up); }
};

// None where gravity does not act across the axis.
inline std::optional<MillView> view_of(const MillAxis& mill, const Vec3& gravity) {
  MillView view;
  view.centre = mill.centre;
  view.axis = (mill.speed < 0 ? -1 : 1) * mill.axis.normalized();
  const Vec3 across = gravity - gravity.dot(view.axis) * view.axis;
  if (across.norm() <= 1e-6 * gravity.norm()) return std::nullopt;
  view.up = -across.normalized();
  view.ahead = view.axis.cross(view.up);
  return view;
}

// From 3 o'clock anticlockwise, in the view in which the mill turns anticlockwise: Morrell (1996), and the angles of table 2 of the
// industrial mill study in cases/mill_800mm.
inline double from_three_oclock(double angle) { return wrapped(angle + 90); }
// From 12 o'clock anticlockwise (Nkomo & Mulenga, cases/mill_material_study), for the view in which the mill turns as said.
inline double from_twelve_oclock_anticlockwise(double angle, bool turns_anticlockwise) { return turns_anticlockwise ? wrapped(angle) : wrapped(-angle); }
// From 6 o'clock in the sense of rotation: how far beyond the bottom; negative before it. −180 ≤ result < 180.
inline double beyond_six_oclock(double angle) { return wrapped(angle) - 180; }

}  // namespace quern
