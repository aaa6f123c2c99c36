#include "src/output/breakage_report.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include "src/base/whole_file.hpp"
#include "src/output/tables.hpp"

namespace quern {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double speed_of(double energy) { return std::sqrt(2 * energy); }

// Everything at one energy.
struct Row {
  const Level* damage = nullptr;
  const Level* t10 = nullptr;
  const BreakageCount* count = nullptr;
};

std::map<double, Row> rows_of(const BreakageResult& result) {
  // Energies that were gathered by rounding may differ in their last bits between the three.
  std::map<double, Row> rows;
  constexpr double rounding = 1e-9;
  const auto row = [&](double energy) -> Row& {
    const auto near = rows.lower_bound(energy * (1 - rounding));
    return near != rows.end() && near->first <= energy * (1 + rounding) ? near->second : rows[energy];
  };
  for (const Level& level : result.damage) row(level.x).damage = &level;
  for (const Level& level : result.t10) row(level.x).t10 = &level;
  for (const BreakageCount& count : result.counts) row(count.energy).count = &count;
  return rows;
}

Table levels_table(const BreakageResult& result) {
  const std::map<double, Row> rows = rows_of(result);
  Table table{"breakage", "what became of the bodies at each specific energy, beside the fits", {}};
  const auto add = [&](const char* name, const char* unit, const char* description, auto&& of) {
    Column column{name, unit, description, {}, {}};
    for (const auto& [energy, row] : rows) column.values.push_back(of(energy, row));
    table.columns.push_back(std::move(column));
  };
  using R = const Row&;
  add("specific_energy", "J/kg", "½ v² of the impact", [](double e, R) { return e; });
  add("speed", "m/s", "of the impact on a fixed wall", [](double e, R) { return speed_of(e); });
  if (!result.damage.empty()) {
    add("damage_runs", "1", "runs with a damage ratio", [](double, R r) { return r.damage ? r.damage->count : 0; });
    add("damage", "1", "mean of bonds that failed over all that were made", [](double, R r) { return r.damage ? r.damage->mean : unknown; });
    add("damage_scatter", "1", "standard deviation of one run", [](double, R r) { return r.damage && r.damage->count > 1 ? r.damage->scatter : unknown; });
    if (result.damage_fit) add("damage_fitted", "1", "threshold, rise and plateau", [&](double e, R) { return result.damage_fit->law.at(e); });
  }
  if (!result.counts.empty()) {
    add("tested", "1", "bodies", [](double, R r) { return r.count ? r.count->tested : 0; });
    add("broken", "1", "of them", [](double, R r) { return r.count ? r.count->broken : 0; });
    const auto part = [](R r) { return proportion_interval(r.count->broken, r.count->tested); };
    add("broken_fraction_from", "1", "of its 95 % interval", [&](double, R r) { return r.count ? part(r)[0] : unknown; });
    add("broken_fraction_to", "1", "of its 95 % interval", [&](double, R r) { return r.count ? part(r)[1] : unknown; });
    if (result.vogel_peukert) add("probability_vogel_peukert", "1", "fitted", [&](double e, R) { return result.vogel_peukert->at(e); });
    if (result.weibull) add("probability_weibull", "1", "fitted", [&](double e, R) { return result.weibull->at(e); });
  }
  if (!result.t10.empty()) {
    add("t10_runs", "1", "runs with a t10", [](double, R r) { return r.t10 ? r.t10->count : 0; });
    add("t10", "1", "mean of the mass finer than a tenth of the body", [](double, R r) { return r.t10 ? r.t10->mean : unknown; });
    add("t10_scatter", "1", "standard deviation of one run", [](double, R r) { return r.t10 && r.t10->count > 1 ? r.t10->scatter : unknown; });
    if (result.t10_fit) add("t10_fitted", "1", "A (1 − exp(−b W))", [&](double e, R) { return result.t10_fit->law.at(e); });
  }
  return table;
}

// The fitted numbers alone; the table of fits and the summary both have them.
std::vector<Headline> fitted_numbers(const BreakageStudy& study, const BreakageResult& result) {
  std::vector<Headline> all;
  const auto of_law = [&](const SaturationFit& fit, const char* key, const char* unit, const char* description, auto&& of) {
    all.push_back({key, of(fit.law), unit, fit.interval(of), description});
  };
  using L = const SaturationLaw&;
  if (result.damage_fit) {
    const SaturationFit& fit = *result.damage_fit;
    of_law(fit, "damage_threshold_energy", "J/kg", "W_0 of damage = P (1 − exp(−((W − W_0)/W_s)^m))", [](L l) { return l.threshold; });
    of_law(fit, "damage_threshold_speed", "m/s", "√(2 W_0)", [](L l) { return speed_of(l.threshold); });
    of_law(fit, "damage_half_energy", "J/kg", "where it has come to half of the plateau", [](L l) { return l.half(); });
    of_law(fit, "damage_half_speed", "m/s", "the same as a speed", [](L l) { return speed_of(l.half()); });
    of_law(fit, "damage_scale_energy", "J/kg", "W_s", [](L l) { return l.scale; });
    if (fit.form.free_shape) of_law(fit, "damage_shape", "1", "m, between 0.5 and 5", [](L l) { return l.shape; });
    of_law(fit, "damage_plateau", "1", result.plateau_reached ? "P" : "P, an extrapolation: the runs do not come to it", [](L l) { return l.plateau; });
  }
  if (result.vogel_peukert) {
    const BreakageFit& fit = *result.vogel_peukert;
    all.push_back({"breakage_rate", fit.first, "kg/J", fit.first_ci95, "f_mat x of S = 1 − exp(−f_mat x (W_m − W_min)), Vogel & Peukert, one impact"});
    all.push_back({"breakage_minimum_energy", fit.second, "J/kg", fit.second_ci95, "W_min"});
    if (study.size) {
      const double x = *study.size;
      all.push_back({"breakage_f_mat", fit.first / x, "kg/J/m", Interval95{fit.first_ci95[0] / x, fit.first_ci95[1] / x}, "f_mat"});
      all.push_back({"breakage_x_w_min", fit.second * x, "J m/kg", Interval95{fit.second_ci95[0] * x, fit.second_ci95[1] * x}, "x W_min"});
    }
  }
  if (result.weibull) {
    all.push_back({"weibull_modulus", result.weibull->first, "1", result.weibull->first_ci95, "m of S = 1 − exp(−(W_m/W_s)^m)"});
    all.push_back({"weibull_energy", result.weibull->second, "J/kg", result.weibull->second_ci95, "W_s, at which 63 % break"});
  }
  if (result.t10_fit) {
    of_law(*result.t10_fit, "t10_slope", "kg/J", "A b: t10 per energy while it is small", [](L l) { return l.initial_slope(); });
    if (result.t10_bends) {
      of_law(*result.t10_fit, "t10_A", "1", "A of t10 = A (1 − exp(−b W)), Narayanan & Whiten", [](L l) { return l.plateau; });
      of_law(*result.t10_fit, "t10_b", "kg/J", "b", [](L l) { return 1 / l.scale; });
    }
  }
  return all;
}

Table fits_table(const std::vector<Headline>& fitted) {
  Column name{"parameter", "1", "as in summary.json", {}, {}}, value{"value", "1", "in its unit", {}, {}}, unit{"unit", "1", "", {}, {}},
      from{"from", "1", "of the 95 % interval", {}, {}}, to{"to", "1", "of the 95 % interval; empty: open", {}, {}};
  for (const Headline& line : fitted) {
    name.labels.push_back(line.key), unit.labels.push_back(line.unit), value.values.push_back(line.value);
    from.values.push_back(line.ci95 ? (*line.ci95)[0] : unknown), to.values.push_back(line.ci95 ? (*line.ci95)[1] : unknown);
  }
  return {"breakage_fits", "the fitted laws", {name, value, from, to, unit}};
}

// Evenly in the logarithm.
std::vector<double> spread(double from, double to) {
  constexpr int count = 240;
  std::vector<double> out;
  for (int k = 0; k <= count; ++k) out.push_back(from * std::pow(to / from, k / double{count}));
  return out;
}

Curve measured(const std::string& name, const std::vector<Level>& levels) {
  Curve curve{name, {}, {}, {}, {}, true, false, 0};
  for (const Level& level : levels) {
    curve.x.push_back(level.x), curve.y.push_back(level.mean);
    curve.lower.push_back(std::max(0.0, level.mean - level.scatter)), curve.upper.push_back(std::min(1.0, level.mean + level.scatter));
  }
  return curve;
}

Curve fitted(const std::string& name, const std::vector<double>& x, const SaturationFit& fit) {
  Curve curve{name, x, {}, {}, {}, false, true, 1};
  for (const double at : x) {
    curve.y.push_back(fit.law.at(at));
    const auto band = fit.interval([&](const SaturationLaw& law) { return law.at(at); });
    if (band) curve.lower.push_back((*band)[0]), curve.upper.push_back((*band)[1]);
  }
  return curve;
}

Curve fitted(const std::string& name, const std::vector<double>& x, const BreakageFit& fit, int colour, bool with_band) {
  Curve curve{name, x, {}, {}, {}, false, true, colour};
  for (const double at : x) {
    curve.y.push_back(fit.at(at));
    if (!with_band) continue;
    const Interval95 band = fit.band_at(at);
    curve.lower.push_back(band[0]), curve.upper.push_back(band[1]);
  }
  return curve;
}

std::string spoken(const std::optional<Interval95>& interval) {
  if (!interval) return "no interval";
  const auto [low, high] = *interval;
  if (!std::isfinite(high)) return low > 0 ? fmt::format("at least {:.3g}", low) : "open";
  return low > 0 ? fmt::format("{:.3g} … {:.3g}", low, high) : fmt::format("at most {:.3g}", high);
}

}  // namespace

