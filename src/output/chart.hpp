// What a chart shows, without how it is drawn.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>
#include "src/observe/table.hpp"

namespace quern {

struct Curve {
  std::string name;                  // in the legend; empty: not there
  std::vector<double> x, y;
  std::vector<double> lower, upper;  // of the 95 % interval about y; may be empty
  bool marks = false;                // a mark and a bar at each point; otherwise a line and a band
  bool joined = true;                // marks are joined by a thin line
  int like = -1;                     // coloured as the curve of this number; −1: by its own place
  bool small = false;                // marks are dots
};

struct Panel {
  std::string x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Curve> curves;
  std::optional<std::array<double, 2>> marked = {};  // an interval of x that is pointed out; not on a log axis
};

struct Chart {
  std::string file;  // without directory
  std::string title;
  std::vector<Panel> panels;  // one above the other; if all have one label on x, it is written once
};

// The charts that the tables allow, of: spectrum, convergence, power, loading, energy, damage. Headline numbers give means with their intervals.
std::vector<Chart> charts_of(const std::vector<Table>& tables, const std::vector<Headline>& headlines, const std::string& title);

}  // namespace quern
