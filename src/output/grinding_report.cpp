#include "src/output/grinding_report.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include "src/base/whole_file.hpp"
#include "src/output/tables.hpp"

namespace quern {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double or_unknown(const std::optional<double>& x) { return x.value_or(unknown); }
double end_of(const std::optional<Interval95>& interval, std::size_t side) { return interval ? (*interval)[side] : unknown; }

std::string rate_unit(const GrindingStudy& study) { return study.time_unit == "1" ? "1" : "1/" + study.time_unit; }

std::string with_unit(const std::string& name, const std::string& unit) { return unit.empty() || unit == "1" ? name : name + " [" + unit + "]"; }

// An interval as people write it; an open end in words.
std::string spoken(const std::optional<Interval95>& interval, double scale = 1) {
  if (!interval) return "no interval";
  const bool none = !((*interval)[0] > 0), any = !std::isfinite((*interval)[1]);
  if (none && any) return "open";
  if (none) return fmt::format("at most {:.3g}", (*interval)[1] / scale);
  if (any) return fmt::format("at least {:.3g}", (*interval)[0] / scale);
  return fmt::format("{:.3g} … {:.3g}", (*interval)[0] / scale, (*interval)[1] / scale);
}

// Of a number of either sign.
std::string spoken_number(const std::optional<Interval95>& interval) {
  if (!interval) return "no interval";
  const auto [low, high] = *interval;
  if (std::isinf(low) && std::isinf(high)) return "open";
  if (std::isinf(low)) return fmt::format("at most {:.3g}", high);
  return std::isinf(high) ? fmt::format("at least {:.3g}", low) : fmt::format("{:.3g} … {:.3g}", low, high);
}

Column words(const std::string& name, const std::string& description) { return {name, "1", description, {}, {}}; }
Column numbers(const std::string& name, const std::string& unit, const std::string& description) { return {name, unit, description, {}, {}}; }

Table sizes_table(const GrindingStudy& study, const GrindingResult& result) {
  Column run = words("run", "operating point"), measure = words("measure", "which size"), time = numbers("t", study.time_unit, "time"),
         size = numbers("size", study.size_unit, "as measured"), fitted = numbers("fitted", study.size_unit, "by first-order kinetics"),
         shaped = numbers("fitted_free_shape", study.size_unit, "by exp(−(K t)^m) with m free");
  for (std::size_t m = 0; m < result.measures.size(); ++m) {
    for (const RateResult& r : result.measures[m].rates) {
      const SizeSeries& s = study.points[r.point].series[m];
      for (std::size_t k = 0; k < s.times.size(); ++k) {
        run.labels.push_back(study.points[r.point].label), measure.labels.push_back(result.measures[m].measure);
        time.values.push_back(s.times[k]), size.values.push_back(s.sizes[k]), fitted.values.push_back(r.fit.at(s.times[k]));
        shaped.values.push_back(r.shape ? r.shape->fit.at(s.times[k]) : unknown);
      }
    }
  }
  return {"sizes", "Sizes as measured and as fitted", {run, measure, time, size, fitted, shaped}};
}

Table kinetics_table(const GrindingStudy& study, const GrindingResult& result) {
  const std::string& size = study.size_unit;
  Column run = words("run", "operating point"), measure = words("measure", "which size"), x = numbers(study.x_name.empty() ? "x" : study.x_name, study.x_unit, "what the rate is held against"),
         rate = numbers("K_p", rate_unit(study), "rate constant"), from = numbers("K_p_from", rate_unit(study), "of its 95 % interval"), to = numbers("K_p_to", rate_unit(study), "of its 95 % interval; empty: open"),
         start = numbers("D_0", size, "size at the start, fitted"), limit = numbers("D_limit", size, "size in the end"), known = words("limit_is", "known or fitted"),
         points = numbers("points", "1", "sizes measured"), scatter = numbers("scatter", size, "standard deviation of the sizes about the fit"),
         held = numbers("held_out", size, "error of sizes left out and predicted, root mean square"), held_shape = numbers("held_out_free_shape", size, "the same with m free"),
         shape = numbers("shape", "1", "m of exp(−(K t)^m); 1: first order"), shape_from = numbers("shape_from", "1", "of its 95 % interval"), shape_to = numbers("shape_to", "1", "of its 95 % interval"),
         p = numbers("p_first_order", "1", "probability of so much better a fit with m free if the kinetics are first-order");
  for (const MeasureResult& one : result.measures) {
    for (const RateResult& r : one.rates) {
      run.labels.push_back(study.points[r.point].label), measure.labels.push_back(one.measure);
      x.values.push_back(or_unknown(study.points[r.point].x));
      rate.values.push_back(r.open ? unknown : r.fit.rate), from.values.push_back(end_of(r.fit.rate_ci95, 0)), to.values.push_back(end_of(r.fit.rate_ci95, 1));
      start.values.push_back(r.fit.start), limit.values.push_back(r.fit.limit), known.labels.push_back(r.limit_known ? "known" : "fitted");
      points.values.push_back(r.fit.points), scatter.values.push_back(r.fit.freedom() > 0 ? r.fit.scatter() : unknown);
      held.values.push_back(or_unknown(r.held_out)), held_shape.values.push_back(or_unknown(r.held_out_shape));
      shape.values.push_back(r.shape ? r.shape->fit.shape : unknown);
      shape_from.values.push_back(r.shape ? end_of(r.shape->shape_ci95, 0) : unknown), shape_to.values.push_back(r.shape ? end_of(r.shape->shape_ci95, 1) : unknown);
      p.values.push_back(r.shape ? r.shape->p_first_order : unknown);
    }
  }
  Table table{"kinetics", "First-order kinetics of every series", {run, measure}};
  if (!study.x_name.empty()) table.columns.push_back(x);
  for (Column* column : {&rate, &from, &to, &start, &limit, &known, &points, &scatter, &held, &held_shape, &shape, &shape_from, &shape_to, &p}) table.columns.push_back(*column);
  return table;
}

double relative(const std::optional<double>& log_error) { return log_error ? std::expm1(*log_error) : unknown; }

Table law_table(const GrindingStudy& study, const GrindingResult& result) {
  Column measure = words("measure", "which size"), a = numbers("a", rate_unit(study), "K_p at " + study.x_name + " of one unit"), a_from = numbers("a_from", rate_unit(study), "of its 95 % interval"),
         a_to = numbers("a_to", rate_unit(study), "of its 95 % interval"), b = numbers("b", "1", "exponent"), b_from = numbers("b_from", "1", "of its 95 % interval"), b_to = numbers("b_to", "1", "of its 95 % interval"),
         points = numbers("points", "1", "operating points"), lack = numbers("lack", "1", "relative scatter of K_p about the law beyond its errors"),
         p = numbers("p_law", "1", "probability of so much scatter if the law holds"), held = numbers("held_out", "1", "relative error of K_p at points left out and predicted"),
         mean = numbers("held_out_mean", "1", "the same, predicted by the mean of the others");
  for (const MeasureResult& one : result.measures) {
    if (!one.law) continue;
    const PowerLawFit& law = *one.law;
    measure.labels.push_back(one.measure);
    a.values.push_back(law.factor), a_from.values.push_back(end_of(law.factor_ci95, 0)), a_to.values.push_back(end_of(law.factor_ci95, 1));
    b.values.push_back(law.exponent), b_from.values.push_back(end_of(law.exponent_ci95, 0)), b_to.values.push_back(end_of(law.exponent_ci95, 1));
    points.values.push_back(static_cast<double>(law.points.size())), lack.values.push_back(std::expm1(law.lack)), p.values.push_back(or_unknown(law.p_of_law));
    held.values.push_back(relative(law.held_out)), mean.values.push_back(relative(law.held_out_mean));
  }
  return {"power_law", "K_p = a x^b, x: " + with_unit(study.x_name, study.x_unit), {measure, a, a_from, a_to, b, b_from, b_to, points, lack, p, held, mean}};
}

constexpr double beyond = 1.1;  // curves go on past the last point, which the frame would cut otherwise

// Spread over a range: evenly, or evenly in the logarithm.
std::vector<double> spread(double from, double to, bool log) {
  constexpr int count = 160;
  std::vector<double> out;
  for (int k = 0; k <= count; ++k) out.push_back(log ? from * std::pow(to / from, k / double{count}) : from + (to - from) * k / count);
  return out;
}

Chart sizes_chart(const GrindingStudy& study, const MeasureResult& one, std::size_t m, const std::string& title) {
  Panel panel{with_unit("time", study.time_unit), with_unit(one.measure, study.shown_size_unit), false, false, {}};
  double first = std::numeric_limits<double>::infinity(), last = 0;
  for (const RateResult& r : one.rates)
    for (const double t : study.points[r.point].series[m].times) {
      if (t > 0) first = std::min(first, t);
      last = std::max(last, t);
    }
  constexpr double wide = 30;  // beyond it the early times could not be told apart on a linear axis
  panel.log_x = last > wide * first;
  for (const RateResult& r : one.rates) {
    const SizeSeries& s = study.points[r.point].series[m];
    const int colour = static_cast<int>(panel.curves.size());
    Curve measured{study.points[r.point].label, s.times, s.sizes, {}, {}, true, false, colour}, fitted{"", spread(panel.log_x ? first : 0, s.times.back() * beyond, panel.log_x), {}, {}, {}, false, true, colour};
    for (double& y : measured.y) y /= study.shown_size;
    for (const double t : fitted.x) fitted.y.push_back(r.fit.at(t) / study.shown_size);
    panel.curves.push_back(measured);
    panel.curves.push_back(fitted);
  }
  // Colours follow the series, not the curves that belong to each.
  int series = -1;
  for (Curve& curve : panel.curves) curve.like = curve.marks ? ++series : series;
  return {"sizes_" + one.measure + ".png", one.measure + " and first-order kinetics" + (title.empty() ? "" : " · " + title), {panel}};
}

Chart decline_chart(const GrindingStudy& study, const MeasureResult& one, std::size_t m, const std::string& title) {
  Panel panel{"K_p t", "(D − D∞) / (D0 − D∞)", false, true, {}};
  constexpr double shown_to = 5;
  Curve law{"exp(−K_p t)", spread(0, shown_to, false), {}, {}, {}, false, true, 0};
  for (const double x : law.x) law.y.push_back(std::exp(-x));
  panel.curves.push_back(law);
  int series = 0;
  for (const RateResult& r : one.rates) {
    if (r.open) continue;
    const SizeSeries& s = study.points[r.point].series[m];
    Curve curve{study.points[r.point].label, {}, {}, {}, {}, true, false, ++series};
    for (std::size_t k = 0; k < s.times.size(); ++k) {
      const double x = r.fit.rate * s.times[k], y = (s.sizes[k] - r.fit.limit) / (r.fit.start - r.fit.limit);
      if (x <= shown_to && y > 0) curve.x.push_back(x), curve.y.push_back(y);
    }
    panel.curves.push_back(curve);
  }
  return {"decline_" + one.measure + ".png", "Decline of " + one.measure + (title.empty() ? "" : " · " + title), {panel}};
}

Chart rates_chart(const GrindingStudy& study, const MeasureResult& one, const std::string& title) {
  Panel panel{with_unit(study.x_name, study.x_unit), with_unit("K_p", rate_unit(study)), true, true, {}};
  Curve measured{"K_p of " + one.measure, {}, {}, {}, {}, true, false, 0};
  for (const RateResult& r : one.rates) {
    const auto& x = study.points[r.point].x;
    if (!x || r.open) continue;
    measured.x.push_back(*x), measured.y.push_back(r.fit.rate);
    // An open end is drawn as a factor of three.
    constexpr double open = 3;
    const auto [low, high] = r.fit.rate_ci95.value_or(Interval95{r.fit.rate, r.fit.rate});
    measured.lower.push_back(low > 0 ? low : r.fit.rate / open), measured.upper.push_back(std::isfinite(high) ? high : r.fit.rate * open);
  }
  if (one.law && !measured.x.empty()) {
    const auto [low, high] = std::minmax_element(measured.x.begin(), measured.x.end());
    Curve law{fmt::format("a x^{:.2f}, and its 95 % interval", one.law->exponent), spread(*low / beyond, *high * beyond, true), {}, {}, {}, false, true, 1};
    for (const double x : law.x) {
      law.y.push_back(one.law->at(x));
      const auto band = one.law->band_at(x);
      if (band) law.lower.push_back((*band)[0]), law.upper.push_back((*band)[1]);
    }
    panel.curves.push_back(law);
  }
  panel.curves.push_back(measured);
  return {"rates_" + one.measure + ".png", "Rate constant against " + study.x_name + (title.empty() ? "" : " · " + title), {panel}};
}

}  // namespace

