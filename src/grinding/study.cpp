#include "src/grinding/study.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>

namespace quern {
namespace {

std::string listed(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t k = 0; k < words.size(); ++k) out += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return out;
}

// By what part errors of x flatten a weighted line (regression dilution; Fuller 1987, Measurement Error Models, § 1.1).
double dilution(const PowerLawFit& law) {
  constexpr double least = 1e-16;
  double weights = 0, mean = 0, scatter = 0, error = 0;
  std::vector<double> weight;
  for (const OperatingPoint& p : law.points) {
    const double variance = std::min(p.log_rate_variance[0], p.log_rate_variance[1]) + law.exponent * law.exponent * p.log_x_variance + law.lack * law.lack;
    weight.push_back(1 / std::max(variance, least));
    weights += weight.back();
  }
  for (std::size_t k = 0; k < weight.size(); ++k) mean += weight[k] / weights * std::log(law.points[k].x);
  for (std::size_t k = 0; k < weight.size(); ++k) {
    scatter += weight[k] / weights * std::pow(std::log(law.points[k].x) - mean, 2);
    error += weight[k] / weights * (1 - weight[k] / weights) * law.points[k].log_x_variance;
  }
  return scatter > 0 ? error / scatter : 0;
}

RateResult rate_of(const GrindingPoint& point, std::size_t at, std::size_t m) {
  const SizeSeries& series = point.series[m];
  RateResult r;
  r.point = at;
  r.limit_known = point.limits[m].has_value();
  r.fit = fit_kinetics(series, point.limits[m]);
  const auto& interval = r.fit.rate_ci95;
  r.open = !r.fit.determined || (interval && !((*interval)[0] > 0) && !std::isfinite((*interval)[1]));
  r.shape = fit_shape(series, point.limits[m]);
  r.held_out = held_out_error(series, point.limits[m]);
  r.held_out_shape = held_out_error(series, point.limits[m], true);
  return r;
}

}  // namespace

GrindingResult study_grinding(const GrindingStudy& study) {
  GrindingResult result;
  result.remarks = study.remarks;
  for (std::size_t m = 0; m < study.measures.size(); ++m) {
    MeasureResult measure{study.measures[m], {}, {}};
    std::vector<std::string> mute;
    for (std::size_t k = 0; k < study.points.size(); ++k) {
      if (study.points[k].series[m].times.empty()) continue;
      measure.rates.push_back(rate_of(study.points[k], k, m));
      if (measure.rates.back().open) mute.push_back(study.points[k].label);
    }
    if (!mute.empty())
      result.remarks.push_back("The " + study.measures[m] + " of " + listed(mute) + (mute.size() == 1 ? " leaves" : " leave") + " K_p open" + (study.x_name.empty() ? "." : ": out of the law."));

    double squares = 0;
    int freedom = 0;
    std::vector<OperatingPoint> points;
    std::set<double> settings;
    for (const RateResult& r : measure.rates) {
      const GrindingPoint& point = study.points[r.point];
      if (r.open || !point.x) continue;
      squares += r.fit.squares, freedom += r.fit.freedom();
      points.push_back({*point.x, r.fit.rate, r.fit.log_rate_variance, point.log_x_variance});
      settings.insert(*point.x);
    }
    for (OperatingPoint& p : points)
      for (double& variance : p.log_rate_variance) variance = freedom > 0 ? variance * squares / freedom : 0;
    if (settings.size() > 1) measure.law = fit_power_law(points);
    else if (!study.x_name.empty())
      result.remarks.push_back("No power law for " + study.measures[m] + ": it needs K_p at two or more values of " + study.x_name + ", and there is " + (settings.empty() ? "none." : "one."));
    constexpr double worth_a_word = 0.02;
    if (const double part = measure.law ? dilution(*measure.law) : 0; part > worth_a_word)
      result.remarks.push_back(fmt::format("The errors of {} flatten the law of {}: its exponent is nearer to 0 than it should be, by some {:.0f} %. Operating points farther apart or longer runs help.",
                                           study.x_name, study.measures[m], 100 * std::min(part, 1.0)));
    result.measures.push_back(std::move(measure));
  }
  return result;
}

}  // namespace quern
