#include "shapes/touching.hpp"
#include <limits>
#include <vector>

namespace quern {
namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;
using Tangents = Eigen::Matrix<double, 3, 2>;

// The pair in the first body's axes.
struct Pair {
  const Superquadric *first, *second;
  double size_first, size_second;
  Mat3 turn;     // from the first body's axes to the second's
  Vec3 apart;    // from the second body's centre to the first's
  double extent; // a length of both

  Pair(const PlacedShape& a, const PlacedShape& b)
      : first(a.shape), second(b.shape), size_first(a.size), size_second(b.size), turn(b.axes.transpose() * a.axes),
        apart(a.axes.transpose() * (a.centre - b.centre)),
        extent(b.size == 0 ? a.size * a.shape->volume_radius : std::min(a.size * a.shape->volume_radius, b.size * b.shape->volume_radius)) {}

  double value(const Vec3& n) const {
    return size_first * first->support.value(n) + size_second * second->support.value(turn * n) - n.dot(apart);
  }
  // The place of the sum of both bodies (about the origin) that reaches farthest along n.
  Vec3 farthest(const Vec3& n) const {
    return size_first * first->support.first(n).gradient + size_second * (turn.transpose() * second->support.first(turn * n).gradient);
  }
};

// φ and its derivatives at one n.
struct Look {
  Vec3 n, n_second;  // in the axes of each body: along a flat face both hold more digits than the turn from one to the other leaves
  double value;
  Vec3 place_first, place_second;  // reached farthest along n, in each body's own axes
  Vec3 mismatch;                   // gradient on the sphere: zero where the deepest places lie on one normal
  Mat3 radii_first, radii_second;  // Hessians, in the first body's axes
};

Look look(const Pair& pair, const Vec3& n, const Vec3& n_second) {
  const NestedNorm::Second a = pair.first->support.second(n), b = pair.second->support.second(n_second);
  Look at;
  at.n = n, at.n_second = n_second;
  at.place_first = pair.size_first * a.gradient, at.place_second = pair.size_second * b.gradient;
  at.value = pair.size_first * a.value + pair.size_second * b.value - n.dot(pair.apart);
  at.mismatch = at.place_first + pair.turn.transpose() * at.place_second - pair.apart - at.value * n;
  at.mismatch -= at.mismatch.dot(n) * n;
  at.radii_first = pair.size_first * a.hessian;
  at.radii_second = pair.size_second * (pair.turn.transpose() * b.hessian * pair.turn);
  return at;
}

Look look(const Pair& pair, const Vec3& n) { return look(pair, n, pair.turn * n); }

// At another direction, a tangential step away.
Look step_from(const Pair& pair, const Look& at, const Vec3& step) {
  constexpr double tiny = 1e-8;  // leaves n of unit length to rounding
  if (step.squaredNorm() < tiny * tiny) return look(pair, at.n + step, at.n_second + pair.turn * step);
  return look(pair, (at.n + step).normalized());
}

Tangents tangents(const Vec3& n) {
  Tangents t;
  t.col(0) = n.unitOrthogonal();
  t.col(1) = n.cross(t.col(0));
  return t;
}

Mat2 inverse(const Mat2& m) {
  Mat2 r;
  r << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  return r / (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0));
}

// Where a face is flat, the component of the normal along a body's axis is the (n−1)th power of the place along it, and Newton's
// method in the normal goes astray; in the place it is nearly exact. Such components are stepped by their (n−1)th root.
struct Coordinate {
  Vec3 axis;       // in the first body's axes
  double radius;   // of curvature along it [m]
  double exponent; // n − 1
  double now;      // the component of the normal
  double place, place_scale;  // along the axis; the component is (place/place_scale)^exponent, very near zero

  // Where a step of the component by Newton's method, or of the place, leads to.
  double next(double step, double place_step) const {
    const auto power = [&](double x) { return std::copysign(std::pow(std::abs(x), exponent), x); };
    if (std::abs(now) > 1e-7) return now * power(std::clamp(1 + step / (exponent * now), -3.0, 3.0));
    return power(std::clamp((place + place_step) / place_scale, -1.0, 1.0));
  }
};

