#include "src/output/angle_dial.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/output/page.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

constexpr double middle_x = 190, middle_y = 150, radius = 100;

// From 12 o'clock, anticlockwise.
std::string at(double degrees, double r) {
  const double a = degrees * std::numbers::pi / 180;
  return fmt::format("{:.1f} {:.1f}", middle_x - r * std::sin(a), middle_y - r * std::cos(a));
}

std::string label(double degrees, double r, const std::string& text, const char* colour) {
  const double a = degrees * std::numbers::pi / 180, x = -std::sin(a), y = -std::cos(a);
  const char* anchor = x > 0.3 ? "start" : x < -0.3 ? "end" : "middle";
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\">{}</text>", middle_x + r * x, middle_y + r * y + 4, anchor, colour, escaped_html(text));
}

}  // namespace

std::string angle_dial(const std::vector<Headline>& headlines) {
  struct Hand {
    const char *key, *name, *colour;
  };
  constexpr Hand hands[] = {{"shoulder_angle", "shoulder", "#0072b2"}, {"toe_angle", "toe", "#d55e00"}, {"departure_angle", "departure", "#00815e"}, {"impact_angle", "impact", "#b4518c"}};
  std::string drawn;
  std::vector<double> written;  // where a name stands already
  for (const Hand& hand : hands) {
    const auto found = std::find_if(headlines.begin(), headlines.end(), [&](const Headline& one) { return one.key == hand.key && std::isfinite(one.value); });
    if (found == headlines.end()) continue;
    if (found->ci95 && std::isfinite((*found->ci95)[0]) && std::isfinite((*found->ci95)[1])) {
      const double low = (*found->ci95)[0], high = std::min((*found->ci95)[1], low + 359);
      drawn += fmt::format("<path d=\"M{} A{} {} 0 {} 0 {}\" fill=\"none\" stroke=\"{}\" stroke-width=\"9\" stroke-opacity=\"0.3\"/>", at(low, radius), radius, radius, high - low > 180 ? 1 : 0, at(high, radius), hand.colour);
    }
    drawn += fmt::format("<path d=\"M{}L{}\" stroke=\"{}\" stroke-width=\"2.5\"/>", at(found->value, radius - 12), at(found->value, radius + 8), hand.colour);
    double place = found->value;  // of the name: beside the hand, farther where another stands
    constexpr double apart = 13;
    for (int tries = 0; tries < 4; ++tries)
      for (const double other : written)
        if (std::abs(std::remainder(place - other, 360)) < apart) place = other + (std::remainder(found->value - other, 360) < 0 ? -apart : apart);
    written.push_back(place);
    drawn += label(place, radius + 16, fmt::format("{} {:.0f}°", hand.name, found->value), hand.colour);
  }
  if (drawn.empty()) return "";
  std::string dial = fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/>", middle_x, middle_y, radius);
  for (const int degrees : {0, 90, 180, 270})
    dial += fmt::format("<path d=\"M{}L{}\" stroke=\"#8a8a92\"/><text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#55555c\">{}°</text>", at(degrees, radius), at(degrees, radius - 6),
                        at(degrees, radius - 22).substr(0, at(degrees, radius - 22).find(' ')), std::stod(at(degrees, radius - 22).substr(at(degrees, radius - 22).find(' ') + 1)) + 4, degrees);
  // An arrow for the sense of turning.
  dial += fmt::format("<path d=\"M{} A40 40 0 0 0 {}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/><path d=\"M{}L{}L{}\" fill=\"none\" stroke=\"#8a8a92\" stroke-width=\"1.5\"/>", at(-40, 40), at(40, 40),
                      at(31, 35), at(40, 40), at(30, 46));
  return fmt::format("<svg viewBox=\"0 0 380 300\" role=\"img\" aria-label=\"Angles of the charge\" font-size=\"13\">{}{}</svg>", dial, drawn);
}

}  // namespace quern
