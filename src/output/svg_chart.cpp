#include "src/output/svg_chart.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/output/axis_scale.hpp"
#include "src/output/palette.hpp"

namespace quern {
namespace {

// In units of the picture, of which a phone shows about 0.8 pixels each.
constexpr double width = 440, type = 12, letter = 6.7, right_room = 18, panel_gap = 30;
constexpr double first_height = 160, further_height = 105;
constexpr std::size_t most_points = 700;  // of a curve: more than can be told apart

std::string hex(const Colour& c) {
  return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(255 * c[0] + 0.5), static_cast<int>(255 * c[1] + 0.5), static_cast<int>(255 * c[2] + 0.5));
}

std::string colour_of(const Panel& panel, std::size_t k) {
  const int like = panel.curves[k].like;
  return hex(palette[(like < 0 ? k : static_cast<std::size_t>(like)) % palette.size()]);
}

// Letters of a text in UTF-8.
double length_of(std::string_view text) {
  return static_cast<double>(std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string text_at(double x, double y, std::string_view text, const char* anchor = "start") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x, y, anchor, escaped_html(text));
}

std::string line_at(double x0, double y0, double x1, double y1, const char* colour, double thickness) {
  return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" stroke-width=\"{}\"/>", x0, y0, x1, y1, colour, thickness);
}

struct Axis {
  AxisScale scale;
  bool log = false;
  double start = 0, end = 1;  // in the picture
  double of(double value) const { return start + (end - start) * ((log ? std::log10(value) : value) - scale.from) / (scale.to - scale.from); }
  double of_tick(double tick) const { return start + (end - start) * (tick - scale.from) / (scale.to - scale.from); }
};

// Which points of a curve are drawn: of many, the least and the greatest of each stretch.
std::vector<std::size_t> drawn(const Curve& curve, bool log_x, bool log_y) {
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < std::min(curve.x.size(), curve.y.size()); ++k)
    if (std::isfinite(curve.x[k]) && std::isfinite(curve.y[k]) && (!log_x || curve.x[k] > 0) && (!log_y || curve.y[k] > 0)) all.push_back(k);
  if (all.size() <= most_points) return all;
  std::vector<std::size_t> few;
  const std::size_t stretches = most_points / 2;
  for (std::size_t s = 0; s < stretches; ++s) {
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(s * all.size() / stretches), to = all.begin() + static_cast<std::ptrdiff_t>((s + 1) * all.size() / stretches);
    const auto [least, most] = std::minmax_element(from, to, [&](std::size_t a, std::size_t b) { return curve.y[a] < curve.y[b]; });
    few.push_back(std::min(*least, *most));
    if (least != most) few.push_back(std::max(*least, *most));
  }
  return few;
}

void hold(const Panel& panel, Extent& x, Extent& y) {
  for (const Curve& curve : panel.curves) {
    const bool interval = curve.lower.size() == curve.y.size() && curve.upper.size() == curve.y.size();
    for (const std::size_t k : drawn(curve, panel.log_x, panel.log_y)) {
      x.hold(panel.log_x ? std::log10(curve.x[k]) : curve.x[k]);
      y.hold(panel.log_y ? std::log10(curve.y[k]) : curve.y[k]);
      if (!interval) continue;
      for (const double end : {curve.lower[k], curve.upper[k]})
        if (!panel.log_y || end > 0) y.hold(panel.log_y ? std::log10(end) : end);
    }
  }
}

std::string grid(const Axis& x, const Axis& y, bool x_labels) {
  std::string svg;
  for (std::size_t k = 0; k < y.scale.ticks.size(); ++k) {
    const double at = y.of_tick(y.scale.ticks[k]);
    svg += line_at(x.start, at, x.end, at, "#e6e6e8", 1);
    svg += text_at(x.start - 6, at + 0.35 * type, y.scale.labels[k], "end");
  }
  for (std::size_t k = 0; k < x.scale.ticks.size(); ++k) {
    const double at = x.of_tick(x.scale.ticks[k]);
    svg += line_at(at, y.start, at, y.start + 4, "#222226", 1);
    if (x_labels) svg += text_at(at, y.start + 4 + type, x.scale.labels[k], "middle");
  }
  return svg + line_at(x.start, y.start, x.end, y.start, "#222226", 1);
}

