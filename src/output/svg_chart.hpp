// Charts as SVG within a page: small, sharp at any size, and readable without a script.
#pragma once
#include <string>
#include <string_view>
#include <vector>
#include "src/output/chart.hpp"

namespace quern {

// Text that stands in HTML or SVG as it is.
std::string escaped_html(std::string_view text);

// The chart as one <svg> element, as wide as where it stands. The first panel is taller than those below it.
std::string svg_of(const Chart& chart);

// One row of a chart that shows two numbers for each of several things.
struct BeforeAfter {
  std::string name;
  double before = 0, after = 0;
  bool set_apart = false;  // in the other colour
};

// Rows below each other: a ring before, a dot after, a line between. `level`: a number that is pointed out.
std::string svg_of(const std::vector<BeforeAfter>& rows, const std::string& x_label, double level);

}  // namespace quern
