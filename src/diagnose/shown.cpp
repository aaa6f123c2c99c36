#include "src/diagnose/shown.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace quern {
namespace {

// A factor that makes the numbers on an axis short.
struct Prefix {
  double factor = 1;
  std::string unit;
};
Prefix prefix_for(double largest, const std::string& unit) {
  if ((unit != "s" && unit != "m" && unit != "N") || !(largest > 0)) return {1, unit};
  constexpr std::array<std::pair<double, const char*>, 5> prefixes = {{{1e-9, "n"}, {1e-6, "µ"}, {1e-3, "m"}, {1, ""}, {1e3, "k"}}};
  std::pair<double, const char*> best = prefixes[3];
  // Metres and seconds stay as they are down to a tenth.
  if (largest < 0.1 || (largest >= 1e4 && unit == "N"))
    for (const auto& one : prefixes)
      if (largest >= one.first || &one == &prefixes[0]) best = one;
  return {1 / best.first, best.second + unit};
}

double largest_of(const std::vector<double>& numbers) {
  double most = 0;
  for (double x : numbers)
    if (std::isfinite(x)) most = std::max(most, std::abs(x));
  return most;
}

struct Place {
  const RecordedRun* run;
  const RunLinear *before, *after;
  bool sealed;
  std::map<Channel, double> change, left;  // Σ (difference of both simulations, residual afterwards)² over the noise, by channel
  double all_change = 0, all_left = 0, samples = 0;
};

double deviation_at(const Series& series, std::size_t k, const Noise& noise) {
  return noise[static_cast<std::size_t>(series.channel)].deviation * (series.deviation.empty() ? 1 : series.deviation[k]);
}

std::vector<Place> places_of(const Experiment& experiment, const SideBySide& sides) {
  std::vector<Place> places;
  const auto add = [&](const Fit& before, const Fit& after, bool sealed) {
    for (std::size_t k = 0; k < std::min(before.linear.size(), after.linear.size()); ++k) {
      Place place{&experiment.recording().runs[before.runs[k]], &before.linear[k], &after.linear[k], sealed, {}, {}};
      if (!place.before->rest.allFinite() || !place.after->rest.allFinite()) continue;
      Eigen::Index row = 0;
      for (const Series& series : place.run->series)
        for (std::size_t s = 0; s < series.value.size(); ++s, ++row) {
          const double sd = deviation_at(series, s, sides.noise);
          const double last = place.after->rest[row] / sd, moved = sides.one ? last : (place.before->rest[row] - place.after->rest[row]) / sd;
          place.change[series.channel] += moved * moved, place.left[series.channel] += last * last;
          place.all_change += moved * moved, place.all_left += last * last, ++place.samples;
        }
      places.push_back(std::move(place));
    }
  };
  add(sides.train_before, sides.train_after, false);
  if (sides.sealed_before.sound && sides.sealed_after.sound) add(sides.sealed_before, sides.sealed_after, true);
  return places;
}

// Numbers beyond the limits are left out; how many they were.
std::size_t cut_beyond(Curve& curve, double low, double high) {
  std::size_t count = 0;
  Curve kept = curve;
  kept.x.clear(), kept.y.clear();
  for (std::size_t k = 0; k < curve.x.size(); ++k) {
    if (curve.y[k] < low || curve.y[k] > high) ++count;
    else kept.x.push_back(curve.x[k]), kept.y.push_back(curve.y[k]);
  }
  curve = std::move(kept);
  return count;
}

std::string with_unit(const std::string& what, const std::string& unit) { return unit.empty() ? what : fmt::format("{} [{}]", what, unit); }

// All but the wildest of the sizes of some numbers lie within.
double size_of(const std::vector<double>& numbers, double share) {
  std::vector<double> sizes;
  for (double x : numbers) sizes.push_back(std::abs(x));
  if (sizes.empty()) return 0;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

Chart chart_of(const Place& place, Channel channel, const Diagnosis& d, const SideBySide& sides, const std::string& title, std::string& cut_words) {
  Eigen::Index row = 0;
  const Series* series = nullptr;
  for (const Series& one : place.run->series) {
    if (one.channel == channel) {
      series = &one;
      break;
    }
    row += static_cast<Eigen::Index>(one.value.size());
  }
  Chart chart{"diagnosis.png", title, {}};
  const std::size_t n = series->value.size();
  std::vector<double> before, after, rest_before, rest_after;
  for (std::size_t k = 0; k < n; ++k, ++row) {
    const double sd = deviation_at(*series, k, sides.noise);
    before.push_back(series->value[k] - place.before->rest[row]), after.push_back(series->value[k] - place.after->rest[row]);
    rest_before.push_back(place.before->rest[row] / sd), rest_after.push_back(place.after->rest[row] / sd);
  }
  const bool counted = channel == Channel::impact;
  const Prefix x = counted ? Prefix{1, ""} : prefix_for(largest_of(series->t), "s");
  const std::string x_label = counted ? "number of the impact" : with_unit("t", x.unit);
  std::vector<double> at = series->t;
  for (double& t : at) t *= x.factor;
  // Instants of impacts say more by the time from each to the next.
  std::vector<double> shown = series->value, shown_at = at;
  std::string name = name_of(channel), unit = unit_of(channel);
  if (counted && n > 1) {
    const auto steps = [](std::vector<double>& values) {
      for (std::size_t k = 0; k + 1 < values.size(); ++k) values[k] = values[k + 1] - values[k];
      values.pop_back();
    };
    steps(shown), steps(before), steps(after);
    shown_at.pop_back();
    name = "time to the next impact";
  }
  const Prefix y = prefix_for(std::max(largest_of(shown), largest_of(after)), unit);
  for (std::vector<double>* values : {&shown, &before, &after})
    for (double& value : *values) value *= y.factor;
  Panel above{x_label, with_unit(name, spoken_unit(y.unit)), false, false, {}};
  above.curves.push_back({"recorded", shown_at, shown, {}, {}, true, false, 4, n > 40});
  if (!sides.one) above.curves.push_back({sides.before_name, shown_at, before, {}, {}, false, true, 1});
  above.curves.push_back({sides.after_name, shown_at, after, {}, {}, false, true, 0});
  // Wild points would flatten all else.
  const auto [least, most] = std::minmax_element(after.begin(), after.end());
  const auto [least_before, most_before] = std::minmax_element(before.begin(), before.end());
  const double low = std::min(*least, *least_before), high = std::max(*most, *most_before), room = 0.35 * (high - low) + 6 * y.factor * deviation_at(*series, 0, sides.noise);
  std::size_t cut = cut_beyond(above.curves[0], low - room, high + room);
  if (cut > 0) cut_words = fmt::format("{} wild {} beyond the first frame", cut, cut == 1 ? "point" : "points");
  const auto residuals = [&](const std::vector<double>& rest, int colour) {
    Panel panel{x_label, "residual / noise", false, false, {}};
    panel.curves.push_back({"noise ± 2 sd", {at.front(), at.back()}, {0, 0}, {-2, -2}, {2, 2}, false, true, 4});
    panel.curves.push_back({"", at, rest, {}, {}, true, false, colour, n > 40});
    const double limit = std::max(4.0, 1.3 * size_of(rest, 0.98));
    cut += cut_beyond(panel.curves.back(), -limit, limit);
    return panel;
  };
  cut = 0;
  chart.panels = {above};
  if (!sides.one) {
    // What the simulation after adds, through what the one before leaves.
    std::vector<double> added(n);
    for (std::size_t k = 0; k < n; ++k) added[k] = rest_before[k] - rest_after[k];
    chart.panels.push_back(residuals(rest_before, 1));
    chart.panels.back().curves.push_back({"", at, added, {}, {}, false, true, 0});
  }
  chart.panels.push_back(residuals(rest_after, 0));
  if (!sides.one) chart.panels[1].y_label = "residual / noise", chart.panels[2].y_label = "afterwards";
  if (cut > 0) cut_words += fmt::format("{}{} {} beyond the frames below", cut_words.empty() ? "" : ", ", cut, cut == 1 ? "residual" : "residuals");
  if (d.where.channel == name_of(channel) && d.where.to >= d.where.from && (d.where.run.empty() || d.where.run == place.run->label)) {
    const std::array<double, 2> where = {std::clamp(d.where.from * x.factor, at.front(), at.back()), std::clamp(d.where.to * x.factor, at.front(), at.back())};
    if (where[0] < where[1] || counted)
      for (Panel& panel : chart.panels) panel.marked = where;
  }
  return chart;
}

// The condition by which runs differ most, with a value for each place; where there is none their order.
struct Abscissa {
  std::string name, label;
  std::vector<double> values;
};
Abscissa abscissa_of(const std::vector<Place>& places) {
  Abscissa best{"", "run, in the order of the recording", {}};
  std::size_t most = 1;
  for (const auto& [name, first] : places.front().run->conditions) {
    std::set<double> different;
    std::vector<double> values;
    for (const Place& place : places)
      if (const auto found = place.run->conditions.find(name); found != place.run->conditions.end()) values.push_back(found->second), different.insert(found->second);
    if (values.size() < places.size() || different.size() <= most) continue;
    most = different.size();
    const auto known = std::find_if(condition_names.begin(), condition_names.end(), [&](const ConditionName& one) { return name == one.name; });
    const Key* key = find_key(split_path(name));
    std::string unit = known != condition_names.end() ? known->unit : key != nullptr ? key->unit : "1";
    if (unit == "rad") {
      unit = "°";
      for (double& x : values) x *= 180 / std::numbers::pi;
    }
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    best = {words, with_unit(words, spoken_unit(unit)), values};
  }
  if (best.values.empty())
    for (std::size_t k = 0; k < places.size(); ++k) best.values.push_back(static_cast<double>(k + 1));
  return best;
}

// Runs of a few samples each: all of them in one chart, over what they differ by.
Chart chart_over_runs(const std::vector<Place>& places, Channel channel, const SideBySide& sides, const Abscissa& x) {
  struct Point {
    double x, recorded, before, after, rest_before, rest_after;
    bool sealed;
  };
  std::vector<Point> points;
  for (std::size_t p = 0; p < places.size(); ++p) {
    Eigen::Index row = 0;
    for (const Series& series : places[p].run->series)
      for (std::size_t k = 0; k < series.value.size(); ++k, ++row) {
        if (series.channel != channel) continue;
        const double sd = deviation_at(series, k, sides.noise), before = places[p].before->rest[row], after = places[p].after->rest[row];
        points.push_back({x.values[p], series.value[k], series.value[k] - before, series.value[k] - after, before / sd, after / sd, places[p].sealed});
      }
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
  const auto curve = [&](const std::string& name, auto&& value, auto&& wanted, bool joined, int colour) {
    Curve c{name, {}, {}, {}, {}, true, joined, colour};
    for (const Point& point : points)
      if (wanted(point)) c.x.push_back(point.x), c.y.push_back(value(point));
    return c;
  };
  const auto any = [](const Point&) { return true; };
  Panel above{x.label, with_unit(name_of(channel), spoken_unit(unit_of(channel))), false, false, {}}, below{x.label, "residual / noise", false, false, {}};
  above.curves.push_back(curve("recorded", [](const Point& p) { return p.recorded; }, [](const Point& p) { return !p.sealed; }, false, 4));
  above.curves.push_back(curve("recorded, sealed", [](const Point& p) { return p.recorded; }, [](const Point& p) { return p.sealed; }, false, 3));
  if (!sides.one) above.curves.push_back(curve(sides.before_name, [](const Point& p) { return p.before; }, any, true, 1));
  above.curves.push_back(curve(sides.after_name, [](const Point& p) { return p.after; }, any, true, 0));
  std::erase_if(above.curves, [](const Curve& c) { return c.x.empty(); });
  for (Curve& c : above.curves)
    if (c.joined) c.marks = false;
  below.curves.push_back({"noise ± 2 sd", {points.front().x, points.back().x}, {0, 0}, {-2, -2}, {2, 2}, false, true, 4});
  if (!sides.one) below.curves.push_back(curve("", [](const Point& p) { return p.rest_before; }, any, false, 1));
  below.curves.push_back(curve("", [](const Point& p) { return p.rest_after; }, any, false, 0));
  return {"diagnosis.png", fmt::format("{} of all runs", name_of(channel)), {above, below}};
}

}  // namespace

SideBySide side_by_side(const Experiment& experiment, const Diagnosis& d, ThreadTeam& team) {
  SideBySide s;
  s.noise = d.best.noise;
  s.train_before = d.baseline, s.train_after = d.best;
  s.sealed_before = d.sealed_baseline, s.sealed_after = d.sealed_best;
  s.before_name = d.baseline.moved.empty() ? "the case" : "the case, calibrated";
  if (d.verdict == Verdict::omitted_physics) {
    s.after_name = fmt::format("with {}", fmt::join(d.effects, " and "));
    std::replace(s.after_name.begin(), s.after_name.end(), '_', ' ');
  } else if (d.verdict == Verdict::unexplained && !d.best.settings.empty()) {
    s.after_name = "with the learnt force";
  } else {
    s.after_name = s.before_name, s.one = true;
  }
  if (d.verdict == Verdict::parameters_only) {
    s.one = false;
    s.before_name = "the case as it stands", s.after_name = "calibrated";
    Fit nominal = d.baseline;
    for (std::size_t k = 0; k < nominal.moved.size(); ++k) nominal.shared[k] = nominal.moved[k].value;
    const Comparison comparison(experiment, team);
    s.train_before = comparison.carry_over(nominal, d.baseline.runs);
    if (!d.sealed_baseline.runs.empty()) s.sealed_before = comparison.carry_over(nominal, d.sealed_baseline.runs);
    s.train_after = d.baseline, s.sealed_after = d.sealed_baseline;
  }
  return s;
}

std::vector<RunMisfit> misfit_by_run(const Experiment& experiment, const SideBySide& sides, ThreadTeam& team) {
  const Comparison comparison(experiment, team);
  std::vector<RunMisfit> all;
  const auto add = [&](const Fit& before, const Fit& after, bool sealed) {
    for (std::size_t k = 0; k < std::min(before.linear.size(), after.linear.size()); ++k) {
      const auto of = [&](const Fit& fit) {
        Fit alone;
        alone.runs = {fit.runs[k]}, alone.linear = {fit.linear[k]};
        return alone.linear[0].rest.allFinite() ? comparison.misfit(alone, sides.noise) : std::nan("");
      };
      all.push_back({experiment.recording().runs[before.runs[k]].label, of(before), of(after), sealed});
    }
  };
  add(sides.train_before, sides.train_after, false);
  add(sides.sealed_before, sides.sealed_after, true);
  return all;
}

std::vector<RunChart> telling_runs(const Experiment& experiment, const Diagnosis& d, const SideBySide& sides) {
  const std::vector<Place> places = places_of(experiment, sides);
  std::vector<RunChart> charts;
  if (places.empty()) return charts;
  std::map<Channel, double> change;
  std::size_t longest = 0;
  for (const Place& place : places) {
    for (const auto& [channel, weight] : place.change) change[channel] += weight;
    for (const Series& series : place.run->series) longest = std::max(longest, series.value.size());
  }
  constexpr std::size_t short_run = 4;
  if (places.size() > 1 && longest <= short_run) {
    Channel channel = std::max_element(change.begin(), change.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
    for (const auto& [one, weight] : change)
      if (d.where.channel == name_of(one)) channel = one;
    const Abscissa x = abscissa_of(places);
    return {{x.name.empty() ? "in their order" : "by " + x.name, "", false, chart_over_runs(places, channel, sides, x), ""}};
  }
  std::vector<const Place*> used;
  const auto show = [&](const std::string& why, auto&& value) {
    const Place* best = nullptr;
    for (const Place& place : places)
      if (value(place) > 0 && (best == nullptr || value(place) > value(*best))) best = &place;
    if (best == nullptr || std::find(used.begin(), used.end(), best) != used.end()) return;
    used.push_back(best);
    // The located channel, where this run has it; otherwise the one that tells most.
    Channel channel = std::max_element(best->change.begin(), best->change.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
    for (const auto& [one, weight] : best->change)
      if (d.where.channel == name_of(one)) channel = one;
    RunChart shown{why, best->run->label, best->sealed, {}, ""};
    shown.chart = chart_of(*best, channel, d, sides, fmt::format("{} of run {}", name_of(channel), best->run->label), shown.cut);
    charts.push_back(std::move(shown));
  };
  if (sides.one) {
    const auto misfit = [](const Place& p) { return p.all_left / p.samples; };
    show("where the fit is worst", [&](const Place& p) { return p.sealed ? 0 : misfit(p); });
    show("sealed: the fit has not seen it", [&](const Place& p) { return p.sealed ? misfit(p) : 0; });
  } else {
    show("where it matters most", [&](const Place& p) { return p.sealed || (!d.where.run.empty() && p.run->label != d.where.run) ? 0 : p.all_change; });
    show("sealed: the fit has not seen it", [&](const Place& p) { return p.sealed ? p.all_change : 0; });
    constexpr double noticeable = 1.3;  // mean square over the noise
    show("where most is left afterwards", [&](const Place& p) { return p.all_left > noticeable * p.samples ? p.all_left / p.samples : 0; });
  }
  return charts;
}

std::optional<Chart> learnt_force(const Diagnosis& d) {
  if (d.verdict != Verdict::unexplained) return std::nullopt;
  const auto setting = [&](const std::string& ending) -> const Setting* {
    for (const Setting& s : d.best.settings)
      if (s.key.ends_with(ending)) return &s;
    return nullptr;
  };
  const bool contact = setting("extra_force_at") != nullptr;
  const Setting *at = setting(contact ? "extra_force_at" : ".at"), *variable = setting(contact ? "extra_force_variable" : ".variable");
  if (at == nullptr || variable == nullptr) return std::nullopt;
  const auto* places = std::get_if<std::vector<double>>(&at->data);
  const auto* word = std::get_if<std::string>(&variable->data);
  if (places == nullptr || word == nullptr) return std::nullopt;
  const std::map<std::string, std::string> units = {{"speed", "m/s"}, {"spin", "rad/s"}, {"time", "s"}, {"overlap", "m"}, {"normal_velocity", "m/s"}};
  const auto found = units.find(*word);
  Curve curve{"learnt force, 95 %", {}, {}, {}, {}, false, true, 0};
  for (std::size_t k = 0; k < d.best.moved.size(); ++k) {
    const Parameter& p = d.best.moved[k];
    const std::string key = join_path(p.path);
    if (p.component < 0 || !(key.ends_with(".values") || key.ends_with("extra_force")) || static_cast<std::size_t>(p.component) >= places->size()) continue;
    curve.x.push_back((*places)[static_cast<std::size_t>(p.component)]);
    curve.y.push_back(d.best.shared[k]);
    curve.lower.push_back(d.best.shared[k] - 1.96 * d.best.deviation(k)), curve.upper.push_back(d.best.shared[k] + 1.96 * d.best.deviation(k));
  }
  if (curve.x.size() < 2) return std::nullopt;
  std::string name = *word;
  std::replace(name.begin(), name.end(), '_', ' ');
  const bool torque = d.learns_torque();
  const Prefix x = prefix_for(largest_of(curve.x), found != units.end() ? found->second : name.size() == 2 ? "m/s" : "m"), y = prefix_for(largest_of(curve.y), torque ? "N m" : "N");
  for (double& value : curve.x) value *= x.factor;
  for (std::vector<double>* values : {&curve.y, &curve.lower, &curve.upper})
    for (double& value : *values) value *= y.factor;
  Curve knots{"", curve.x, curve.y, {}, {}, true, false, 0}, zero{"", {curve.x.front(), curve.x.back()}, {0, 0}, {}, {}, false, true, 4};
  return Chart{"learnt_force.png", "learnt force", {{with_unit(name, spoken_unit(x.unit)), with_unit(torque ? "torque" : "force", y.unit), false, false, {zero, curve, knots}}}};
}

std::string unit_of_channel(const std::string& name) {
  for (std::size_t c = 0; c < channel_count; ++c)
    if (const auto channel = static_cast<Channel>(c); name == name_of(channel) || name == quantity_of(channel)) return unit_of(channel);
  return "";
}

std::string spoken_unit(const std::string& unit) {
  if (unit == "1") return "";
  std::string spoken;
  for (std::size_t k = 0; k < unit.size(); ++k) {
    const bool power = k > 0 && std::isalpha(static_cast<unsigned char>(unit[k - 1])) && (k + 1 == unit.size() || !std::isdigit(static_cast<unsigned char>(unit[k + 1])));
    if (power && unit[k] == '2') spoken += "²";
    else if (power && unit[k] == '3') spoken += "³";
    else spoken += unit[k];
  }
  return spoken;
}

}  // namespace quern
