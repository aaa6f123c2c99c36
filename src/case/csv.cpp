#include "src/case/csv.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"

namespace quern {
namespace {

std::string trimmed(std::string text) {
  const char* blank = " \t\r\n\"";
  const auto first = text.find_first_not_of(blank);
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') cells.emplace_back();
    else cells.back() += c;
  }
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

// The factor from a unit to the SI unit of the columns that cases use.
double factor_of(const std::string& unit, const Units& units) {
  for (const char* si : {"m", "m/s", "rad/s", "kg", "s", "1"}) {
    try {
      return units.read("1 " + (unit.empty() ? std::string("1") : unit), si);
    } catch (const InputError&) {
    }
  }
  throw InputError("the unit [" + unit + "] is not one of m, m/s, rad/s, kg, s or 1, nor a multiple of one");
}

}  // namespace

const std::vector<double>* NumberTable::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

NumberTable read_numbers(const std::string& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) throw InputError(file + ": this file cannot be read; a CSV table is needed.");
  const Units units;
  NumberTable table;
  std::vector<double> factors;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    const std::vector<std::string> cells = cells_of(line);
    const auto refuse = [&](const std::string& what) { throw InputError(fmt::format("{}:{}: {}.", file, number, what)); };
    if (table.names.empty()) {
      for (const std::string& cell : cells) {
        const auto open = cell.find('['), close = cell.find(']');
        const std::string unit = open != cell.npos && close != cell.npos && close > open ? cell.substr(open + 1, close - open - 1) : "";
        table.names.push_back(trimmed(cell.substr(0, open)));
        try {
          factors.push_back(factor_of(unit, units));
        } catch (const InputError& e) {
          refuse(e.what());
        }
      }
      table.columns.resize(cells.size());
      continue;
    }
    if (cells.size() != table.names.size()) refuse(fmt::format("found {} cells; the header has {}", cells.size(), table.names.size()));
    for (std::size_t k = 0; k < cells.size(); ++k) {
      double value = 0;
      const char* end = cells[k].data() + cells[k].size();
      const auto [stop, status] = std::from_chars(cells[k].data(), end, value);
      if (status != std::errc() || stop != end || !std::isfinite(value)) refuse(fmt::format("found \"{}\" in column {}; allowed are finite numbers", cells[k].substr(0, 40), table.names[k]));
      table.columns[k].push_back(value * factors[k]);
    }
  }
  if (table.names.empty() || table.columns[0].empty()) throw InputError(file + ": this table is empty; a header of `name [unit]` cells and rows of numbers are needed.");
  return table;
}

}  // namespace quern
