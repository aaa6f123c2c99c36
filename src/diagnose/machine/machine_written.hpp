// A diagnosis of a machine as files: diagnosis.json, amended.toml, residuals.csv, fits.csv, report.html and diagnosis.png.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/machine/machine_diagnosis.hpp"

namespace quern {

// Into a directory that exists. Throws RunError where a file cannot be written.
void write_machine_diagnosis(const MachineExperiment& experiment, const MachineDiagnosis& diagnosis, const std::string& directory);

// The page that a person reads and its picture; returns a plain sentence for each picture that could not be drawn.
std::vector<std::string> write_machine_report(const MachineExperiment& experiment, const MachineDiagnosis& diagnosis, const std::string& directory);

}  // namespace quern
