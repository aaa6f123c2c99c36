// Whether what observers have from a checkpoint fits the case: every list has the length that the others and the settings ask for, and no index
// leads nowhere. What the numbers say is not asked.
#pragma once
#include "src/observe/observers.hpp"

namespace quern {

// `simulation`: the sound state that was read with them.
bool sound(const Observers& read, const Simulation& simulation);

}  // namespace quern
