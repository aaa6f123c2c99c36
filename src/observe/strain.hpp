// Strain of a cloud of points.
#pragma once
#include <vector>
#include "src/base/vec.hpp"

namespace quern {

// Slope of the displacement along `direction` over the place along it, by least squares; 0 for fewer than two points [-].
inline double strain_of(const std::vector<Vec3>& places, const std::vector<Vec3>& moved, const Vec3& direction) {
  if (places.size() < 2) return 0;
  double x = 0, u = 0;
  const auto count = static_cast<double>(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) x += places[k].dot(direction) / count, u += moved[k].dot(direction) / count;
  double xx = 0, xu = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double dx = places[k].dot(direction) - x;
    xx += dx * dx, xu += dx * (moved[k].dot(direction) - u);
  }
  return xx > 0 ? xu / xx : 0;
}

}  // namespace quern
