// A diagnosis of contacts or of a body as files: diagnosis.json, amended.toml, fits.csv, residuals.csv.
#pragma once
#include <string>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// Into a directory that exists. Throws RunError where a file cannot be written.
void write_diagnosis(const Experiment& experiment, const Diagnosis& diagnosis, const std::string& directory);

}  // namespace quern