std::vector<Table> breakage_tables(const BreakageStudy& study, const BreakageResult& result) {
  std::vector<Table> tables = {levels_table(result)};
  const std::vector<Headline> fitted = fitted_numbers(study, result);
  if (!fitted.empty()) tables.push_back(fits_table(fitted));
  return tables;
}

std::vector<Headline> breakage_headlines(const BreakageStudy& study, const BreakageResult& result) {
  std::vector<Headline> all;
  const auto add = [&](const char* key, double value, const char* unit, const std::string& description) { all.push_back({key, value, unit, {}, description}); };
  add("runs", static_cast<double>(study.runs.size()), "1", "that were studied");
  if (!result.damage.empty()) {
    add("last_unharmed_energy", result.last_unharmed.value_or(unknown), "J/kg", "largest energy below the first damage; null: even the least did damage");
    add("first_harmed_energy", result.first_harmed.value_or(unknown), "J/kg", "least energy at which a run had damage; null: none had");
    double scatter = 0;
    for (const Level& level : result.damage) scatter = std::max(scatter, level.scatter);
    add("damage_scatter_largest", scatter, "1", "largest standard deviation of the damage ratio at one energy");
  }
  if (!result.counts.empty()) {
    int broken = 0, tested = 0;
    for (const BreakageCount& c : result.counts) broken += c.broken, tested += c.tested;
    add("bodies_tested", tested, "1", "single bodies");
    add("bodies_broken", broken, "1", fmt::format("of them, by a largest fragment below {:g} of the mass, or as given", study.broken_below));
  }
  for (Headline& line : fitted_numbers(study, result)) all.push_back(std::move(line));
  const auto p = [&](const char* key, const std::optional<double>& value, const char* of) {
    if (value) add(key, *value, "1", fmt::format("probability of so bad a fit if {} holds", of));
  };
  if (result.damage_fit) p("damage_p", result.damage_fit->p_of_law, "the law of damage");
  if (result.vogel_peukert) p("breakage_p", result.vogel_peukert->p_of_law, "the law of Vogel & Peukert");
  if (result.weibull) p("weibull_p", result.weibull->p_of_law, "that of Weibull");
  if (result.vogel_peukert && result.weibull)
    add("weibull_log_likelihood_gain", result.weibull->log_likelihood - result.vogel_peukert->log_likelihood, "1", "of Weibull's law over Vogel & Peukert's; both have two parameters");
  if (result.t10_fit) p("t10_p", result.t10_fit->p_of_law, "the law of t10");
  return all;
}