std::vector<Table> grinding_tables(const GrindingStudy& study, const GrindingResult& result) {
  std::vector<Table> tables = {sizes_table(study, result), kinetics_table(study, result)};
  if (std::any_of(result.measures.begin(), result.measures.end(), [](const MeasureResult& one) { return one.law.has_value(); })) tables.push_back(law_table(study, result));
  return tables;
}

std::vector<Headline> grinding_headlines(const GrindingStudy& study, const GrindingResult& result) {
  std::vector<Headline> all;
  for (const MeasureResult& one : result.measures) {
    const std::string& d = one.measure;
    if (one.rates.size() == 1) {
      const RateResult& r = one.rates[0];
      all.push_back({"rate_constant_" + d, r.open ? unknown : r.fit.rate, rate_unit(study), r.fit.rate_ci95, "K_p of (D − D∞)/(D0 − D∞) = exp(−K_p t)"});
      all.push_back({"start_size_" + d, r.fit.start, study.size_unit, {}, "D0, fitted"});
      all.push_back({"limit_size_" + d, r.fit.limit, study.size_unit, {}, r.limit_known ? "D∞, as given" : "D∞, fitted"});
    }
    int tested = 0, refuted = 0;
    constexpr double doubtful = 0.05;
    for (const RateResult& r : one.rates) tested += r.shape.has_value(), refuted += r.shape && r.shape->p_first_order < doubtful;
    all.push_back({"series_tested_" + d, static_cast<double>(tested), "1", {}, "series with enough points to tell first-order kinetics from others"});
    all.push_back({"series_not_first_order_" + d, static_cast<double>(refuted), "1", {}, "of them: not first-order (p < 0.05)"});
    if (!one.law) continue;
    all.push_back({"rate_exponent_" + d, one.law->exponent, "1", one.law->exponent_ci95, "b of K_p = a x^b, x: " + with_unit(study.x_name, study.x_unit)});
    all.push_back({"rate_factor_" + d, one.law->factor, rate_unit(study), one.law->factor_ci95, "a of K_p = a x^b: K_p where x is one unit"});
    all.push_back({"rate_lack_of_fit_" + d, std::expm1(one.law->lack), "1", {}, "relative scatter of K_p about the law beyond the errors of measurement"});
    all.push_back({"rate_held_out_error_" + d, relative(one.law->held_out), "1", {}, "relative error of K_p at operating points left out, predicted by the law of the others"});
    all.push_back({"rate_held_out_error_of_mean_" + d, relative(one.law->held_out_mean), "1", {}, "the same, predicted by the mean of the others"});
  }
  return all;
}

