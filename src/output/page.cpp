#include "src/output/page.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include "src/output/axis_scale.hpp"
#include "src/output/palette.hpp"
#include "src/output/report_scripts.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

using Json = nlohmann::ordered_json;

const char* const style = R"(
*{box-sizing:border-box}
body{font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;color:#222226;background:#fff;max-width:72rem;margin:0 auto;padding:1rem 1.1rem 3rem;overflow-wrap:break-word}
h1{font-size:1.5rem;line-height:1.25;font-weight:650;margin:.4rem 0 .2rem}
h2{font-size:1.2rem;margin:2.2rem 0 .6rem}
p{margin:.5rem 0;max-width:46rem}
.note,figcaption{font-size:.85rem;color:#55555c}
.warning{border-left:.4rem solid #d55e00;background:#fdf3ec;padding:.6rem 1rem;border-radius:.2rem}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,12.5rem),1fr));gap:.7rem;margin:1rem 0}
.cards div{background:#f6f6f7;border-radius:.3rem;padding:.6rem .8rem}
.cards b{display:block;font-size:1.2rem;line-height:1.3;font-weight:600;font-variant-numeric:tabular-nums}
.cards span{font-size:.85rem;color:#55555c}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,29rem),1fr));gap:1.6rem 2rem;margin:1rem 0;align-items:start}
figure{margin:0;min-width:0;break-inside:avoid}
figcaption{font-weight:600;font-size:1rem;color:#222226;margin-bottom:.3rem}
svg,img{width:100%;height:auto;display:block;font-family:inherit}
.stage{height:min(34rem,70vh);width:100%;border:1px solid #e2e2e5;border-radius:.3rem;overflow:hidden;touch-action:pan-y}
.stage>div,.stage canvas{width:100%;height:100%;display:block}
.row{display:flex;flex-wrap:wrap;gap:.4rem .9rem;align-items:center;margin-top:.5rem;font-size:.9rem}
.row input[type=range]{flex:1 1 8rem;min-width:6rem}
.row output{font-variant-numeric:tabular-nums;min-width:6.5rem}
.play{width:2.6rem}
.key{display:inline-flex;flex-wrap:wrap;gap:.2rem .5rem;align-items:center;font-variant-numeric:tabular-nums}
.key i{display:inline-block;width:9rem;height:.8rem;border-radius:.15rem}
.swatch b{display:inline-block;width:.8rem;height:.8rem;border-radius:50%;margin:0 .3rem 0 .4rem;vertical-align:-.05rem}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.92rem;margin:.6rem 0;font-variant-numeric:tabular-nums}
th{text-align:left;font-weight:600;border-bottom:1.5px solid #222226;padding:.25rem .8rem .25rem 0;vertical-align:bottom}
th button{all:unset;cursor:pointer}
th button:focus-visible{outline:2px solid #0072b2}
th[aria-sort=ascending] button::after{content:" ▲"}
th[aria-sort=descending] button::after{content:" ▼"}
td{border-bottom:1px solid #e2e2e5;padding:.25rem .8rem .25rem 0;vertical-align:top}
td.n,th.n{text-align:right;white-space:nowrap}
td .note{display:block}
code,pre{font-family:ui-monospace,"DejaVu Sans Mono",monospace;font-size:.88em}
pre{white-space:pre-wrap;overflow-wrap:anywhere;background:#f6f6f7;padding:.8rem;border-radius:.3rem}
summary{cursor:pointer}
ul.files{columns:18rem;padding-left:1.2rem}
.dial{max-width:31rem}
a{color:#00569b}
@media(max-width:30rem){.cards{grid-template-columns:1fr 1fr}.cards b{font-size:1rem}td,th{padding-right:.5rem}table{font-size:.85rem}.stage{height:60vh}h1{font-size:1.25rem}}
@media print{body{font-size:10pt;max-width:none;padding:0}.stage,.controls,.screen{display:none!important}h2{break-after:avoid}
.plots{grid-template-columns:1fr 1fr}.cards div{border:1px solid #d0d0d5}tr{break-inside:avoid}.charge3d .still{max-width:14cm}pre{font-size:7.5pt}}
)";

// Of plots that zoom; in print those stand still.
const char* const plot_style = R"(
button,select{font:inherit;font-size:.85rem;padding:.15rem .6rem;border:1px solid #b9b9c0;border-radius:.3rem;background:#fff;color:inherit;cursor:pointer}
figure.drawn>.still{display:none}
.live>div{position:relative;margin-bottom:.6rem}
.legend{display:flex;flex-wrap:wrap;gap:0 1.1rem;font-size:.85rem;min-height:1.5rem;padding-left:3.6rem;font-variant-numeric:tabular-nums}
.legend button{all:unset;cursor:pointer;box-sizing:border-box}
.legend button:focus-visible{outline:2px solid #0072b2}
.legend [hidden]{display:none}
.legend .off{opacity:.35}
.legend i{display:inline-block;width:.8rem;height:.8rem;border-radius:.15rem;vertical-align:-.05rem;margin-right:.3rem}
.legend b{font-weight:600}
.legend .x{color:#55555c}
.whole{position:absolute;top:.9rem;right:1.2rem;z-index:110}
@media(max-width:30rem){.legend{padding-left:0}}
@media print{.live{display:none!important}figure.drawn>.still{display:block}}
)";

// No text may end the script that it stands in.
std::string within_script(std::string text) {
  for (std::size_t at = text.find("</"); at != text.npos; at = text.find("</", at + 3)) text.replace(at, 2, "<\\/");
  return text;
}

Json rounded(const std::vector<double>& numbers) {
  Json list = Json::array();
  for (const double x : numbers) {
    if (std::isfinite(x)) list.push_back(std::stod(fmt::format("{:.6g}", x)));
    else list.push_back(nullptr);
  }
  return list;
}

std::string colour_of(const Panel& panel, std::size_t k) {
  const int like = panel.curves[k].like;
  const Colour& c = palette[(like < 0 ? k : static_cast<std::size_t>(like)) % palette.size()];
  return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(255 * c[0] + 0.5), static_cast<int>(255 * c[1] + 0.5), static_cast<int>(255 * c[2] + 0.5));
}

// Of more points than a page should carry, the least and the greatest of each stretch.
Curve thinned(const Curve& curve) {
  constexpr std::size_t most = 4000;
  const std::size_t count = std::min(curve.x.size(), curve.y.size());
  if (count <= most) return curve;
  Curve out{curve.name, {}, {}, {}, {}, curve.marks, curve.joined, curve.like, curve.small};
  const bool interval = curve.lower.size() == curve.y.size() && curve.upper.size() == curve.y.size();
  const auto keep = [&](std::size_t k) {
    out.x.push_back(curve.x[k]), out.y.push_back(curve.y[k]);
    if (interval) out.lower.push_back(curve.lower[k]), out.upper.push_back(curve.upper[k]);
  };
  for (std::size_t s = 0; s < most / 2; ++s) {
    const auto from = static_cast<std::ptrdiff_t>(s * count / (most / 2)), to = static_cast<std::ptrdiff_t>((s + 1) * count / (most / 2));
    const auto [least, greatest] = std::minmax_element(curve.y.begin() + from, curve.y.begin() + to);
    const auto a = static_cast<std::size_t>(least - curve.y.begin()), b = static_cast<std::size_t>(greatest - curve.y.begin());
    keep(std::min(a, b));
    if (a != b) keep(std::max(a, b));
  }
  return out;
}

Json json_of(const Chart& chart) {
  Json panels = Json::array();
  for (const Panel& panel : chart.panels) {
    Json curves = Json::array();
    for (std::size_t k = 0; k < panel.curves.size(); ++k) {
      const Curve curve = thinned(panel.curves[k]);
      Json one = {{"name", curve.name}, {"colour", colour_of(panel, k)}, {"marks", curve.marks}, {"joined", curve.joined}, {"small", curve.small}, {"x", rounded(curve.x)}, {"y", rounded(curve.y)}};
      if (curve.lower.size() == curve.y.size() && curve.upper.size() == curve.y.size()) one["lower"] = rounded(curve.lower), one["upper"] = rounded(curve.upper);
      curves.push_back(std::move(one));
    }
    Json told = {{"x", panel.x_label}, {"y", panel.y_label}, {"logX", panel.log_x}, {"logY", panel.log_y}, {"curves", std::move(curves)}};
    if (panel.marked) told["marked"] = *panel.marked;
    panels.push_back(std::move(told));
  }
  return {{"panels", std::move(panels)}};
}

double half_of(const Headline& headline) {
  const double half = headline.ci95 ? 0.5 * ((*headline.ci95)[1] - (*headline.ci95)[0]) : 0;
  return std::isfinite(half) && half > 0 ? half : 0;
}

// Digits behind the point that an uncertainty leaves; no fewer than none.
int decimals_of(double half) { return std::clamp(1 - static_cast<int>(std::floor(std::log10(half))), 0, 8); }

std::string plain(double value, int digits = 4) {
  std::string text = fmt::format("{:.{}g}", value, digits);
  if (const auto at = text.find('e'); at != text.npos) text = text.substr(0, at) + "·10" + superscript(std::stoi(text.substr(at + 1)));
  if (text[0] == '-') text = "−" + text.substr(1);
  return text;
}

std::string fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  return text[0] == '-' ? "−" + text.substr(1) : text;
}

// Too small or large for a row of digits.
bool needs_power(double value) { return value != 0 && (std::abs(value) < 1e-3 || std::abs(value) >= 1e7); }

}  // namespace

std::string page_of(const std::string& title, const std::string& look, const std::string& body, bool charge) {
  std::string page = fmt::format("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
                                 "<link rel=\"icon\" href=\"data:,\"><title>{}</title>\n<style>{}{}</style></head><body>\n", escaped_html(title), plot_style, look);
  page += body;
  for (const std::string_view script : {plots_script(), charge ? charge_script() : std::string_view()})
    if (!script.empty()) page.append("<script>").append(script).append("</script>\n");
  return page + "</body></html>\n";
}

std::string whole_page(const std::string& title, const std::string& body, bool charge) { return page_of(title, style, body, charge); }

std::string data_of(const char* kind, const std::string& text) { return fmt::format("<script type=\"text/plain\" class=\"{}\">{}</script>", kind, within_script(text)); }

std::string figure_of(const Chart& chart, const std::string& title) { return captioned_figure_of(chart, escaped_html(title)); }

std::string captioned_figure_of(const Chart& chart, const std::string& caption) {
  return fmt::format("<figure class=\"chart\">{}<div class=\"still\">{}</div>{}</figure>\n", caption.empty() ? "" : fmt::format("<figcaption>{}</figcaption>", caption), svg_of(chart),
                     plots_script().empty() ? "" : data_of("chart", json_of(chart).dump()));
}

std::string spoken_value(const Headline& headline) {
  const double value = headline.value, half = half_of(headline);
  if (!std::isfinite(value)) return "";
  if (half == 0) return plain(value);
  if (needs_power(std::max(std::abs(value), half))) {
    // No digit of the value below the second of its uncertainty.
    const int digits = std::max(1, static_cast<int>(std::floor(std::log10(std::max(std::abs(value), half))) - std::floor(std::log10(half))) + 2);
    return (std::abs(value) < 0.05 * half ? "0" : plain(value, digits)) + " ± " + plain(half, 2);
  }
  return fixed(value, decimals_of(half)) + " ± " + fixed(half, decimals_of(half));
}

std::string spoken_with_unit(const Headline& headline) {
  Headline shown = headline;
  std::string unit = unit_symbol(headline.unit);
  const auto scale = [&](double factor) {
    shown.value *= factor;
    if (shown.ci95) (*shown.ci95)[0] *= factor, (*shown.ci95)[1] *= factor;
  };
  const double size = std::abs(headline.value);
  if (headline.key == "energy_closure") {
    scale(100), unit = "%";
  } else if (headline.unit == "J" || headline.unit == "W" || headline.unit == "N" || headline.unit == "N/m" || headline.unit == "Pa") {
    struct Prefix {
      double from, factor;
      const char* sign;
    };
    constexpr Prefix prefixes[] = {{2e9, 1e-9, "G"}, {2e6, 1e-6, "M"}, {2e3, 1e-3, "k"}, {0.2, 1, ""}, {2e-4, 1e3, "m"}, {2e-7, 1e6, "µ"}, {2e-10, 1e9, "n"}};
    for (const Prefix& one : prefixes) {
      if (size < one.from) continue;
      scale(one.factor), unit = one.sign + unit;
      break;
    }
  }
  const std::string value = spoken_value(shown);
  if (unit == "°") return value + unit;
  return unit.empty() ? value : value + "\u00a0" + unit;
}

std::string spoken_interval(const Headline& headline) {
  const double half = half_of(headline);
  if (half == 0) return "";
  const auto [low, high] = *headline.ci95;
  if (needs_power(std::max(std::abs(low), std::abs(high)))) return plain(low, 3) + " … " + plain(high, 3);
  return fixed(low, decimals_of(half)) + " … " + fixed(high, decimals_of(half));
}

std::string unit_symbol(const std::string& unit) {
  if (unit == "1") return "";
  if (unit == "deg") return "°";
  std::string text = unit;
  for (const auto& [from, to] : {std::pair("^2", "²"), std::pair("^3", "³")})
    if (const auto at = text.find(from); at != text.npos) text.replace(at, 2, to);
  return text;
}

std::string spoken_name(std::string key) {
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

}  // namespace quern
