// The experiment behind a recording, as a simulation: the case with the conditions of a run, stepped by the simulator itself, and what the
// instruments would have shown of it at the instants of the recording.
#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include <vector>
#include "src/case/case.hpp"
#include "src/case/values.hpp"
#include "src/diagnose/recording.hpp"

namespace quern {

// A number of the case that a fit may move.
struct Parameter {
  std::string name;       // of the key; "gravity.z" a component
  Path path;              // of the key in the case
  int component = -1;     // of a vector or list, or all_components: the vector's length in its direction
  double value = 0;       // in the case
  double lower = 0, upper = 0;
  double scale = 1;       // a change that matters: fits count in it
  std::vector<std::size_t> runs;  // in which it moves; empty: in all
  static constexpr int all_components = -2;
};

// What is estimated for each run by itself: parts of the initial state, and the zero of the clock of impact times.
struct Unknown {
  enum class Kind { position, velocity, spin, clock } kind;
  int axis = 0;
  double guess = 0, scale = 1;
};

struct StepControl {
  double time_step = 0;          // [s]
  double longest_flight_step = 0;  // [s]; at most time_step: every step is one time step, as in a run of the case
  double softness = 1;             // by which contacts are softer than in the case: a body that rolls hardly feels it, the step does
  double stiff_step = 0;           // for contacts as they are, where they are softer [s]

  // With the contacts of the case.
  StepControl stiff() const { return softness > 1 ? StepControl{stiff_step, std::max(stiff_step, longest_flight_step)} : *this; }
  StepControl finer(double factor) const { return {time_step / factor, longest_flight_step / factor, softness, stiff_step / factor}; }
};

// By run of the recording.
class Steps {
 public:
  Steps() = default;
  Steps(std::size_t runs, const StepControl& all) : by_run_(runs, all) {}
  StepControl& operator[](std::size_t run) { return by_run_[run]; }
  const StepControl& operator[](std::size_t run) const { return by_run_[run]; }
  double shortest() const {
    double least = by_run_.front().time_step;
    for (const StepControl& one : by_run_) least = std::min(least, one.time_step);
    return least;
  }
  bool soft() const {
    return std::any_of(by_run_.begin(), by_run_.end(), [](const StepControl& one) { return one.softness > 1; });
  }
  Steps stiff() const { return changed([](const StepControl& one) { return one.stiff(); }); }
  Steps finer(double factor) const { return changed([&](const StepControl& one) { return one.finer(factor); }); }

 private:
  template <class Change>
  Steps changed(Change&& change) const {
    Steps other = *this;
    for (StepControl& one : other.by_run_) one = change(one);
    return other;
  }
  std::vector<StepControl> by_run_;
};

// What a comparison does to the case: numbers that it moves, and other keys that it sets first.
struct Setting {
  std::string key;
  decltype(Value::data) data;
};
struct Change {
  const Parameter* parameter;
  double value;
};
struct Alteration {
  std::vector<Change> changes;
  std::vector<Setting> settings;
};
void alter(Values& values, const Alteration& altered);

// The parameter that a key of a case names, within its own range and a factor ten, unless diagnose.bounds tells otherwise. Throws InputError.
Parameter parameter_of(const Values& base, const std::string& key);

class Experiment {
 public:
  // Checks that the case is of one body whose motion the recording can show. Throws InputError.
  Experiment(Values base, const Recording& recording);

  const Values& base() const { return base_; }
  const Recording& recording() const { return *recording_; }
  std::size_t runs() const { return recording_->runs.size(); }
  const std::vector<Unknown>& unknowns(std::size_t run) const { return prepared_[run].unknowns; }
  std::string pair_table() const { return pair_table_; }        // "pair.ball.plate", of the body and the nearest wall; "": there is none
  std::string species() const { return species_; }
  std::string insert() const { return insert_; }
  bool has_wall() const { return !pair_table_.empty(); }
  double radius(std::size_t run) const { return prepared_[run].radius; }
  double start_time(std::size_t run) const { return prepared_[run].start; }  // of the recording, at which the simulation begins [s]

  Parameter parameter(const std::string& key) const;

  // What the recording of that run would have shown, series by series; NaN where the simulation fails.
  using Prediction = std::vector<std::vector<double>>;
  // `part` of the run's duration is simulated; the rest is told as it was recorded. `late`: all clocks are so much later still [s].
  Prediction predict(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns, double part = 1, double late = 0) const;

  // State of the body at each sample of the trajectory's union of times, for those who look for what a mismatch depends on.
  struct Point {
    double time = 0;                       // of the recording [s]
    double position[3]{}, velocity[3]{}, spin[3]{}, acceleration[3]{};
    double overlap = 0, overlap_rate = 0, force = 0;  // with the nearest wall; overlap negative: a gap
    std::int64_t impacts = 0;              // so far
  };
  std::vector<Point> path(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns) const;

  // The case as it stands for one run, with changes: what `quern run` would take.
  Values values_of(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns) const;

  Steps steps;  // how finely to step; set when made

 private:
  struct Prepared {
    Values values;
    Vec3 position, velocity, spin;
    std::vector<Unknown> unknowns;
    double start = 0;                      // time of the recording at which the simulation begins [s]
    double radius = 0;
  };
  struct Start {
    Vec3 position, velocity, spin;
    double clock = 0;
  };
  void prepare(std::size_t run);
  void choose_steps();
  double softness_at_rest(std::size_t run) const;
  Start start_of(std::size_t run, const std::vector<double>& unknowns) const;
  Case case_for(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns) const;
  template <class Watcher>
  bool go(std::size_t run, const Case& c, double until, Watcher&& watch) const;

  Values base_;
  const Recording* recording_;
  std::vector<Prepared> prepared_;
  std::string insert_, species_, pair_table_;
  std::size_t nearest_wall_ = 0;
  bool estimates_start_ = true;
};

}  // namespace quern
