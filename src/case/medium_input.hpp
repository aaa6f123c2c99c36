// The [medium] of a case and its [force.<name>]: forces on single bodies.
#pragma once
#include "src/case/case.hpp"
#include "src/case/values.hpp"

namespace quern {

// Both read after gravity and the mill, and throw InputError.
void read_medium(const Values& v, Case& c);
void read_forces(const Values& v, Case& c);

}  // namespace quern
