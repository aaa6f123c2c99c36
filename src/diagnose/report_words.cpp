#include "src/diagnose/report_words.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include "src/diagnose/shown.hpp"
#include "src/output/axis_scale.hpp"
#include "src/output/svg_chart.hpp"

namespace quern::page {

namespace {

const char* const style = R"(
*{box-sizing:border-box}
body{font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;color:#222226;background:#fff;max-width:62rem;margin:0 auto;padding:1rem 1.1rem 3rem}
h1{font-size:1.05rem;font-weight:600;color:#63636a;margin:.2rem 0 .8rem}
h2{font-size:1.2rem;margin:2.2rem 0 .5rem}
p{margin:.5rem 0;max-width:46rem}
.verdict{border-left:.4rem solid var(--accent);background:#f6f6f7;padding:.9rem 1.1rem;border-radius:.2rem}
.verdict strong{display:block;font-size:1.45rem;line-height:1.25;font-weight:650;margin-bottom:.4rem}
.numbers{display:flex;flex-wrap:wrap;gap:.4rem 2rem;margin:.7rem 0 0}
.numbers div{min-width:7rem}
.numbers b{display:block;font-size:1.25rem;font-weight:600;font-variant-numeric:tabular-nums}
.numbers span,.note,figcaption{font-size:.85rem;color:#55555c}
ul{margin:.6rem 0;padding-left:1.2rem;max-width:46rem}
.runs{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,23rem),1fr));gap:1.2rem;margin:1rem 0}
.runs.one{max-width:34rem}
figure{margin:0;break-inside:avoid}
figcaption{margin-bottom:.3rem}
figcaption b{color:#222226}
svg{width:100%;height:auto;display:block;font-family:inherit}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.92rem;margin:.6rem 0;font-variant-numeric:tabular-nums}
th{text-align:left;font-weight:600;border-bottom:1.5px solid #222226;padding:.25rem .8rem .25rem 0;vertical-align:bottom}
td{border-bottom:1px solid #e2e2e5;padding:.25rem .8rem .25rem 0;vertical-align:top}
td.n,th.n{text-align:right;white-space:nowrap}
tr.chosen td{font-weight:600;background:#f6f6f7}
td .note{display:block;font-weight:400}
code{font-family:ui-monospace,"DejaVu Sans Mono",monospace;font-size:.88em}
.equation{font-size:1.15rem;margin:.3rem 0 .1rem}
@media(max-width:30rem){td,th{padding-right:.5rem}table{font-size:.85rem}}
@media print{body{font-size:10.5pt;max-width:none;padding:0}.runs{grid-template-columns:1fr 1fr}h2{break-after:avoid}table{break-inside:avoid}.verdict{background:none}tr.chosen td{background:none}}
)";

const char* accent_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::nothing_missing: return "#009e73";
    case Verdict::parameters_only: return "#0072b2";
    case Verdict::omitted_physics: return "#d55e00";
    case Verdict::unexplained: return "#cc79a7";
    case Verdict::insufficient_data: break;
  }
  return "#56565c";
}

}  // namespace

std::string e(std::string_view text) { return escaped_html(text); }
std::string code(std::string_view text) {
  std::string safe;
  for (const char c : e(text)) {
    safe += c;
    if (c == '.' || c == '_' || c == '/') safe += "<wbr>";
  }
  return fmt::format("<code>{}</code>", safe);
}
std::string paragraph(const std::string& html) { return fmt::format("<p>{}</p>\n", html); }

std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string joined(const std::vector<std::string>& names, const char* between, const char* last) {
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k) text += (k == 0 ? "" : k + 1 == names.size() ? last : between) + words_of(names[k]);
  return text;
}

std::string brief(double x, int digits) {
  if (!std::isfinite(x)) return "–";
  std::string text = fmt::format("{:.{}g}", x, digits);
  const auto at = text.find('e');
  if (at != text.npos) text = text.substr(0, at) + "·10" + superscript(std::stoi(text.substr(at + 1)));
  if (text[0] == '-') text = "−" + text.substr(1);
  return text;
}

std::string with_unit(const std::string& number, const std::string& unit) {
  const std::string spoken = spoken_unit(unit);
  return spoken.empty() ? number : number + " " + spoken;
}

Spoken spoken_of(const Estimate& estimate) {
  const auto [low, high] = estimate.interval();
  const double half = 0.5 * (high - low), size = std::max(std::abs(estimate.value), half);
  if (!std::isfinite(half) || !(half > 0)) return {brief(estimate.value), "not known"};
  const int power = size >= 1e-3 && size < 1e5 ? 0 : static_cast<int>(std::floor(std::log10(size)));
  const double unit = std::pow(10.0, power), least = half / unit;
  const int decade = static_cast<int>(std::floor(std::log10(least)));
  const int decimals = std::clamp((least < 3.55 * std::pow(10.0, decade) ? 1 : 0) - decade, 0, 9);
  const auto one = [&](double x) {
    std::string text = fmt::format("{:.{}f}", x / unit, decimals);
    return text[0] == '-' ? "−" + text.substr(1) : text;
  };
  const std::string times = power == 0 ? "" : "·10" + superscript(power);
  const std::string between = one(low) + " … " + one(high);
  return {one(estimate.value) + times, power == 0 ? between : "(" + between + ")" + times};
}

std::string chance(double p) { return p < 1e-6 ? "below 10⁻⁶" : brief(p, 2); }
std::string percent(double part) { return part < 0.0005 ? "&lt; 0.1 %" : fmt::format("{:.{}f} %", 100 * part, part < 0.1 ? 1 : 0); }
std::string ratio(double x) { return x < 100 ? fmt::format("{:#.3g}", x) : brief(std::round(x), 4); }

bool of_instrument(const std::vector<std::string>& effects) {
  static const std::set<std::string> all = {"sensor_offset", "sensor_gain", "sensor_lag", "clock_shift", "saturation"};
  return !effects.empty() && std::all_of(effects.begin(), effects.end(), [](const std::string& name) { return all.count(name) > 0; });
}

std::string sentence(const Finding& d) {
  switch (d.verdict) {
    case Verdict::nothing_missing: return "Nothing is missing: the case explains these recordings down to their noise.";
    case Verdict::parameters_only: return "No physics is missing. Numbers of the case were off; calibrated, it explains these recordings.";
    case Verdict::unexplained: return "Something is missing, and no effect of the catalogue accounts for it.";
    case Verdict::insufficient_data: return "These recordings cannot tell.";
    case Verdict::omitted_physics: break;
  }
  if (of_instrument(d.effects)) return fmt::format("The instrument, not the physics: {}.", joined(d.effects));
  return fmt::format("{} {} missing from the case.", capital(joined(d.effects)), d.effects.size() > 1 ? "are" : "is");
}

std::string look_for(Verdict verdict) { return fmt::format("{}:root{{--accent:{}}}", style, accent_of(verdict)); }

}  // namespace quern::page
