// The periodic directions of space.
#pragma once
#include "src/base/triple.hpp"

namespace quern {

// A direction with period 0 is open. Distances take the nearest image, so a period must exceed twice the reach of a pair.
struct Domain {
  double lower[3] = {0, 0, 0};   // [m]
  double period[3] = {0, 0, 0};  // [m]

  double inverse(int axis) const { return period[axis] > 0 ? 1.0 / period[axis] : 0.0; }
  bool periodic() const { return period[0] > 0 || period[1] > 0 || period[2] > 0; }
  // The shortest of the images of a difference of positions, which is less than one and a half periods.
  Triple<double> nearest(const Triple<double>& d) const {
    const auto one = [](double x, double length) { return x > 0.5 * length ? x - length : x < -0.5 * length ? x + length : x; };
    return {one(d.x, period[0] > 0 ? period[0] : 1e300), one(d.y, period[1] > 0 ? period[1] : 1e300), one(d.z, period[2] > 0 ? period[2] : 1e300)};
  }

  // Images are numbered 0 … 26, 13 the particle itself; the shift that takes a particle to its image [m].
  static constexpr std::int32_t itself = 13;
  Triple<double> shift(std::int32_t image) const {
    return {(image % 3 - 1) * period[0], (image / 3 % 3 - 1) * period[1], (image / 9 - 1) * period[2]};
  }
};

}  // namespace quern
