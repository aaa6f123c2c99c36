// What an instrument makes of a signal: gain, offset, a curved scale, a lag, a shifted clock, saturation. None of it acts on the motion.
//
//   y(t) = least(saturation, lagged(offset + gain u + curvature u²)(t − shift))
// where a lag τ means τ dy/dt + y = u (first order, at rest on the first value).
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
  double saturation = std::numeric_limits<double>::infinity();  // greatest value shown, in the channel's unit; negative ones are cut at its negative

  double scaled(double u) const { return offset + gain * u + curvature * u * u; }
  double cut(double y) const { return std::clamp(y, -saturation, saturation); }
};

// What a case says of its instruments: by channel ("z", "force") or by quantity ("position", "velocity", "spin"), the channel's own first.
struct InstrumentCase {
  std::string target;
  Instrument instrument;
};

struct InstrumentSettings {
  std::vector<InstrumentCase> channels;
  double clock_shift = 0;  // by which the clock of the recording is late [s]

  Instrument of(const std::string& channel, const std::string& quantity) const {
    const InstrumentCase* found = nullptr;
    for (const InstrumentCase& one : channels)
      if (one.target == channel || (found == nullptr && one.target == quantity)) found = &one;
    return found != nullptr ? found->instrument : Instrument{};
  }
};

}  // namespace quern
