// What a trembling clock does to a recording: each sample shows the signal a little before or after its time.
#include <algorithm>
#include <cmath>
#include "src/diagnose/comparison.hpp"

namespace quern {

template <class Seen>
void Comparison::find_leaps(std::size_t run, const Fit& fit, const Experiment::Prediction& at, Seen&& seen, Eigen::VectorXd& added) {
  constexpr double flat = 0.2;  // beside the other side
  const double step = experiment_->steps[run].time_step;
  const Experiment::Prediction before = seen(step), after = seen(-step);
  Eigen::Index row = 0;
  for (std::size_t s = 0; s < at.size(); ++s) {
    Series& series = recording_.runs[run].series[s];
    series.leap.assign(at[s].size(), 0.0);
    for (std::size_t k = 0; k < at[s].size(); ++k, ++row) {
      const double one = std::abs(at[s][k] - before[s][k]), other = std::abs(after[s][k] - at[s][k]), leap = 0.5 * std::max(one, other);
      const double deviation = fit.noise[static_cast<std::size_t>(series.channel)].deviation * (series.deviation.empty() ? 1 : series.deviation[k]);
      if (series.channel != Channel::force || !(std::min(one, other) < flat * std::max(one, other)) || !(leap > deviation)) continue;
      series.leap[k] = leap;
      added[row] = 0.5 * (before[s][k] + after[s][k]) - at[s][k];
    }
  }
}

void Comparison::learn_trembling(const Fit& fit) {
  if (recording_.kind == RecordingKind::impacts) return;
  // Standard deviation of the clock [s]: less than the time between samples, or they would be out of order. What was thought of it before rates were known is nothing.
  double trembling = 0;
  constexpr double in_order = 0.3;
  if (!trembling_.empty())
    for (const std::size_t c : channels_of(recording_)) trembling = std::max(trembling, std::min(fit.noise[c].jitter * fit.noise[c].deviation, in_order * fit.noise[c].spacing));
  const Alteration altered = alteration_of(fit);
  trembling_.resize(experiment_->runs());
  team_->run(static_cast<int>(fit.runs.size()), [&](int place) {
    const std::size_t run = fit.runs[static_cast<std::size_t>(place)];
    RecordedRun& recorded = recording_.runs[run];
    constexpr double little = 1e-3;  // of the time between samples
    std::size_t most = 2;
    for (const Series& series : recorded.series) most = std::max(most, series.value.size());
    const double step = std::max(trembling, little * (recorded.last_time() - recorded.first_time()) / static_cast<double>(most - 1));
    if (!(step > 0)) return;
    const auto seen = [&](double late) { return experiment_->predict(run, altered, fit.unknowns[run], 1, late); };
    const Experiment::Prediction at = seen(0), before = seen(step), after = seen(-step);
    Eigen::VectorXd added = Eigen::VectorXd::Zero(fit.linear[static_cast<std::size_t>(place)].rest.size());
    std::vector<std::vector<double>> rates;
    Eigen::Index row = 0;
    for (std::size_t s = 0; s < at.size(); ++s) {
      rates.emplace_back();
      for (std::size_t k = 0; k < at[s].size(); ++k, ++row) {
        rates.back().push_back(std::hypot(at[s][k] - before[s][k], after[s][k] - at[s][k]) / (std::sqrt(2.0) * step));
        // Half of all samples come a standard deviation early, half as late.
        if (trembling > 0) added[row] = 0.5 * (before[s][k] + after[s][k]) - at[s][k];
        if (!std::isfinite(rates.back().back())) return;
      }
    }
    for (std::size_t s = 0; s < at.size(); ++s) recorded.series[s].rate = rates[s];
    if (!(trembling > 0) && recorded.find(Channel::force) != nullptr) find_leaps(run, fit, at, seen, added);
    trembling_[run] = added;
  });
}

}  // namespace quern
