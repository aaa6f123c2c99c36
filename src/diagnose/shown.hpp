// What a diagnosis shows: the recordings beside the simulation before and after, run by run, and the force that was learnt.
#pragma once
#include <optional>
#include <string>
#include <vector>
#include "src/diagnose/diagnosis.hpp"
#include "src/output/chart.hpp"

namespace quern {

// Both simulations that are set side by side, on the runs of training and on the sealed ones. Where numbers of the case were off, `before` is the case
// as it stands; otherwise it is the calibrated case.
struct SideBySide {
  std::string before_name, after_name;
  bool one = false;  // nothing was added: both are the same
  Fit train_before, train_after, sealed_before, sealed_after;
  Noise noise;
};
SideBySide side_by_side(const Experiment& experiment, const Diagnosis& diagnosis, ThreadTeam& team);

struct RunMisfit {
  std::string run;
  double before = 0, after = 0;  // RMS of residual over noise
  bool sealed = false;
};
std::vector<RunMisfit> misfit_by_run(const Experiment& experiment, const SideBySide& sides, ThreadTeam& team);

// One run, in panels below each other: what was recorded and both simulations; what the one before leaves over the noise, and what the one after adds; what
// that leaves.
struct RunChart {
  std::string why, run;  // why it is shown, in words; no run: all of them
  bool sealed = false;
  Chart chart;
  std::string cut;       // what does not fit into the frames, in words
};
// The run of training that tells most, the sealed one that does, and the one that fits worst afterwards.
std::vector<RunChart> telling_runs(const Experiment& experiment, const Diagnosis& diagnosis, const SideBySide& sides);

// The learnt force with its 95 % band, where there is one.
std::optional<Chart> learnt_force(const Diagnosis& diagnosis);

// "vx" → "m/s"; of a quantity too ("position" → "m").
std::string unit_of_channel(const std::string& name);
// "m/s2" → "m/s²"; "1" → "".
std::string spoken_unit(const std::string& unit);

}  // namespace quern
