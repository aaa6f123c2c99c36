// The page that a person reads: report.html, whole in itself, and diagnosis.png.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

// Into a directory that exists; returns a plain sentence for each picture that could not be drawn. Throws RunError where the page cannot be written.
std::vector<std::string> write_report(const Experiment& experiment, const Diagnosis& diagnosis, ThreadTeam& team, const std::string& directory);

}  // namespace quern