std::string curve_in(const Curve& curve, const Panel& panel, const Axis& x, const Axis& y, const std::string& colour) {
  const std::vector<std::size_t> points = drawn(curve, panel.log_x, panel.log_y);
  if (points.empty()) return "";
  std::string svg;
  const auto low_of = [&](std::size_t k) { return y.of(panel.log_y ? std::max(curve.lower[k], 0.1 * curve.y[k]) : curve.lower[k]); };
  if (curve.lower.size() == curve.y.size() && curve.upper.size() == curve.y.size()) {
    if (curve.marks) {
      for (const std::size_t k : points) svg += line_at(x.of(curve.x[k]), low_of(k), x.of(curve.x[k]), y.of(curve.upper[k]), colour.c_str(), 1);
    } else {
      std::string outline;
      for (const std::size_t k : points) outline += fmt::format("{}{:.1f} {:.1f}", outline.empty() ? "M" : "L", x.of(curve.x[k]), y.of(curve.upper[k]));
      for (auto k = points.rbegin(); k != points.rend(); ++k) outline += fmt::format("L{:.1f} {:.1f}", x.of(curve.x[*k]), low_of(*k));
      svg += fmt::format("<path d=\"{}Z\" fill=\"{}\" fill-opacity=\"0.2\"/>", outline, colour);
    }
  }
  std::string way, dots;
  for (const std::size_t k : points) {
    way += fmt::format("{}{:.1f} {:.1f}", way.empty() ? "M" : "L", x.of(curve.x[k]), y.of(curve.y[k]));
    dots += fmt::format("M{:.1f} {:.1f}h0", x.of(curve.x[k]), y.of(curve.y[k]));
  }
  if (!curve.marks || curve.joined) svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>", way, colour, curve.marks ? 1.0 : 1.6);
  if (curve.marks) svg += fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\"/>", dots, colour, curve.small ? 3 : 5);
  return svg;
}

// Names of the curves in one or two lines; `height` is what they take.
std::string legend_of(const Chart& chart, double& height) {
  std::string svg;
  double at = 0, line = type;
  const auto place = [&](const std::string& name, const std::string& sign) {
    const double needed = 26 + letter * length_of(name);
    if (at > 0 && at + needed > width) at = 0, line += type + 6;
    svg += fmt::format("<g transform=\"translate({:.1f},{:.1f})\">{}{}</g>", at, line, sign, text_at(22, 0, name));
    at += needed + 12;
  };
  std::vector<std::string> seen;
  bool marked = false;
  for (const Panel& panel : chart.panels) {
    marked |= panel.marked.has_value();
    for (std::size_t k = 0; k < panel.curves.size(); ++k) {
      const Curve& curve = panel.curves[k];
      if (curve.name.empty() || std::find(seen.begin(), seen.end(), curve.name) != seen.end()) continue;
      seen.push_back(curve.name);
      const std::string colour = colour_of(panel, k);
      place(curve.name, curve.marks ? fmt::format("<path d=\"M9 -4h0\" stroke=\"{}\" stroke-width=\"5\" stroke-linecap=\"round\"/>", colour)
                                    : fmt::format("<path d=\"M0 -4H18\" stroke=\"{}\" stroke-width=\"{}\"/>", colour, curve.lower.empty() ? 2.0 : 6.0));
    }
  }
  if (marked) place("where they differ", fmt::format("<rect x=\"1\" y=\"-10\" width=\"16\" height=\"12\" fill=\"{}\" fill-opacity=\"0.15\"/>", hex(palette[5])));
  height = svg.empty() ? 0 : line + 8;
  return svg;
}

std::string framed(const std::string& inside, double height, const std::string& title) {
  return fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\" font-size=\"{}\" fill=\"#222226\">{}</svg>", width, std::ceil(height), escaped_html(title), type, inside);
}

}  // namespace

std::string escaped_html(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') safe += "&amp;";
    else if (c == '<') safe += "&lt;";
    else if (c == '>') safe += "&gt;";
    else if (c == '"') safe += "&quot;";
    else safe += c;
  }
  return safe;
}

