#include "src/case/csv.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"

namespace quern {
namespace {

std::string trimmed(std::string text) {
  const char* blank = " \t\r\n";
  const auto first = text.find_first_not_of(blank);
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    else if (c == ',' && !quoted) cells.emplace_back();
    else cells.back() += c;
  }
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

constexpr std::size_t largest_table = 256 << 20;  // [bytes]
constexpr std::size_t most_columns = 1000, longest_cell = 1000;

std::string content_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) throw InputError(file + ": this file cannot be read; a CSV table is needed.");
  // Piece by piece: a pipe tells no length.
  std::string text;
  std::vector<char> piece(1 << 16);
  while (stream.read(piece.data(), static_cast<std::streamsize>(piece.size())), stream.gcount() > 0) {
    text.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > largest_table) throw InputError(fmt::format("{}: this file is larger; a CSV table has at most {} MB.", file, largest_table >> 20));
  }
  return text;
}

const std::vector<std::string> si_units_of_cases = {"m", "m/s", "rad/s", "kg", "s", "1"};

}  // namespace

const std::vector<double>* NumberTable::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &columns[static_cast<std::size_t>(found - names.begin())];
}

int TextTable::find(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

void TextTable::refuse(std::size_t row, int column, const std::string& what) const {
  throw InputError(fmt::format("{}:{}: column {}: {}.", file, lines[row], names[static_cast<std::size_t>(column)], what));
}

TextTable read_cells(const std::string& file) {
  std::istringstream stream(content_of(file));
  TextTable table;
  table.file = file;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // the byte order mark of spreadsheets
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() > most_columns) throw InputError(fmt::format("{}:{}: found {} cells; allowed are {}.", file, number, cells.size(), most_columns));
    for (const std::string& cell : cells)
      if (cell.size() > longest_cell) throw InputError(fmt::format("{}:{}: found a cell of {} characters that begins with \"{:.20}\"; allowed are {}.", file, number, cell.size(), cell, longest_cell));
    if (table.names.empty()) {
      table.header_line = number;
      for (const std::string& cell : cells) {
        const auto open = cell.find('['), close = cell.find(']');
        const bool has_unit = open != cell.npos && close != cell.npos && close > open;
        table.units.push_back(has_unit ? trimmed(cell.substr(open + 1, close - open - 1)) : "");
        table.names.push_back(trimmed(cell.substr(0, open)));
      }
      continue;
    }
    if (cells.size() != table.names.size())
      throw InputError(fmt::format("{}:{}: found {} cells; the header has {}.", file, number, cells.size(), table.names.size()));
    table.rows.push_back(cells);
    table.lines.push_back(number);
  }
  if (table.rows.empty()) throw InputError(file + ": this table is empty; a header of `name [unit]` cells and rows of numbers are needed.");
  return table;
}

double number_in(const TextTable& table, std::size_t row, int column) {
  const std::string& cell = table.rows[row][static_cast<std::size_t>(column)];
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, status] = std::from_chars(cell.data(), end, value);
  if (status != std::errc() || stop != end || !std::isfinite(value))
    throw InputError(fmt::format("{}:{}: found \"{}\" in column {}; allowed are finite numbers.", table.file, table.lines[row], cell.substr(0, 40),
                                 table.names[static_cast<std::size_t>(column)]));
  return value;
}

UnitFactor unit_of(const TextTable& table, int column, const std::vector<std::string>& si_units) {
  const std::string& unit = table.units[static_cast<std::size_t>(column)];
  const Units units;
  for (const std::string& si : si_units) {
    try {
      return {si, units.read("1 " + (unit.empty() ? std::string("1") : unit), si)};
    } catch (const InputError&) {
    }
  }
  const std::string most = fmt::format("{}", fmt::join(si_units.begin(), si_units.end() - 1, ", "));
  throw InputError(fmt::format("{}:{}: the unit [{}] is not {}, nor a multiple of {}.", table.file, table.header_line, unit,
                               si_units.size() == 1 ? si_units[0] : fmt::format("one of {} or {}", most, si_units.back()), si_units.size() == 1 ? "it" : "one"));
}

NumberTable read_numbers(const std::string& file) {
  const TextTable text = read_cells(file);
  NumberTable table{text.names, std::vector<std::vector<double>>(text.names.size())};
  std::vector<double> factors;
  for (int k = 0; k < static_cast<int>(text.names.size()); ++k) factors.push_back(unit_of(text, k, si_units_of_cases).factor);
  for (std::size_t row = 0; row < text.rows.size(); ++row)
    for (std::size_t k = 0; k < factors.size(); ++k) table.columns[k].push_back(number_in(text, row, static_cast<int>(k)) * factors[k]);
  return table;
}

}  // namespace quern
