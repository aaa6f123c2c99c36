#include "src/output/angle_dial.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/output/page.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

constexpr double middle_x = 130, middle_y = 125, radius = 105;

// From 12 o'clock, anticlockwise.
std::string at(double degrees, double r) {
  const double a = degrees * std::numbers::pi / 180;
  return fmt::format("{:.1f} {:.1f}", middle_x - r * std::sin(a), middle_y - r * std::cos(a));
}

}  // namespace

std::string angle_dial(const std::vector<Headline>& headlines) {
  struct Hand {
    const char *key, *name, *colour;
  };
  constexpr Hand hands[] = {{"shoulder_angle", "shoulder", "#0072b2"}, {"toe_angle", "toe", "#d55e00"}, {"departure_angle", "departure", "#00815e"}, {"impact_angle", "impact", "#b4518c"}};
  std::string drawn;
  double line = 70;
  for (const Hand& hand : hands) {
    const auto found = std::find_if(headlines.begin(), headlines.end(), [&](const Headline& one) { return one.key == hand.key && std::isfinite(one.value); });
    if (found == headlines.end()) continue;
    if (found->ci95 && std::isfinite((*found->ci95)[0]) && std::isfinite((*found->ci95)[1])) {
      const double low = (*found->ci95)[0], high = std::min((*found->ci95)[1], low + 359);
      drawn += fmt::format("<path d=\"M{} A{} {} 0 {} 0 {}\" fill=\"none\" stroke=\"{}\" stroke-width=\"9\" stroke-opacity=\"0.3\"/>", at(low, radius), radius, radius, high - low > 180 ? 1 : 0, at(high, radius), hand.colour);
    }
    drawn += fmt::format("<path d=\"M{}L{}\" stroke=\"{}\" stroke-width=\"2.5\"/>", at(found->value, radius - 12), at(found->value, radius + 8), hand.colour);
    drawn += fmt::format("<rect x=\"275\" y=\"{:.0f}\" width=\"12\" height=\"12\" rx=\"2\" fill=\"{}\"/><text x=\"294\" y=\"{:.0f}\" fill=\"#222226\">{} {}</text>", line - 11, hand.colour, line, hand.name,
                         escaped_html(spoken_with_unit(*found)));
    line += 24;
  }
  if (drawn.empty()) return "";
  std::string dial = fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/>", middle_x, middle_y, radius);
  for (const int degrees : {0, 90, 180, 270}) {
    const double a = degrees * std::numbers::pi / 180, r = radius - 24;
    dial += fmt::format("<path d=\"M{}L{}\" stroke=\"#8a8a92\"/><text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"#55555c\">{}°</text>", at(degrees, radius), at(degrees, radius - 6), middle_x - r * std::sin(a),
                        middle_y - r * std::cos(a) + 4, degrees);
  }
  // An arrow for the sense of turning.
  dial += fmt::format("<path d=\"M{} A40 40 0 0 0 {}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/><path d=\"M{}L{}L{}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/>", at(-40, 40), at(40, 40),
                      at(31, 35), at(40, 40), at(30, 46));
  return fmt::format("<svg viewBox=\"0 0 450 250\" role=\"img\" aria-label=\"Angles of the charge\" font-size=\"13\">{}{}</svg>", dial, drawn);
}

}  // namespace quern
