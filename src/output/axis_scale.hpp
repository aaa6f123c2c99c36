// What an axis shows: the interval, and round numbers on it.
#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace quern {

struct Extent {
  double low = 1e300, high = -1e300;
  void hold(double value) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
};

// All in the axis's own measure (powers of ten on a log axis).
struct AxisScale {
  double from = 0, to = 1;
  std::vector<double> ticks;
  std::vector<std::string> labels;
};

// "⁻³", for a power of ten.
std::string superscript(int number);

// About so many ticks.
AxisScale linear_scale(const Extent& extent, int ticks = 7);

// `extent` in powers of ten. Without superscripts labels read 1e3.
AxisScale log_scale(const Extent& extent, bool superscripts = true);

}  // namespace quern
