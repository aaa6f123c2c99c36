// What a breakage study found: tables, headline numbers, a chart, words.
#pragma once
#include <string>
#include <vector>
#include "src/grinding/breakage.hpp"
#include "src/observe/table.hpp"
#include "src/output/chart.hpp"

namespace quern {

// breakage: each energy, with means, scatter, counts and the fits there; breakage_fits: each parameter with its interval.
std::vector<Table> breakage_tables(const BreakageStudy& study, const BreakageResult& result);

std::vector<Headline> breakage_headlines(const BreakageStudy& study, const BreakageResult& result);

// Damage, probability and t10 over the specific energy, as far as they are there; none without any.
std::vector<Chart> breakage_charts(const BreakageStudy& study, const BreakageResult& result, const std::string& title);

// Into a directory that exists: the tables and summary.json. Throws RunError where one cannot be written.
void write_breakage(const BreakageStudy& study, const BreakageResult& result, const std::string& directory);

// What the terminal says, line by line.
std::vector<std::string> breakage_words(const BreakageStudy& study, const BreakageResult& result);

}  // namespace quern