std::vector<Chart> grinding_charts(const GrindingStudy& study, const GrindingResult& result, const std::string& title) {
  std::vector<Chart> charts;
  for (std::size_t m = 0; m < result.measures.size(); ++m) {
    const MeasureResult& one = result.measures[m];
    if (one.rates.empty()) continue;
    charts.push_back(sizes_chart(study, one, m, title));
    if (std::any_of(one.rates.begin(), one.rates.end(), [](const RateResult& r) { return !r.open; })) charts.push_back(decline_chart(study, one, m, title));
    if (!study.x_name.empty()) charts.push_back(rates_chart(study, one, title));
  }
  return charts;
}

void write_grinding(const GrindingStudy& study, const GrindingResult& result, const std::string& directory) {
  for (const Table& table : grinding_tables(study, result)) write_whole_file(directory + "/" + table.name + ".csv", csv_of(table));
  write_whole_file(directory + "/summary.json", json_of(grinding_headlines(study, result)));
}

std::vector<std::string> grinding_words(const GrindingStudy& study, const GrindingResult& result) {
  std::vector<std::string> lines;
  std::size_t wide = 3;
  for (const GrindingPoint& point : study.points) wide = std::max(wide, point.label.size());
  const std::string& size = study.shown_size_unit;
  constexpr double doubtful = 0.05;
  for (const MeasureResult& one : result.measures) {
    lines.push_back(fmt::format("{}", one.measure));
    lines.push_back(fmt::format("  {:{}}  {:>12}  {:24}  {:>10}  {:>10}  {:>10}  {}", "run", wide, with_unit("K_p", rate_unit(study)), "95 % interval", with_unit("D0", size), with_unit("D∞", size), "held out", "order"));
    for (const RateResult& r : one.rates) {
      std::string order = "cannot be told";
      if (r.shape) order = fmt::format("{}: m {:.2f} ({}), p {:.2g}", r.shape->p_first_order < doubtful ? "NOT first" : "may be first", r.shape->fit.shape, spoken(r.shape->shape_ci95), r.shape->p_first_order);
      lines.push_back(fmt::format("  {:{}}  {:>12}  {:24}  {:10.4g}  {:10.4g}  {:>10}  {}", study.points[r.point].label, wide, r.open ? "open" : fmt::format("{:.4g}", r.fit.rate), spoken(r.fit.rate_ci95),
                                  r.fit.start / study.shown_size, r.fit.limit / study.shown_size, r.held_out ? fmt::format("{:.3g}", *r.held_out / study.shown_size) : "–", order));
    }
    if (!one.law) continue;
    const PowerLawFit& law = *one.law;
    lines.push_back(fmt::format("  K_p = a {}^b: b = {:.3g} ({}), a = {:.4g} {} ({}), {} points", study.x_name, law.exponent, spoken_number(law.exponent_ci95), law.factor, rate_unit(study), spoken(law.factor_ci95), law.points.size()));
    if (law.held_out)
      lines.push_back(fmt::format("  held out: K_p is predicted to {:.0f} % (by the mean of the others to {:.0f} %){}", 100 * relative(law.held_out), 100 * relative(law.held_out_mean),
                                  law.p_of_law ? fmt::format("; the law misses {:.0f} % beyond the errors (p {:.2g})", 100 * std::expm1(law.lack), *law.p_of_law) : ""));
  }
  return lines;
}

}  // namespace quern