// The axes of a body along which the normal has but a small component. `n` and `place` are in its own axes, which are the columns of `axes`.
int flat_coordinates(const Superquadric& shape, double size, const Vec3& n, const Vec3& place, const Mat3& radii, const Mat3& axes, Coordinate* list) {
  constexpr double flat = 0.15;
  if (shape.gauge.round()) return 0;
  const Vec3 reach = shape.semi_axes().cwiseProduct(n).cwiseAbs();
  const double largest = reach.maxCoeff();
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    if (reach[k] >= flat * largest) continue;
    const bool within_ring = k < 2 && reach[k] < flat * reach[1 - k];
    const double exponent = (within_ring ? shape.n2() : shape.n1()) - 1;
    if (exponent == 1) continue;
    const Vec3 axis = axes.col(k);
    const double of_normal = largest / shape.semi_axes()[k];  // the component where the place is one semi-axis away, nearly
    list[count++] = {axis, axis.dot(radii * axis), exponent, n[k], place[k], size * shape.semi_axes()[k] * std::pow(of_normal, -1 / exponent)};
  }
  return count;
}

// The tangential step that brings two of those components, the flattest, where they shall be, and otherwise is Newton's.
Vec2 bent_step(const Pair& pair, const Look& at, const Tangents& t, const Vec2& newton) {
  Coordinate list[4];
  int count = flat_coordinates(*pair.first, pair.size_first, at.n, at.place_first, at.radii_first, Mat3::Identity(), list);
  const int of_first = count;
  count += flat_coordinates(*pair.second, pair.size_second, at.n_second, at.place_second, at.radii_second, pair.turn.transpose(), list + count);
  if (count == 0) return newton;
  const Vec3 turn_n = t * newton, step_first = at.radii_first * turn_n, step_second = at.radii_second * turn_n;
  const auto step = [&](const Coordinate& c) {
    return c.next(c.axis.dot(turn_n), c.axis.dot(&c < list + of_first ? step_first : step_second)) - c.now;
  };
  const auto flattest = [&](const Vec2& other) {
    const Coordinate* best = nullptr;
    for (int k = 0; k < count; ++k) {
      const Vec2 along = t.transpose() * list[k].axis;
      if (std::abs(along.x() * other.y() - along.y() * other.x()) < 0.5) continue;
      if (!best || list[k].radius > best->radius) best = list + k;
    }
    return best;
  };
  const Coordinate* one = nullptr;
  for (int k = 0; k < count; ++k)
    if (!one || list[k].radius > one->radius) one = list + k;
  const Vec2 first = (t.transpose() * one->axis).normalized();
  const double first_step = step(*one) / (t.transpose() * one->axis).norm();
  if (const Coordinate* two = flattest(first)) {
    Mat2 rows;
    rows.row(0) = first.transpose(), rows.row(1) = (t.transpose() * two->axis).transpose();
    return inverse(rows) * Vec2(first_step, step(*two));
  }
  const Vec2 across(-first.y(), first.x());
  return first_step * first + across.dot(newton) * across;
}

ShapeContact told(const PlacedShape& first, const PlacedShape& second, const Look& at, double uncertainty, int steps) {
  ShapeContact c;
  c.steps = steps;
  c.normal = first.axes * at.n;
  c.overlap = at.value;
  c.touching = at.value >= 0;
  if (!c.touching) return c;
  c.uncertainty = uncertainty;
  const Tangents t = tangents(at.n);
  // Last of all the places are moved along the surfaces onto one normal: near a flat face a turn of n by its rounding moves them far.
  const Mat2 bend = t.transpose() * (at.radii_first + at.radii_second) * t - at.value * Mat2::Identity();
  Vec3 turn_n = -(t * (inverse(bend) * (t.transpose() * at.mismatch)));
  if (!(turn_n.squaredNorm() < 1e-12)) turn_n.setZero();
  const Vec3 move_first = at.radii_first * turn_n, move_second = at.radii_second * turn_n;
  const auto tangential = [&](const Vec3& move) { return Vec3(move - move.dot(at.n) * at.n); };
  c.residual = tangential(at.mismatch + move_first + move_second).norm();
  c.on_first = first.centre - first.axes * (at.place_first + tangential(move_first));
  c.on_second = second.centre + second.axes * at.place_second + first.axes * tangential(move_second);
  c.radius_first = mean_radius(t.transpose() * at.radii_first * t);
  c.radius_second = mean_radius(t.transpose() * at.radii_second * t);
  return c;
}

