// The [mill] of a case.
#pragma once
#include "src/case/case.hpp"
#include "src/case/values.hpp"

namespace quern {

// Reads the mill of any kind into the case; does nothing without one. Throws InputError.
void read_mill(const Values& v, const std::vector<std::string>& materials, Case& c);

// The names of the motion frames that the mill brings.
std::vector<std::string> mill_frames(const Case& c);

// What hangs on the greatest diameter [m] of the charge: the critical speed, and a speed that is given as a fraction of it.
void finish_mill(const Values& v, double largest_diameter, Case& c);

}  // namespace quern
