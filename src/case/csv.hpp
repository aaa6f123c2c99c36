// Tables in CSV files that a user hands over.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct NumberTable {
  std::vector<std::string> names;            // of the columns, without their units
  std::vector<std::vector<double>> columns;  // in SI units

  const std::vector<double>* find(const std::string& name) const;
};

// Reads a header of `name [unit]` cells and rows of finite numbers; # starts a comment line. Units are converted to SI.
// Throws InputError with file and line.
NumberTable read_numbers(const std::string& file);

// A table as it was written, words and numbers.
struct TextTable {
  std::string file;
  int header_line = 0;
  std::vector<std::string> names, units;        // of the columns; unit "" where none is given
  std::vector<std::vector<std::string>> rows;   // each as wide as the header
  std::vector<int> lines;                       // of each row in the file

  int find(const std::string& name) const;      // of the column; −1: there is none

  // Throws InputError: file, line, column, and what is wrong there.
  [[noreturn]] void refuse(std::size_t row, int column, const std::string& what) const;
};

// Reads a header of `name [unit]` cells and at least one row; # starts a comment line; a cell in double quotes may hold commas.
// Throws InputError with file and line.
TextTable read_cells(const std::string& file);

// The finite number in a cell, as written; throws InputError.
double number_in(const TextTable& table, std::size_t row, int column);

// The first of some SI units that a column's unit is a multiple of, and the factor to it. Throws InputError.
struct UnitFactor {
  std::string si;
  double factor;
};
UnitFactor unit_of(const TextTable& table, int column, const std::vector<std::string>& si_units);

}  // namespace quern
