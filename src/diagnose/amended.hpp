// The case with what was found in it: what `quern run` takes.
#pragma once
#include <string>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// Writes the complete case of one run of the recording, with the calibrated numbers and the missing physics as a force of the simulation.
void write_amended_case(const std::string& file, const Experiment& experiment, const Diagnosis& diagnosis);

}  // namespace quern
