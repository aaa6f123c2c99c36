// What a grinding study found: tables, headline numbers, charts, words.
#pragma once
#include <string>
#include <vector>
#include "src/grinding/study.hpp"
#include "src/observe/table.hpp"
#include "src/output/chart.hpp"

namespace quern {

// sizes (as measured, and by the fit), kinetics (a row for each series), power_law (a row for each measure).
std::vector<Table> grinding_tables(const GrindingStudy& study, const GrindingResult& result);

std::vector<Headline> grinding_headlines(const GrindingStudy& study, const GrindingResult& result);

// For each measure: sizes against time with the fits, the declines on one curve, and the rate against what was set.
std::vector<Chart> grinding_charts(const GrindingStudy& study, const GrindingResult& result, const std::string& title);

// Tables and summary.json. Throws WriteError.
void write_grinding(const GrindingStudy& study, const GrindingResult& result, const std::string& directory);

// For the terminal; one line each.
std::vector<std::string> grinding_words(const GrindingStudy& study, const GrindingResult& result);

}  // namespace quern