std::string svg_of(const Chart& chart) {
  double top = 0;
  std::string svg = legend_of(chart, top);
  const bool one_label = std::all_of(chart.panels.begin(), chart.panels.end(), [&](const Panel& p) { return p.x_label == chart.panels.front().x_label && p.log_x == chart.panels.front().log_x; });
  Extent common;
  std::vector<Axis> heights;
  double left = 0;
  for (std::size_t k = 0; k < chart.panels.size(); ++k) {
    const Panel& panel = chart.panels[k];
    Extent y;
    hold(panel, common, y);
    if (!panel.log_y && y.low < y.high) {
      const double room = 0.04 * (y.high - y.low);
      y.low -= room, y.high += room;
    }
    Axis axis{panel.log_y ? log_scale(y) : linear_scale(y, k == 0 ? 5 : 4), panel.log_y, 0, 0};
    for (const std::string& label : axis.scale.labels) left = std::max(left, letter * length_of(label) + 10);
    heights.push_back(std::move(axis));
  }
  for (std::size_t k = 0; k < chart.panels.size(); ++k) {
    const Panel& panel = chart.panels[k];
    Extent own = common;
    if (!one_label) {
      Extent y;
      own = {};
      hold(panel, own, y);
    }
    const bool last = k + 1 == chart.panels.size(), labelled = last || !one_label;
    Axis& y = heights[k];
    y.end = top + type + 8, y.start = y.end + (k == 0 ? first_height : further_height);
    const Axis x{panel.log_x ? log_scale(own) : linear_scale(own, 5), panel.log_x, left, width - right_room};
    svg += text_at(left, top + type, panel.y_label);
    if (panel.marked && !panel.log_x) {
      const double from = std::clamp(x.of((*panel.marked)[0]), x.start, x.end), to = std::clamp(x.of((*panel.marked)[1]), x.start, x.end);
      svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" fill-opacity=\"0.15\"/>", from, y.end, std::max(to - from, 2.0), y.start - y.end, hex(palette[5]));
    }
    svg += grid(x, y, labelled);
    for (std::size_t c = 0; c < panel.curves.size(); ++c) svg += curve_in(panel.curves[c], panel, x, y, colour_of(panel, c));
    top = y.start + (labelled ? 2 * type + 10 : 4);
    if (labelled) svg += text_at(0.5 * (x.start + x.end), top - 2, panel.x_label, "middle");
    top += last ? 2 : labelled ? panel_gap - 2 * type : 8;
  }
  return framed(svg, top, chart.title);
}

std::string svg_of(const std::vector<BeforeAfter>& rows, const std::string& x_label, double level) {
  Extent extent;
  double left = 0;
  for (const BeforeAfter& row : rows) {
    extent.hold(row.before), extent.hold(row.after);
    left = std::max(left, letter * length_of(row.name) + 10);
  }
  extent.hold(level);
  const bool log = extent.low > 0 && extent.high > 12 * extent.low;
  Extent shown;
  const double room = 0.04 * (extent.high - extent.low);
  if (log) shown = {std::log10(extent.low) - 0.03, std::log10(extent.high) + 0.03};
  else shown = {std::max(0.0, extent.low - room), extent.high + room};
  Axis x{linear_scale(shown, 6), log, std::min(left, 0.4 * width), width - right_room};
  if (log) {
    // Not whole decades: they would waste half of the width.
    x.scale = {shown.low, shown.high, {}, {}};
    for (int decade = static_cast<int>(std::floor(shown.low)); decade <= shown.high; ++decade)
      for (const int digit : {1, 2, 5})
        if (const double at = decade + std::log10(digit); at >= shown.low && at <= shown.high) x.scale.ticks.push_back(at), x.scale.labels.push_back(fmt::format("{:.4g}", digit * std::pow(10.0, decade)));
  }
  constexpr double each = type + 4;
  const double bottom = each * static_cast<double>(rows.size()) + 6;
  std::string svg = grid(x, {{0, 1, {}, {}}, false, bottom, 0}, true);
  svg += fmt::format("<path d=\"M{0:.1f} 0V{1:.1f}\" stroke=\"#222226\" stroke-dasharray=\"3 3\"/>", x.of(level), bottom);
  const std::string plain = hex(palette[0]), apart = hex(palette[1]);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const BeforeAfter& row = rows[k];
    if (!std::isfinite(row.before) || !std::isfinite(row.after)) continue;
    const std::string& colour = row.set_apart ? apart : plain;
    const double y = each * (static_cast<double>(k) + 0.5) + 2, before = x.of(log ? std::max(row.before, extent.low) : row.before), after = x.of(log ? std::max(row.after, extent.low) : row.after);
    svg += text_at(x.start - 8, y + 0.35 * type, row.name, "end");
    svg += line_at(before, y, after, y, colour.c_str(), 1.5);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"1.5\"/>", before, y, colour);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"/>", after, y, colour);
  }
  const double label_at = bottom + 2 * type + 8;
  svg += text_at(0.5 * (x.start + x.end), label_at, x_label, "middle");
  return framed(svg, label_at + 6, x_label);
}

}  // namespace quern
