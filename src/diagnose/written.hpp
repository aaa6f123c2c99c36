// A diagnosis as files: diagnosis.json, amended.toml, fits.csv, residuals.csv.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// Into a directory that exists. Throws RunError where a file cannot be written.
void write_diagnosis(const Experiment& experiment, const Diagnosis& diagnosis, const std::string& directory);

// What the terminal says, line by line.
std::vector<std::string> diagnosis_words(const Diagnosis& diagnosis);

}  // namespace quern