std::vector<Chart> breakage_charts(const BreakageStudy& study, const BreakageResult& result, const std::string& title) {
  const std::map<double, Row> rows = rows_of(result);
  if (rows.empty()) return {};
  constexpr double beyond = 1.15;
  const std::vector<double> x = spread(rows.begin()->first / beyond, rows.rbegin()->first * beyond);
  Chart chart{"breakage.png", "Breakage by impact" + (title.empty() ? "" : " · " + title), {}};
  const auto panel = [&](const char* label) -> Panel& { return chart.panels.emplace_back(Panel{"specific energy [J/kg]", label, true, false, {}}); };
  if (!result.damage.empty()) {
    Panel& p = panel("damage ratio");
    if (result.damage_fit) p.curves.push_back(fitted("threshold, rise, plateau", x, *result.damage_fit));
    p.curves.push_back(measured("mean and standard deviation", result.damage));
  }
  if (!result.counts.empty()) {
    Panel& p = panel("part broken");
    if (result.vogel_peukert) p.curves.push_back(fitted("Vogel & Peukert", x, *result.vogel_peukert, 1, true));
    if (result.weibull) p.curves.push_back(fitted("Weibull", x, *result.weibull, 2, false));
    Curve seen{fmt::format("largest fragment below {:g}, 95 %", study.broken_below), {}, {}, {}, {}, true, false, 0};
    for (const BreakageCount& c : result.counts) {
      const Interval95 part = proportion_interval(c.broken, c.tested);
      seen.x.push_back(c.energy), seen.y.push_back(c.broken / static_cast<double>(c.tested)), seen.lower.push_back(part[0]), seen.upper.push_back(part[1]);
    }
    p.curves.push_back(seen);
  }
  if (!result.t10.empty()) {
    Panel& p = panel("t10");
    if (result.t10_fit) p.curves.push_back(fitted("A (1 − exp(−b W))", x, *result.t10_fit));
    p.curves.push_back(measured("mean and standard deviation", result.t10));
  }
  return {chart};
}

