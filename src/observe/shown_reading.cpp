#include "src/observe/shown_reading.hpp"
#include <algorithm>
#include <cmath>

namespace quern {
namespace {

// A lag's answer after a time h to an input that goes from u0 to u1 meanwhile.
double lagged_after(double lagged, double u0, double u1, double h, double lag) {
  if (!(h > 0)) return lagged;
  const double slope = (u1 - u0) / h;
  return u1 - lag * slope + (lagged - u0 + lag * slope) * std::exp(-h / lag);
}

}  // namespace

void ShownReading::begin(const BodyState& first, double start) {
  start_ = std::min(start, first.time);
  lagged_ = lagged_before(first, first.time);
}

double ShownReading::before(const BodyState& first, double time) const { return instrument_.cut(lagged_before(first, time)); }

// The body came straight: after its first instant the lag falls behind by what changes in its time constant.
double ShownReading::lagged_before(const BodyState& first, double time) const {
  const auto scaled = [&](double when) { return instrument_.scaled(value_before(reading_, axis_, first, first.time - when)); };
  if (!(instrument_.lag > 0)) return scaled(time);
  return scaled(time) - (scaled(time) - scaled(time - instrument_.lag)) * -std::expm1(-std::max(0.0, time - start_) / instrument_.lag);
}

void ShownReading::read(const BodyState& before, const BodyState& now, std::span<const double> times, double* values) {
  const double step = now.time - before.time;
  const auto scaled = [&](double s) { return instrument_.scaled(value_between(reading_, axis_, before, now, s)); };
  std::size_t next = 0;
  if (!(instrument_.lag > 0)) {
    for (; next < times.size(); ++next) values[next] = instrument_.cut(scaled((times[next] - before.time) / step));
    return;
  }
  // The lag takes its input as straight over each piece.
  const int pieces = std::clamp(static_cast<int>(4 * step / instrument_.lag), 1, 64);
  for (int piece = 0; piece < pieces; ++piece) {
    const double from = piece / static_cast<double>(pieces), to = (piece + 1) / static_cast<double>(pieces);
    const double u0 = scaled(from), u1 = scaled(to), h = step / pieces;
    for (; next < times.size(); ++next) {
      const double since = times[next] - before.time - from * step;
      if (since > h && piece + 1 < pieces) break;
      const double u = u0 + (u1 - u0) * since / h;
      values[next] = instrument_.cut(lagged_after(lagged_, u0, u, since, instrument_.lag));
    }
    lagged_ = lagged_after(lagged_, u0, u1, h, instrument_.lag);
  }
}

}  // namespace quern
