// One reading of a body as an instrument shows it, at ascending instants.
#pragma once
#include <span>
#include "src/observe/body_state.hpp"
#include "src/observe/instrument.hpp"

namespace quern {

class ShownReading {
 public:
  ShownReading() = default;
  ShownReading(BodyReading reading, int axis, const Instrument& instrument) : reading_(reading), axis_(axis), instrument_(instrument) {}

  // The lag rests on the first value.
  void begin(const BodyState& first);
  // Of an instant before the first state, or at it.
  double before(const BodyState& first, double time) const;
  // Of the instants after `before` and up to `now`, of the simulation, one value each; call for every two states in turn, also without instants.
  void read(const BodyState& before, const BodyState& now, std::span<const double> times, double* values);

  template <class Archive>
  void archive(Archive& a) {
    a(reading_, axis_, instrument_, lagged_);
  }

 private:
  BodyReading reading_ = BodyReading::position;
  int axis_ = 0;
  Instrument instrument_;
  double lagged_ = 0;
};

}  // namespace quern
