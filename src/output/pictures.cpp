#include "src/output/pictures.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/output/drawing.hpp"
#include "src/output/hidden_display.hpp"

namespace quern {
namespace {

// Along the axis of a drum that lies across gravity; otherwise from the front, x to the right.
Vec3 view_axis_of(const Simulation& s) {
  for (const Wall& wall : s.walls) {
    const Vec3 axis = wall.pose.axes.col(2);
    const bool across = std::abs(axis.dot(s.gravity)) <= 0.1 * s.gravity.norm();
    if (across && std::holds_alternative<Revolved>(wall.surface)) return axis;
  }
  const Vec3 front = -Vec3::UnitY();
  return std::abs(front.dot(s.gravity)) > 0.9 * s.gravity.norm() && s.gravity.norm() > 0 ? Vec3(Vec3::UnitZ()) : front;
}

// "power 1.93 ± 0.02 kW" with as many digits as the interval deserves.
std::string spoken(const Headline& headline) {
  double value = headline.value, half = headline.ci95 ? 0.5 * ((*headline.ci95)[1] - (*headline.ci95)[0]) : 0;
  std::string unit = headline.unit == "deg" ? "°" : headline.unit == "1" ? "" : " " + headline.unit;
  if (headline.unit == "W" && std::abs(value) >= 1000) value /= 1000, half /= 1000, unit = " kW";
  std::string name = headline.key;
  std::replace(name.begin(), name.end(), '_', ' ');
  if (!(half > 0) || !std::isfinite(half)) return fmt::format("{} {:.4g}{}", name, value, unit);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half))), 0, 6);
  return fmt::format("{} {:.{}f} ± {:.{}f}{}", name, value, decimals, half, decimals, unit);
}

std::string caption_with(const std::vector<std::string>& keys, const Simulation& s, const std::string& of, const std::vector<Headline>& headlines) {
  std::string caption = fmt::format("t = {:.4g} s · {} particles{}", s.clock.time(), s.particles.owned, of.empty() ? "" : " in " + of);
  for (const std::string& key : keys) {
    for (const Headline& headline : headlines)
      if (headline.key == key && std::isfinite(headline.value)) caption += " · " + spoken(headline);
  }
  return caption;
}

std::string caption_of(const Simulation& s, const std::string& of, const std::vector<Headline>& headlines) {
  return caption_with({"power", "shoulder_angle", "toe_angle"}, s, of, headlines);
}

std::string damage_caption_of(const Simulation& s, const std::string& of, const std::vector<Headline>& headlines) {
  return caption_with({"damage_ratio", "fragment_count"}, s, of, headlines);
}

}  // namespace

namespace {

Vec3 axis_of(const PictureRequest& request) {
  return request.view_axis.norm() > 0 ? request.view_axis.normalized() : view_axis_of(*request.simulation);
}

// A picture that cannot be drawn is a remark.
template <class Draw>
void try_to_draw(const PictureRequest& request, const std::string& file, Drawn& drawn, Draw&& how) {
  try {
    how(request.directory + "/" + file);
    drawn.files.push_back(file);
  } catch (const std::exception& error) {
    drawn.remarks.push_back("The picture " + file + " is skipped: " + error.what());
  }
}

}  // namespace

Drawn draw_stage(const PictureRequest& request, int number) {
  Drawn drawn;
  const HiddenDisplay display;
  if (!display.ready()) {
    drawn.remarks.push_back(display.problem());
    return drawn;
  }
  const Simulation& s = *request.simulation;
  const bool bonded = !s.bonds.empty();
  try_to_draw(request, fmt::format("stage_{}.png", number), drawn, [&](const std::string& path) {
    draw_charge({&s, axis_of(request), request.title, damage_caption_of(s, request.of, {}), {}, request.view_up, bonded, bonded}, path);
  });
  return drawn;
}

Drawn draw_pictures(const PictureRequest& request) {
  Drawn drawn;
  std::vector<Chart> charts = charts_of(request.tables, request.headlines, request.title);
  charts.insert(charts.end(), request.charts.begin(), request.charts.end());
  const bool charge = request.simulation && request.simulation->particles.owned > 0;
  if (charts.empty() && !charge) return drawn;
  const HiddenDisplay display;
  if (!display.ready()) {
    drawn.remarks.push_back(display.problem());
    return drawn;
  }
  const auto draw = [&](const std::string& file, auto&& how) { try_to_draw(request, file, drawn, how); };
  if (charge) {
    const Simulation& s = *request.simulation;
    const Vec3 axis = axis_of(request);
    draw("charge.png", [&](const std::string& path) {
      draw_charge({&s, axis, request.title, caption_of(s, request.of, request.headlines), request.marks, request.view_up}, path);
    });
    if (!s.bonds.empty()) {
      draw("fragments.png", [&](const std::string& path) {
        draw_charge({&s, axis, request.title, damage_caption_of(s, request.of, request.headlines), {}, request.view_up, true}, path);
      });
    }
  }
  for (const Chart& chart : charts) draw(chart.file, [&](const std::string& path) { draw_chart(chart, path); });
  return drawn;
}

}  // namespace quern
