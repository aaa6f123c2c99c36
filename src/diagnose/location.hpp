// Where a mismatch lies: the channel, the interval and the phase that hold most of what the better model changes.
#pragma once
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// The shortest interval of the variable that holds nine tenths of the change, in standard deviations squared, of the channel that holds most.
Location locate(const Comparison& comparison, const Fit& baseline, const Fit& better);

}  // namespace quern
