// What an instrument makes of a signal: gain, offset, a curved scale, a lag, a shifted clock, saturation. None of it acts on the motion.
//
//   y(t) = least(saturation, lagged(offset + gain u + curvature u²)(t − shift))
// where a lag τ means τ dy/dt + y = u (first order, at rest on the first value that is looked at).
#pragma once
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace quern {

struct Instrument {
  double offset = 0;     // in the channel's unit
  double gain = 1;       // [-]
  double curvature = 0;  // one over the channel's unit
  double lag = 0;        // [s]
  double shift = 0;      // by which its clock is late [s]
  double saturation = std::numeric_limits<double>::infinity();  // greatest value shown, in the channel's unit; negative ones are cut at its negative

  double scaled(double u) const { return offset + gain * u + curvature * u * u; }
  double cut(double y) const { return std::clamp(y, -saturation, saturation); }
  bool operator==(const Instrument&) const = default;
};

// What a case says of its instruments: by channel ("z", "force") or by quantity ("position", "velocity", "spin"), the channel's own first.
struct InstrumentCase {
  std::string target;
  Instrument instrument;
};

struct InstrumentSettings {
  std::vector<InstrumentCase> channels;
  double clock_shift = 0;  // by which the clock of all of them is late [s]

  Instrument of(const std::string& channel, const std::string& quantity) const {
    const InstrumentCase* found = nullptr;
    for (const InstrumentCase& one : channels)
      if (one.target == channel || (found == nullptr && one.target == quantity)) found = &one;
    Instrument own = found != nullptr ? found->instrument : Instrument{};
    own.shift += clock_shift;
    return own;
  }
  // Of the clock that is earliest, or none [s].
  double earliest_shift() const {
    double least = std::min(0.0, clock_shift);
    for (const InstrumentCase& one : channels) least = std::min(least, clock_shift + one.instrument.shift);
    return least;
  }
};

}  // namespace quern
