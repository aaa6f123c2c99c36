#include "shapes/wall_touching.hpp"
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace quern {
namespace {

// The body's reach along a direction across the axis, which is how far its farthest place in that direction is from a plane through the
// axis, and the derivatives of that with the direction's angle.
struct Reach {
  double angle;
  Vec3 n, along;   // the direction and the one that a growing angle turns it to
  Vec3 place;
  double value, slope, bend;
  Mat3 radii;
};

Reach reach(const PlacedShape& body, double angle) {
  Reach r;
  r.angle = angle;
  r.n = {std::cos(angle), std::sin(angle), 0}, r.along = {-r.n.y(), r.n.x(), 0};
  const NestedNorm::Second at = body.shape->support.second(body.axes.transpose() * r.n);
  r.place = body.centre + body.axes * (body.size * at.gradient);
  r.value = r.n.dot(r.place);
  r.slope = r.along.dot(r.place);
  r.radii = body.size * (body.axes * at.hessian * body.axes.transpose());
  r.bend = r.along.dot(r.radii * r.along) - r.value;
  return r;
}

double radius_of(const Reach& r) {
  Eigen::Matrix<double, 3, 2> t;
  t.col(0) = r.along, t.col(1) = Vec3::UnitZ();
  return mean_radius(t.transpose() * r.radii * t);
}

// Climbs to a place farther from the axis than all beside it: Newton's method where the reach is concave, else the angle of the farthest
// place itself, which always climbs.
Reach climb(const PlacedShape& body, Reach at) {
  constexpr int most_steps = 60;
  const double tolerance = 1e-12 * body.size * body.shape->volume_radius;
  for (int k = 0; k < most_steps && std::abs(at.slope) > tolerance; ++k) {
    if (at.bend < -0.01 * at.value) {
      const Reach next = reach(body, at.angle - at.slope / at.bend);
      if (next.value > at.value || std::abs(next.slope) < 0.5 * std::abs(at.slope)) {
        at = next;
        continue;
      }
    }
    at = reach(body, std::atan2(at.place.y(), at.place.x()));
  }
  return at;
}

// Where on the way from start to start + way a norm, which is convex, is least, in parts of the way: Newton's method between bounds.
double least_along(const NestedNorm& norm, const Vec3& start, const Vec3& way) {
  if (norm.first(start).gradient.dot(way) >= 0) return 0;
  if (norm.first(start + way).gradient.dot(way) <= 0) return 1;
  double low = 0, high = 1, along = 0.5;
  for (int k = 0; k < 60 && high - low > 1e-10; ++k) {
    const NestedNorm::Second at = norm.second(start + along * way);
    const double slope = at.gradient.dot(way), bend = way.dot(at.hessian * way);
    if (slope == 0) break;
    (slope < 0 ? low : high) = along;
    const double next = along - slope / bend;
    along = k % 4 < 3 && next > low && next < high ? next : 0.5 * (low + high);
  }
  return along;
}

}  // namespace

int touch_inside_cylinder(const PlacedShape& body, double radius, ShapeContact* contacts) {
  const double off = std::hypot(body.centre.x(), body.centre.y()), bound = body.size * body.shape->bounding_radius;
  if (off + bound <= radius || off == 0) return 0;
  const double middle = std::atan2(body.centre.y(), body.centre.x());
  // Beyond this angle the ball about the body does not reach the jacket.
  const double cosine = (radius * radius + off * off - bound * bound) / (2 * radius * off);
  const double window = std::acos(std::min(1.0, std::max(-1.0, cosine)));
  // Between two places that are each farthest from the axis among those around them there is one no farther than the body's largest radius of
  // curvature, so that an ellipsoid much smaller than the jacket has but one.
  const Vec3 semi_axes = body.size * body.shape->semi_axes();
  const double largest = semi_axes.maxCoeff();
  const bool single = body.shape->gauge.round() && largest * largest < 0.5 * radius * semi_axes.minCoeff();
  const int starts = single ? 3 : 5;
  int count = 0;
  for (int k = single ? 2 : 0; k < starts && count < most_places; ++k) {
    // A body's edges lie in all directions of it; seen from the axis they lie within the window.
    const Vec3 towards = Eigen::AngleAxisd((k - 2) * 0.25 * std::numbers::pi, Vec3::UnitZ()) * Vec3(std::cos(middle), std::sin(middle), 0);
    const Reach first = reach(body, std::atan2(towards.y(), towards.x()));
    const double angle = std::remainder(std::atan2(first.place.y(), first.place.x()) - middle, 2 * std::numbers::pi);
    const Reach top = climb(body, reach(body, middle + std::min(window, std::max(-window, angle))));
    if (top.value < radius) continue;
    bool known = false;
    for (int c = 0; c < count; ++c) known = known || (contacts[c].on_first - top.place).norm() < 1e-3 * bound;
    if (known) continue;
    ShapeContact& c = contacts[count++];
    c.touching = true;
    c.normal = -top.n;
    c.overlap = top.value - radius;
    c.on_first = top.place;
    c.on_second = top.place + c.overlap * c.normal;
    c.residual = std::abs(top.slope);
    c.radius_first = radius_of(top);
  }
  return count;
}

ShapeContact touch_outside_cylinder(const PlacedShape& body, double radius) {
  constexpr int most_steps = 100;
  constexpr double narrow = 1e-10;  // [rad]
  const double tolerance = 1e-12 * body.size * body.shape->volume_radius;
  // φ(n) = reach along −n, and the jacket's radius: least between an angle where it falls and one where it grows.
  Reach at = reach(body, std::atan2(body.centre.y(), body.centre.x()) + std::numbers::pi);
  std::optional<Reach> falling, growing;
  for (int k = 0; k < most_steps && std::abs(at.slope) > tolerance; ++k) {
    (at.slope < 0 ? falling : growing) = at;
    const double newton = at.bend > 0 ? -at.slope / at.bend : -std::copysign(0.1, at.slope);
    double next = at.angle + std::min(0.5, std::max(-0.5, newton));
    if (falling && growing) {
      const double low = falling->angle, high = growing->angle;
      if (high - low < narrow) break;
      if (k % 3 == 0 || !(at.bend > 0 && next > low && next < high)) next = 0.5 * (low + high);
    }
    at = reach(body, next);
  }
  double value = at.value;
  Vec3 place = at.place;
  // Across a flat face the place runs from one side to the other within less than can be told apart.
  if (std::abs(at.slope) > tolerance && falling && growing) {
    const double part = falling->slope / (falling->slope - growing->slope);
    place = falling->place + part * (growing->place - falling->place);
    value = at.n.dot(place);
  }
  ShapeContact c;
  c.normal = -at.n;
  c.overlap = value + radius;
  c.touching = c.overlap >= 0;
  c.on_first = place;
  c.on_second = place + c.overlap * c.normal;
  c.residual = std::abs(at.along.dot(place));
  c.radius_first = radius_of(at);
  return c;
}

ShapeContact touch_line(const PlacedShape& body, const Vec3& place, const Vec3& direction) {
  const Mat3 axes = Rotation::FromTwoVectors(Vec3::UnitZ(), direction).toRotationMatrix();
  const PlacedShape seen{body.shape, body.size, axes.transpose() * (body.centre - place), axes.transpose() * body.axes};
  ShapeContact c = touch_outside_cylinder(seen, 0);
  c.normal = axes * c.normal;
  c.on_first = place + axes * c.on_first;
  c.on_second = place + axes * c.on_second;
  return c;
}

ShapeContact touch_point(const PlacedShape& body, const Vec3& place) {
  static const Superquadric ball = make_superquadric({1, 1, 1}, 2, 2);
  return touch(body, {&ball, 0, place, Mat3::Identity()});
}

ShapeContact touch_edge(const PlacedShape& body, const Vec3& from, const Vec3& to) {
  const double length = (to - from).norm();
  const ShapeContact line = touch_line(body, from, (to - from) / length);
  if (!line.touching) return line;
  const double along = (line.on_second - from).dot(to - from) / (length * length);
  if (along >= 0 && along <= 1) return line;
  const ShapeContact end = touch_point(body, along < 0 ? from : to);
  return end.touching ? end : line;
}

int touch_circle(const PlacedShape& body, double radius, double height, Sheet sheet, ShapeContact* contacts) {
  const double off = std::hypot(body.centre.x(), body.centre.y()), rise = height - body.centre.z(), bound = body.size * body.shape->bounding_radius;
  const double across = bound * bound - rise * rise;
  if (across <= 0 || (off - radius) * (off - radius) >= across) return 0;
  // Beyond this angle the ball about the body does not reach the circle.
  const double cosine = off > 0 ? (radius * radius + off * off - across) / (2 * radius * off) : -1;
  const double middle = std::atan2(body.centre.y(), body.centre.x()), window = std::acos(std::min(1.0, std::max(-1.0, cosine)));
  const auto own = [&](const Vec3& way) { return Vec3(body.axes.transpose() * way / body.size); };
  const auto place = [&](double angle) { return Vec3(radius * std::cos(angle), radius * std::sin(angle), height); };
  constexpr int parts = 32;
  const double step = 2 * window / parts;
  double gauge[parts + 1];
  for (int k = 0; k <= parts; ++k) gauge[k] = body.shape->gauge.value(own(place(middle - window + k * step) - body.centre));
  const bool whole = cosine <= -1;
  int count = 0;
  for (int k = 0; k < parts && count < most_places; ++k) {
    if (k == 0 && !whole) continue;
    if (gauge[k] > gauge[k == 0 ? parts - 1 : k - 1] || gauge[k] >= gauge[k + 1]) continue;
    double low = middle - window + (k - 1) * step, high = low + 2 * step, angle = 0.5 * (low + high);
    for (int n = 0; n < 60; ++n) {
      const Vec3 at = place(angle), out(at.x(), at.y(), 0), along(-at.y(), at.x(), 0);
      const NestedNorm::Second g = body.shape->gauge.second(own(at - body.centre));
      const double slope = g.gradient.dot(own(along)), bend = own(along).dot(g.hessian * own(along)) - g.gradient.dot(own(out));
      (slope < 0 ? low : high) = angle;
      double next = angle - slope / bend;
      if (n % 4 == 3 || !(bend > 0 && next > low && next < high)) next = 0.5 * (low + high);
      const bool found = std::abs(next - angle) < 1e-12;
      angle = next;
      if (found) break;
    }
    const Vec3 at = place(angle), out(at.x(), at.y(), 0), along(-at.y() / radius, at.x() / radius, 0);
    const NestedNorm::First g = body.shape->gauge.first(own(at - body.centre));
    if (g.value > 1 || (g.gradient.dot(own(out)) > 0) != (sheet == Sheet::beyond)) continue;
    const ShapeContact contact = touch_line(body, at, along);
    if (contact.touching) contacts[count++] = contact;
  }
  return count;
}

DeepestPlace deepest_place(const PlacedShape& body, const Vec3* corners, const Vec3& normal) {
  const auto own = [&](const Vec3& way) { return Vec3(body.axes.transpose() * way / body.size); };
  // Of all the plane, by the duality of gauge and support, on the ray to the place that reaches farthest along the normal.
  const Vec3 from = corners[0] - body.centre;
  const double distance = normal.dot(from);
  const NestedNorm::First reach = body.shape->support.first(body.axes.transpose() * normal);
  const double part = distance / (body.size * reach.value);
  const Vec3 on_plane = body.centre + part * body.size * (body.axes * reach.gradient);
  const double tolerance = 1e-9 * body.size * body.shape->volume_radius;
  bool within = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = corners[k], side = corners[(k + 1) % 3] - a;
    within = within && normal.dot(side.cross(on_plane - a)) >= -tolerance * side.norm();
  }
  if (within) return {on_plane, std::abs(part), -1};
  DeepestPlace deepest{on_plane, std::numeric_limits<double>::infinity(), 0};
  for (int k = 0; k < 3; ++k) {
    const Vec3 start = own(corners[k] - body.centre), way = own(corners[(k + 1) % 3] - corners[k]);
    const double along = least_along(body.shape->gauge, start, way), gauge = body.shape->gauge.value(start + along * way);
    if (gauge < deepest.gauge) deepest = {corners[k] + along * (corners[(k + 1) % 3] - corners[k]), gauge, k};
  }
  return deepest;
}

}  // namespace quern
