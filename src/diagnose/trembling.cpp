// What a trembling clock does to a recording: each sample shows the signal a little before or after its time.
#include <algorithm>
#include <cmath>
#include "src/diagnose/comparison.hpp"

namespace quern {

void Comparison::learn_trembling(const Fit& fit) {
  if (recording_.kind == RecordingKind::impacts) return;
  double trembling = 0;  // standard deviation of the clock [s]
  for (const std::size_t c : channels_of(recording_)) trembling = std::max(trembling, fit.noise[c].jitter * fit.noise[c].deviation);
  const Alteration altered = alteration_of(fit);
  trembling_.resize(experiment_->runs());
  team_->run(static_cast<int>(fit.runs.size()), [&](int place) {
    const std::size_t run = fit.runs[static_cast<std::size_t>(place)];
    RecordedRun& recorded = recording_.runs[run];
    constexpr double little = 0.05;  // of the time between samples
    std::size_t most = 2;
    for (const Series& series : recorded.series) most = std::max(most, series.value.size());
    const double step = trembling > 0 ? trembling : little * (recorded.last_time() - recorded.first_time()) / static_cast<double>(most - 1);
    if (!(step > 0)) return;
    const Experiment::Prediction at = experiment_->predict(run, altered, fit.unknowns[run]), before = experiment_->predict(run, altered, fit.unknowns[run], 1, step),
                                 after = experiment_->predict(run, altered, fit.unknowns[run], 1, -step);
    Eigen::VectorXd added(fit.linear[static_cast<std::size_t>(place)].rest.size());
    std::vector<std::vector<double>> rates;
    Eigen::Index row = 0;
    for (std::size_t s = 0; s < at.size(); ++s) {
      rates.emplace_back();
      for (std::size_t k = 0; k < at[s].size(); ++k) {
        rates.back().push_back(std::hypot(at[s][k] - before[s][k], after[s][k] - at[s][k]) / (std::sqrt(2.0) * step));
        // Half of all samples come a standard deviation early, half as late.
        added[row++] = trembling > 0 ? 0.5 * (before[s][k] + after[s][k]) - at[s][k] : 0;
        if (!std::isfinite(rates.back().back())) return;
      }
    }
    for (std::size_t s = 0; s < at.size(); ++s) recorded.series[s].rate = rates[s];
    trembling_[run] = added;
  });
}

}  // namespace quern
