#include "shapes/wall_touching.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include "shapes/jacket.hpp"
#include "src/base/instruction_set.hpp"

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

void find_far_places(const BodyInJacket& body, double radius, double widest, FarPlaces& places) {
#if defined(__x86_64__)
  static const InstructionSet best = best_instruction_set();
  if (best == InstructionSet::avx512) return avx512::find_far_places(body, radius, widest, places);
  if (best == InstructionSet::avx2) return avx2::find_far_places(body, radius, widest, places);
#endif
  portable::find_far_places(body, radius, widest, places);
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

int touch_inside_cylinder(const PlacedShape& body, double radius, ShapeContact* contacts, double& gap) {
  constexpr double margin = 0.1;  // of the bounding radius: gaps are told up to that
  const double off = std::hypot(body.centre.x(), body.centre.y()), bound = body.size * body.shape->bounding_radius;
  gap = radius - (off + bound);
  if (gap >= 0) return 0;
  const Vec3 towards = off > 0 ? Vec3(body.centre.x() / off, body.centre.y() / off, 0) : Vec3(1, 0, 0);
  gap = margin * bound;
  // Beyond an angle the ball about the body does not come so near to the jacket, or does not come at all. Only of a body longer than the
  // jacket is wide is that a right angle or more; then the other side is looked at, too.
  const double near = radius - gap, tangent = off * off - bound * bound;
  const bool long_one = bound >= near;
  const double cosine = long_one ? 0 : tangent > near * near ? std::sqrt(tangent) / off : (near * near + tangent) / (2 * near * off);
  const double widest = std::sqrt((1 - cosine) / (1 + cosine));
  const NestedNorm& support = body.shape->support;
  const auto own = [&](const Vec3& n) { return triple(Vec3(body.axes.transpose() * n)); };
  int count = 0;
  for (int side = 0; side < (long_one ? 2 : 1); ++side) {
    const Vec3 r = side == 0 ? towards : Vec3(-towards), t(-r.y(), r.x(), 0);
    FarPlaces places;
    find_far_places({triple(support.scale), support.outer, support.inner, own(r), own(t), own(Vec3::UnitZ()), body.size, r.dot(body.centre), bound,
                     body.size * body.shape->volume_radius}, radius, widest, places);
    gap = std::min(gap, places.gap);
    for (int k = 0; k < places.count && count < most_places; ++k) {
      ShapeContact& c = contacts[count++] = {};
      c.touching = true;
      c.normal = -(places.c[k] * r + places.s[k] * t);
      c.overlap = places.distance[k] - radius;
      c.on_first = body.centre + body.axes * (body.size * Vec3(places.x[k], places.y[k], places.z[k]));
      c.on_second = c.on_first + c.overlap * c.normal;
      c.residual = std::abs(places.slope[k]);
      Eigen::Matrix2d radii;
      radii << places.along[k], places.across[k], places.across[k], places.rise[k];
      c.radius_first = mean_radius(radii);
    }
  }
  gap = count > 0 ? 0 : std::max(0.0, gap);
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
