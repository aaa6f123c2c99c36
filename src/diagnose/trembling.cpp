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
    // A sample at the very instant of a leap (a dashpot's force at first touch) may show either side.
    constexpr double exact = 1e-3;  // of the time between samples: no clock is told better
    std::size_t most = 2;
    for (const Series& series : recorded.series) most = std::max(most, series.value.size());
    const double step = std::max(trembling, exact * (recorded.last_time() - recorded.first_time()) / static_cast<double>(most - 1));
    if (!(step > 0)) return;
    const auto seen = [&](double late) { return experiment_->predict(run, altered, fit.unknowns[run], 1, late); };
    const Experiment::Prediction at = seen(0), before = seen(step), after = seen(-step);
    Eigen::VectorXd added(fit.linear[static_cast<std::size_t>(place)].rest.size());
    std::vector<std::vector<double>> rates, leaps;
    Eigen::Index row = 0;
    for (std::size_t s = 0; s < at.size(); ++s) {
      rates.emplace_back(), leaps.emplace_back();
      for (std::size_t k = 0; k < at[s].size(); ++k) {
        const double change = std::hypot(at[s][k] - before[s][k], after[s][k] - at[s][k]) / std::sqrt(2.0);
        rates.back().push_back(change / step);
        leaps.back().push_back(trembling > 0 ? 0 : 0.5 * std::abs(after[s][k] - before[s][k]));
        // Half of all samples come so much early, half as late.
        added[row++] = 0.5 * (before[s][k] + after[s][k]) - at[s][k];
        if (!std::isfinite(change)) return;
      }
    }
    for (std::size_t s = 0; s < at.size(); ++s) recorded.series[s].rate = rates[s], recorded.series[s].leap = leaps[s];
    trembling_[run] = added;
  });
}

}  // namespace quern
