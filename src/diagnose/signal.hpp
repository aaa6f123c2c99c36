// From the states of a body, step by step, to what instruments show of it at the instants of a recording.
#pragma once
#include <vector>
#include "src/diagnose/recording.hpp"
#include "src/observe/shown_reading.hpp"

namespace quern {

class SignalReader {
 public:
  // `start` is the time of the recording at which the simulation began.
  SignalReader(const RecordedRun& run, const InstrumentSettings& settings, double start);
  // What was before the first step, by the first state: the body as it came, and no force.
  void begin(const BodyState& first);
  // Fills in all that was recorded between two states; false when nothing more is to come.
  bool see(const BodyState& before, const BodyState& now);
  const std::vector<std::vector<double>>& values() const { return values_; }

 private:
  struct Told {
    std::vector<double> times;  // of the simulation [s]
    ShownReading shown;
    std::size_t next = 0;
  };

  std::vector<Told> told_;
  std::vector<std::vector<double>> values_;
};

}  // namespace quern