// Newton's method on the sphere, made safe: every step lowers φ. Ends where φ < 0.
ShapeContact descend(const Pair& pair, const PlacedShape& first, const PlacedShape& second, const Vec3& start) {
  constexpr int most_steps = 60;
  const double tolerance = 1e-10 * pair.extent, rounding = 1e-14 * (pair.apart.norm() + pair.extent);
  Look at = look(pair, start.normalized());
  double left = 0;
  int steps = 0;
  for (; steps < most_steps && at.value >= 0; ++steps) {
    const Tangents t = tangents(at.n);
    const Vec2 slope = t.transpose() * at.mismatch;
    Mat2 bend = t.transpose() * (at.radii_first + at.radii_second) * t - at.value * Mat2::Identity();
    // Deep in sharp edges φ may bend the other way.
    const double half = 0.5 * bend.trace(), spread = std::hypot(0.5 * (bend(0, 0) - bend(1, 1)), bend(0, 1));
    const double lowest = half - spread, floor = 1e-3 * pair.extent;
    if (lowest < floor) bend += (std::max(floor, -lowest) - lowest) * Mat2::Identity();
    Vec2 newton = -inverse(bend) * slope;
    left = -0.5 * slope.dot(newton);
    if (slope.norm() <= tolerance) break;
    if (const double size = newton.norm(); size > 0.5) newton *= 0.5 / size;
    const auto better = [&](const Vec2& step, Look& next) {
      next = step_from(pair, at, t * step);
      return next.value < at.value || (next.value <= at.value + rounding && next.mismatch.norm() < 0.5 * at.mismatch.norm());
    };
    Look next;
    bool moved = false;
    for (double part = 1; part > 0.2 && !moved; part *= 0.5) moved = better(bent_step(pair, at, t, part * newton), next);
    for (double part = 0.5; part > 1e-6 && !moved; part *= 0.25) moved = better(part * newton, next);
    if (!moved) break;
    at = next;
  }
  return told(first, second, at, left, steps);
}

// The least φ near a normal by halving: over the plane through its tip φ is convex, so that each gradient cuts away the part of a
// polygon where the least cannot lie, through its centre of gravity and thus by a third at least (Levin 1965). Slow, and stopped by
// no kink. `left`: by how much the least may be below what was found.
Vec3 cut(const Pair& pair, const Vec3& about, double& left) {
  constexpr int most_cuts = 120;
  constexpr double window = 1.5;
  const Tangents t = tangents(about);
  std::vector<Vec2> polygon = {{-window, -window}, {window, -window}, {window, window}, {-window, window}};
  Vec3 best = about;
  double least = std::numeric_limits<double>::infinity();
  Vec2 at_least = Vec2::Zero(), slope_there = Vec2::Zero();
  for (int k = 0; k < most_cuts; ++k) {
    Vec2 centre = Vec2::Zero();
    double area = 0;
    for (std::size_t v = 1; v + 1 < polygon.size(); ++v) {
      const Vec2 a = polygon[v] - polygon[0], b = polygon[v + 1] - polygon[0];
      const double twice = a.x() * b.y() - a.y() * b.x();
      area += twice, centre += twice / 3 * (a + b);
    }
    if (!(area > 1e-30)) break;
    centre = polygon[0] + centre / area;
    const Vec3 tip = about + t * centre;
    const double size = tip.norm();
    const Vec3 n = tip / size, place = pair.farthest(n) - pair.apart;
    const double value = place.dot(n);
    const Vec2 slope = t.transpose() * (place - value * n) / size;
    if (value < least) least = value, best = n, at_least = centre, slope_there = slope;
    if (value < 0 || slope.norm() == 0) break;
    std::vector<Vec2> rest;
    for (std::size_t v = 0; v < polygon.size(); ++v) {
      const Vec2 &a = polygon[v], &b = polygon[(v + 1) % polygon.size()];
      const double over_a = slope.dot(a - centre), over_b = slope.dot(b - centre);
      if (over_a <= 0) rest.push_back(a);
      if ((over_a < 0 && over_b > 0) || (over_a > 0 && over_b < 0)) rest.push_back(a + over_a / (over_a - over_b) * (b - a));
    }
    if (rest.size() < 3) break;
    polygon = std::move(rest);
  }
  left = 0;
  for (const Vec2& v : polygon) left = std::max(left, slope_there.dot(at_least - v));
  return best;
}

