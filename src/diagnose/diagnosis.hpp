// The comparison of contacts and of single bodies as a whole: from a case and recordings to a verdict (docs/diagnose.md tells the steps).
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/catalogue.hpp"
#include "src/diagnose/finding.hpp"
#include "src/diagnose/scores.hpp"

namespace quern {

// One explanation that was tried.
struct Tried {
  Candidate candidate;             // of one effect; of two: the first
  std::vector<std::string> effects;
  Fit fit;                         // on the runs of training
  double gain = 0;                 // ln of its restricted likelihood over the calibrated baseline's
  double bic = 0;                  // −2 gain + number of its parameters × ln(independent samples)
  double probability = 0;          // among all that was tried
  double held_out = 0;             // misfit on the select part, fitted on the fit part; 0: not asked
  double held_out_gain = 0;        // ln likelihood ratio there over the baseline
  std::vector<double> held_out_runs;  // ln likelihood there, by run
};

struct Diagnosis : Finding {
  std::vector<Tried> ranking;                  // most probable first
  Steps steps;                                 // with which it was simulated
  // For pictures and the amended case.
  Fit baseline, best;                          // over the runs of training
  Fit sealed_baseline, sealed_best;
  // What was learnt, where something was: a torque, or a force (catalogue.cpp).
  bool learns_torque() const { return form.starts_with("a torque"); }
};

Diagnosis diagnose(const Experiment& experiment, ThreadTeam& team, const DiagnoseOptions& options);

}  // namespace quern
