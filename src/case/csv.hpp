// Tables of numbers in CSV files that a case names.
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

}  // namespace quern