bool settled(const Pair& pair, const ShapeContact& c) { return !c.touching || c.uncertainty < 1e-9 * pair.extent; }

// Newton's method, and halving where it comes to a halt.
ShapeContact least_near(const Pair& pair, const PlacedShape& first, const PlacedShape& second, const Vec3& start) {
  ShapeContact found = descend(pair, first, second, start);
  for (int rounds = 0; rounds < 3 && !settled(pair, found); ++rounds) {
    double left = 0;
    const Vec3 n = cut(pair, first.axes.transpose() * found.normal, left);
    if (pair.value(n) > found.overlap) {
      found.uncertainty = std::min(found.uncertainty, left);
      break;
    }
    found = descend(pair, first, second, n);
    found.uncertainty = std::min(found.uncertainty, left);
  }
  return found;
}

// Whether the two touch, by the place where the ray from the origin to `apart` leaves the sum of both bodies: the search for the
// triangle of support points that it goes through (Snethen 2008). Returns a normal near there, or that of a plane between them.
Vec3 portal(const Pair& pair) {
  const double size = pair.apart.norm();
  if (size == 0) return Vec3::UnitZ();
  const Vec3 ray = pair.apart / size;
  Vec3 n = ray;
  Vec3 v1 = pair.farthest(n);
  if (v1.dot(n) < pair.apart.dot(n)) return n;
  n = v1.cross(ray);
  if (n.norm() < 1e-14 * v1.norm()) return ray;
  n.normalize();
  Vec3 v2 = pair.farthest(n);
  if (v2.dot(n) < pair.apart.dot(n)) return n;
  n = v1.cross(v2);
  if (n.dot(ray) < 0) std::swap(v1, v2), n = -n;
  n.normalize();
  Vec3 v3;
  for (int k = 0; k < 100; ++k) {
    v3 = pair.farthest(n);
    if (v3.dot(n) < pair.apart.dot(n)) return n;
    if (v1.cross(v3).dot(ray) < 0)
      v2 = v3, n = v1.cross(v3);
    else if (v3.cross(v2).dot(ray) < 0)
      v1 = v3, n = v3.cross(v2);
    else
      break;
    n.normalize();
  }
  for (int k = 0; k < 200; ++k) {
    Vec3 normal = (v2 - v1).cross(v3 - v1);
    const double length = normal.norm();
    if (length < 1e-300) break;
    normal /= length;
    n = normal.dot(v1) < 0 ? Vec3(-normal) : normal;
    const Vec3 v4 = pair.farthest(n);
    if (v4.dot(n) < pair.apart.dot(n)) return n;  // a plane between them
    const double gap = (v4 - v1).dot(n);
    const bool inside = n.dot(pair.apart - v1) <= 0 && length > 1e-10 * pair.extent * pair.extent;
    if (gap < 1e-13 * pair.extent || (inside && gap < 0.05 * pair.extent)) break;
    // Of the three triangles with v4, the one that the ray goes through.
    const Vec3 across = v4.cross(ray);
    if (v1.dot(across) > 0) {
      if (v2.dot(across) > 0)
        v1 = v4;
      else
        v3 = v4;
    } else {
      if (v3.dot(across) > 0)
        v2 = v4;
      else
        v1 = v4;
    }
  }
  return n;
}

}  // namespace

