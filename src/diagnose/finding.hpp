// What a comparison says in the end, whatever was recorded: the verdict, where, why, and how much better it fits.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace quern {

enum class Verdict { omitted_physics, nothing_missing, parameters_only, unexplained, insufficient_data };
const char* name_of(Verdict verdict);

struct Estimate {
  std::string key, unit;
  double value = 0, deviation = 0;
  std::optional<double> nominal;   // what the case says
  bool of_effect = false;
  std::array<double, 2> interval() const { return {value - 1.96 * deviation, value + 1.96 * deviation}; }
};

// Where recording and simulation differ.
struct Location {
  std::string channel, variable, unit, phase, run;
  double from = 0, to = 0, p_value = 1;
  std::string sign;                // "above" or "below": the recording against the calibrated simulation
};

// The least strength of an effect that these recordings could have shown.
struct Detectable {
  std::string effect, key, unit;
  double strength = 0;
};

struct Before {
  double before = 0, after = 0;    // RMS of residual over noise
};

// An explanation among those that were tried.
struct Ranked {
  std::vector<std::string> effects;
  std::string form;
  double held_out = 0, held_out_gain = 0;      // misfit on the select part, fitted on the fit part, and ln of the likelihood ratio there over the baseline
  double bic = 0, probability = 0;
  bool rival = false;                          // no effect of the catalogue
};

struct Finding {
  Verdict verdict = Verdict::insufficient_data;
  std::vector<std::string> effects;            // one, or two that act together
  std::string form;
  std::vector<std::string> indistinguishable;
  double confidence = 0;
  Location where;
  std::string signature;
  std::vector<Estimate> parameters;
  Before train;
  std::optional<Before> sealed;
  double excess_removed = 0;                   // share of the excess error on sealed runs that is gone
  std::vector<Detectable> detectable;
  double adequacy_p = 1;                       // of the calibrated baseline
  double remaining_p = 1;                      // of the winner
  double numerical_error = 0;                  // by which a finer step would move all samples together, in standard deviations
  std::vector<std::string> fit_runs, select_runs, sealed_runs;
  std::vector<std::string> remarks;            // plain sentences, for the report
  std::string advice;                          // which experiment would settle what is open
  std::vector<std::array<std::string, 3>> ledger;  // every fit: what, ln likelihood, iterations
};

struct DiagnoseOptions {
  std::uint64_t seed = 1;
  int threads = 0;                             // 0: as many as the machine has
  bool quiet = false;
};

// How often verdicts of a probability turned out right, in the 200 development trials of single bodies (docs/diagnose.md): models are never all there are. Of two
// effects at once hardly more than every other was.
double as_experienced(double probability, bool two);

}  // namespace quern
