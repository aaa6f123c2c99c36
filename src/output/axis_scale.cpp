#include "src/output/axis_scale.hpp"
#include <fmt/format.h>
#include <array>

namespace quern {
std::string superscript(int number) {
  static constexpr std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = number < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(number))) out += digits[static_cast<std::size_t>(c - '0')];
  return out;
}

AxisScale log_scale(const Extent& extent, bool superscripts) {
  AxisScale scale;
  if (!(extent.low <= extent.high)) return scale;
  scale.from = std::floor(extent.low + 1e-9);
  scale.to = std::max(extent.high, scale.from + 1);
  const int every = std::max(1, static_cast<int>(scale.to - scale.from + 8) / 9);
  for (int decade = static_cast<int>(scale.from); decade <= scale.to + 1e-9; ++decade) {
    scale.ticks.push_back(decade);
    const bool labelled = (decade - static_cast<int>(scale.from)) % every == 0;
    scale.labels.push_back(!labelled ? "" : superscripts ? "10" + superscript(decade) : fmt::format("1e{}", decade));
  }
  return scale;
}

AxisScale linear_scale(const Extent& extent, int ticks) {
  if (!(extent.low <= extent.high)) return {};
  const double span = extent.high > extent.low ? extent.high - extent.low : std::max(std::abs(extent.high), 1.0);
  const double raw = span / ticks, decade = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = decade * (raw <= decade ? 1 : raw <= 2 * decade ? 2 : raw <= 2.5 * decade ? 2.5 : raw <= 5 * decade ? 5 : 10);
  AxisScale scale{extent.low, extent.low + span, {}, {}};
  for (double k = std::ceil(scale.from / step - 1e-9); k * step <= scale.to + 1e-9 * span; ++k) {
    scale.ticks.push_back(k * step);
    scale.labels.push_back(fmt::format("{:.6g}", k * step + 0.0));
  }
  return scale;
}

}  // namespace quern
