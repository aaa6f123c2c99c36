#include "src/diagnose/amended.hpp"
#include <fmt/format.h>

namespace quern {

std::string amended_case(const Experiment& experiment, const Diagnosis& d) {
  const Fit& fit = d.best;
  // A run that the fit did not see, where there is one.
  const Fit& shown = !d.sealed_best.runs.empty() && d.sealed_best.sound ? d.sealed_best : fit;
  const std::size_t run = shown.runs.front();
  const RecordedRun& recorded = experiment.recording().runs[run];
  Alteration altered{{}, fit.settings};
  for (std::size_t k = 0; k < fit.moved.size(); ++k) altered.changes.push_back({&fit.moved[k], fit.shared[k]});
  Values values = experiment.values_of(run, altered, shown.unknowns[run]);
  values.put("time_step.value", d.steps[run].time_step, "fit");
  values.put("duration", std::max(recorded.last_time() - experiment.start_time(run), 2 * d.steps[run].time_step), "fit");
  if (!values.has("observe.track")) values.put("observe.track", std::vector<double>{0}, "fit");
  values.put("observe.signal", true, "fit");
  const std::string words = d.effects.empty() ? d.verdict == Verdict::unexplained ? "a learnt force" : "calibrated numbers" : fmt::format("{}", fmt::join(d.effects, " and "));
  return fmt::format("# {} with {}, as run {} of the recording was made; time 0 here is {:.9g} s there.\n{}", experiment.base().file, words, recorded.label, experiment.start_time(run),
                     complete_case(values));
}

}  // namespace quern
