// Tables as CSV, headline numbers as JSON.
#pragma once
#include <string>
#include <vector>
#include "src/observe/table.hpp"

namespace quern {

// `name [unit]`; the name alone where dimensionless or a word.
std::string header_of(const Column& column);

// A tidy CSV: one header row, one row per entry, numbers in the shortest form that reads back to the same bits, an empty cell
// where a number is not finite. Quoted where a word holds a comma, quote or line break.
std::string csv_of(const Table& table);

// {"key": {"value": …, "unit": "…", "ci95": [lo, hi], "description": "…"}, …}, in the order given; null for what is not finite.
std::string json_of(const std::vector<Headline>& headlines);

}  // namespace quern
