// What every comparison writes alike: diagnosis.json, fits.csv, and the words on the terminal.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>
#include "src/diagnose/finding.hpp"

namespace quern {

// null where it is not finite.
nlohmann::ordered_json json_number(double x);

// The explanations as they are ranked, most probable first.
nlohmann::ordered_json json_of(const Finding& finding, const std::vector<Ranked>& ranking);

// fits.csv, into a directory that exists. Throws RunError where it cannot be written.
void write_fits(const Finding& finding, const std::string& directory);

// What the terminal says, line by line.
std::vector<std::string> diagnosis_words(const Finding& finding);

}  // namespace quern