double mean_radius(const Mat2& radii) {
  // Of radii matrices, one of which may be very large, without the overflow of a product.
  const double half = 0.5 * radii.trace(), spread = std::hypot(0.5 * (radii(0, 0) - radii(1, 1)), radii(0, 1));
  const double large = half + spread, small = (radii / large).determinant() * large;
  return 2 / (1 / large + 1 / small);
}

ShapeContact touch_from(const PlacedShape& first, const PlacedShape& second, const Vec3& normal) {
  constexpr double shallow = 0.05;
  const Pair pair(first, second);
  const ShapeContact found = least_near(pair, first, second, first.axes.transpose() * normal);
  if (!found.touching || found.overlap < shallow * pair.extent) return found;
  // Only deep in each other can bodies have an overlap from one side while from another they are apart. One from another side that is
  // merely less is left alone: to change over to it would make energy.
  const ShapeContact anew = touch(first, second);
  return anew.touching ? found : anew;
}

ShapeContact touch(const PlacedShape& first, const PlacedShape& second) {
  const Pair pair(first, second);
  ShapeContact best = least_near(pair, first, second, portal(pair));
  if (!best.touching) return best;
  // From the side of each axis, where the first try is not shallow.
  const auto try_from = [&](const Vec3& n) {
    const Vec3 towards = n.dot(pair.apart) < 0 ? Vec3(-n) : n;
    if (pair.value(towards) > 4 * best.overlap + 0.5 * pair.extent) return;
    const ShapeContact other = least_near(pair, first, second, towards);
    if (other.overlap < best.overlap) best = other;
  };
  if (best.overlap < 1e-3 * pair.extent) return best;
  for (int axis = 0; axis < 3; ++axis) {
    try_from(Vec3::Unit(axis));
    try_from(pair.turn.transpose().col(axis));
  }
  if (const double size = pair.apart.norm(); size > 0) try_from(pair.apart / size);
  return best;
}

ShapeContact widened(const PlacedShape& first, const PlacedShape& second, const Vec3& normal) {
  constexpr int most_steps = 4;
  constexpr double worth = 1.1;  // by which a step must widen the gap to try another
  const Pair pair(first, second);
  Look at = look(pair, (first.axes.transpose() * normal).normalized());
  for (int k = 0; k < most_steps; ++k) {
    const Tangents t = tangents(at.n);
    Mat2 bend = t.transpose() * (at.radii_first + at.radii_second) * t + std::max(1e-3 * pair.extent, -at.value) * Mat2::Identity();
    Vec2 step = -(inverse(bend) * (t.transpose() * at.mismatch));
    if (const double size = step.norm(); size > 0.5) step *= 0.5 / size;
    const double before = at.value;
    for (double part = 1; part > 0.1; part *= 0.3) {
      const Look next = step_from(pair, at, part * (t * step));
      if (!(next.value < at.value)) continue;
      at = next;
      break;
    }
    if (at.value > worth * before) break;
  }
  return told(first, second, at, 0, 0);
}

ShapeContact touch_plane(const PlacedShape& body, const Vec3& place, const Vec3& normal) {
  const Vec3 n = body.axes.transpose() * normal;
  const NestedNorm::Second at = body.shape->support.second(n);
  ShapeContact c;
  c.normal = normal;
  c.overlap = body.size * at.value - normal.dot(body.centre - place);
  c.touching = c.overlap >= 0;
  c.on_first = body.centre - body.axes * (body.size * at.gradient);
  c.on_second = c.on_first + c.overlap * normal;
  const Tangents t = tangents(n);
  c.radius_first = mean_radius(body.size * (t.transpose() * at.hessian * t));
  c.radius_second = std::numeric_limits<double>::infinity();
  return c;
}

}  // namespace quern
