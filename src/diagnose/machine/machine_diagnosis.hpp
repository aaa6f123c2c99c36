// The comparison of machines and of breakage with recordings: the same steps and verdicts as of single bodies (docs/diagnose.md), where each run costs seconds
// and scatters.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/finding.hpp"
#include "src/diagnose/machine/machine_model.hpp"

namespace quern {

// One recorded number beside the simulation before and after, with the standard deviations of the recording and of the simulation.
struct MachineResidual {
  std::size_t channel = 0, site = 0;
  double recorded = 0, noise = 0;
  double before = 0, before_deviation = 0, after = 0, after_deviation = 0;
  bool sealed = false;
};

struct MachineDiagnosis : Finding {
  std::vector<Ranked> ranking;                 // most probable first
  MachineFit baseline, best;
  std::vector<MachineResidual> residuals;
  std::size_t runs = 0;                        // of the simulation that were made or found
};

MachineDiagnosis diagnose_machine(const MachineExperiment& experiment, const CaseRunner& runner, const DiagnoseOptions& options);

}  // namespace quern
