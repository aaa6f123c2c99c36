// src/observe — collision events and spectra, power, charge angles, profiles: read the state, never change it.
//
// The two forms in which observers hand over what they saw; src/output writes any of them.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace quern {

struct Column {
  std::string name;         // as in the header of a CSV: `name [unit]`
  std::string unit;         // "1" where dimensionless
  std::string description;
  std::vector<double> values;
  std::vector<std::string> labels;  // instead of values, for a column of words

  template <class Archive>
  void archive(Archive& a) {
    a(name, unit, description, values, labels);
  }
};

struct Table {
  std::string name;         // of the file, without ending
  std::string description;
  std::vector<Column> columns;

  template <class Archive>
  void archive(Archive& a) {
    a(name, description, columns);
  }
};

// One number of summary.json.
struct Headline {
  std::string key;
  double value = 0;
  std::string unit;
  std::optional<std::array<double, 2>> ci95;
  std::string description;
};

}  // namespace quern
