// From the states of a body, step by step, to what instruments show of it at the instants of a recording.
#pragma once
#include <vector>
#include "src/diagnose/recording.hpp"
#include "src/engine/simulation.hpp"
#include "src/observe/instrument.hpp"

namespace quern {

// The first body of a simulation, and how it stands to a wall.
struct BodyState {
  double time = 0;  // of the simulation [s]
  Vec3 position, velocity, acceleration, spin, spin_rate;
  double gap = 1e300, gap_rate = 0, gap_acceleration = 0;  // from its surface to the wall [m], [m/s], [m/s²]
  double force = 0;                                         // of the body on the wall, along the wall's normal [N]
};

BodyState body_state(const Simulation& simulation, const Wall* wall);

// When the gap closed between two states, the first with a gap.
double touch_time(const BodyState& before, const BodyState& after);

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
  struct Shown {
    const Series* series;
    Instrument instrument;
    std::size_t next = 0;
    double lagged = 0;
  };
  void read(Shown& one, std::vector<double>& values, const BodyState& before, const BodyState& now);

  std::vector<Shown> shown_;
  std::vector<std::vector<double>> values_;
  double offset_;  // from times of the simulation to times of the recording [s]
};

}  // namespace quern