void write_breakage(const BreakageStudy& study, const BreakageResult& result, const std::string& directory) {
  for (const Table& table : breakage_tables(study, result)) write_whole_file(directory + "/" + table.name + ".csv", csv_of(table));
  write_whole_file(directory + "/summary.json", json_of(breakage_headlines(study, result)));
}

std::vector<std::string> breakage_words(const BreakageStudy& study, const BreakageResult& result) {
  std::vector<std::string> lines = {fmt::format("{:>10}  {:>9}  {:>20}  {:>12}  {:>20}", "W [J/kg]", "v [m/s]", "damage", "broken", "t10")};
  const auto mean = [](const Level* level) {
    if (!level) return std::string("–");
    return level->count > 1 ? fmt::format("{:.4f} ± {:.4f}", level->mean, level->scatter) : fmt::format("{:.4f}", level->mean);
  };
  for (const auto& [energy, row] : rows_of(result))
    lines.push_back(fmt::format("{:10.4g}  {:9.4g}  {:>20}  {:>12}  {:>20}", energy, speed_of(energy), mean(row.damage), row.count ? fmt::format("{} of {}", row.count->broken, row.count->tested) : "–",
                                mean(row.t10)));
  if (result.last_unharmed && result.first_harmed)
    lines.push_back(fmt::format("First damage between {:.4g} and {:.4g} J/kg ({:.4g} and {:.4g} m/s).", *result.last_unharmed, *result.first_harmed, speed_of(*result.last_unharmed), speed_of(*result.first_harmed)));
  for (const Headline& line : fitted_numbers(study, result))
    lines.push_back(fmt::format("{:24}  {:>10}  {:22}  {}", line.key, fmt::format("{:.4g}", line.value), spoken(line.ci95), line.unit == "1" ? "" : line.unit));
  return lines;
}

}  // namespace quern
