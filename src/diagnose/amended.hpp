// The case with what was found in it: what `quern run` takes.
#pragma once
#include <string>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// The complete case of one run of the recording, with the calibrated numbers and the missing physics as a force of the simulation.
std::string amended_case(const Experiment& experiment, const Diagnosis& diagnosis);

}  // namespace quern
