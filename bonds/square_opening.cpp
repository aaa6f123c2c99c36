#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include "bonds/fragments.hpp"
#include "src/base/vec.hpp"

namespace quern {
namespace {

double width(const std::vector<Quad>& spheres, const Vec3& direction) {
  double low = 1e300, high = -1e300;
  for (const Quad& s : spheres) {
    const double along = s.x * direction.x() + s.y * direction.y() + s.z * direction.z();
    low = std::min(low, along - s.w), high = std::max(high, along + s.w);
  }
  return high - low;
}

// Only spheres that are the outermost in some of many directions can touch the opening; of the others, all but a few go at once.
std::vector<Quad> outermost(const std::vector<Quad>& spheres, const std::vector<Vec3>& directions) {
  std::vector<bool> keeps(spheres.size(), false);
  for (const Vec3& d : directions) {
    double low = 1e300, high = -1e300;
    std::size_t lowest = 0, highest = 0;
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const Quad& s = spheres[k];
      const double along = s.x * d.x() + s.y * d.y() + s.z * d.z();
      if (along - s.w < low) low = along - s.w, lowest = k;
      if (along + s.w > high) high = along + s.w, highest = k;
    }
    keeps[lowest] = keeps[highest] = true;
  }
  std::vector<Quad> kept;
  for (std::size_t k = 0; k < spheres.size(); ++k)
    if (keeps[k]) kept.push_back(spheres[k]);
  return kept;
}

// Even directions on half a sphere (a Fibonacci lattice).
std::vector<Vec3> half_sphere(int count) {
  std::vector<Vec3> directions;
  for (int k = 0; k < count; ++k) {
    const double z = (k + 0.5) / count, r = std::sqrt(1 - z * z), angle = std::numbers::pi * (3 - std::sqrt(5.0)) * k;
    directions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return directions;
}

// The square's sides are along the first two columns.
double opening(const std::vector<Quad>& spheres, const Mat3& axes) {
  return std::max(width(spheres, axes.col(0)), width(spheres, axes.col(1)));
}

// The square turned a little about each axis as long as that makes it smaller.
Mat3 refined(const std::vector<Quad>& spheres, Mat3 axes, double size) {
  for (double angle = 0.1; angle > 1e-6; angle *= 0.5) {
    for (bool better = true; better;) {
      better = false;
      for (int k = 0; k < 6; ++k) {
        const Mat3 turned = axes * Eigen::AngleAxisd(k % 2 == 0 ? angle : -angle, Vec3::Unit(k / 2)).toRotationMatrix();
        const double now = opening(spheres, turned);
        if (now < size * (1 - 1e-9)) size = now, axes = turned, better = true;
      }
    }
  }
  return axes;
}

}  // namespace

double smallest_square_opening(const std::vector<Quad>& spheres) {
  double largest = 0;
  for (const Quad& s : spheres) largest = std::max(largest, 2 * s.w);
  if (spheres.size() <= 2) return largest;

  // Starts where the grid found the smallest openings, for each direction of one side that is narrow enough to matter.
  static constexpr int directions = 200, turns = 18;
  const std::vector<Vec3> tried = half_sphere(directions);
  const std::vector<Quad> outer = spheres.size() > 64 ? outermost(spheres, tried) : spheres;
  std::vector<std::pair<double, Vec3>> sides;
  for (const Vec3& d : tried) sides.push_back({width(outer, d), d});
  std::sort(sides.begin(), sides.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  struct Start {
    double size;
    Mat3 axes;
  };
  std::vector<Start> starts;
  double best = 1e300;
  for (const auto& [side, first] : sides) {
    if (side >= best) break;
    const Vec3 second = first.unitOrthogonal(), third = first.cross(second);
    Start start{1e300, Mat3::Identity()};
    for (int k = 0; k < turns; ++k) {
      const double angle = std::numbers::pi * k / turns;
      const Vec3 other = std::cos(angle) * second + std::sin(angle) * third;
      const double size = std::max(side, width(outer, other));
      if (size < start.size) start.size = size, start.axes << first, other, first.cross(other);
    }
    best = std::min(best, start.size);
    starts.push_back(start);
  }
  std::sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.size < b.size; });
  if (starts.size() > 6) starts.resize(6);
  double smallest = 1e300;
  for (const Start& start : starts) smallest = std::min(smallest, opening(spheres, refined(outer, start.axes, start.size)));
  return smallest;
}

}  // namespace quern
