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

  double shift() const { return instrument_.shift; }
  bool same_kind(const ShownReading& other) const { return reading_ == other.reading_ && axis_ == other.axis_ && instrument_ == other.instrument_; }
  // The lag rests on what is read at `start`, the first instant that is looked at, if that lies before the first state; else on that state.
  void begin(const BodyState& first, double start);
  // Of an instant before the first state, or at it.
  double before(const BodyState& first, double time) const;
  // Of the instants after `before` and up to `now`, of the simulation, one value each; call for every two states in turn, also without instants.
  void read(const BodyState& before, const BodyState& now, std::span<const double> times, double* values);

  template <class Archive>
  void archive(Archive& a) {
    a(reading_, axis_, instrument_, start_, lagged_);
  }

 private:
  double lagged_before(const BodyState& first, double time) const;

  BodyReading reading_ = BodyReading::position;
  int axis_ = 0;
  Instrument instrument_;
  double start_ = 0, lagged_ = 0;
};

}  // namespace quern
