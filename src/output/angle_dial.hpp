// The angles of a charge on a circle, as SVG.
#pragma once
#include <string>
#include <vector>
#include "src/observe/table.hpp"

namespace quern {

// Shoulder, toe, departure and impact, each with its interval, drawn so that the mill turns anticlockwise (docs/angles.md). "" where none
// of them is known.
std::string angle_dial(const std::vector<Headline>& headlines);

}  // namespace quern
