// Impacts of bodies in, a breakage study out; all checking of what was handed over.
#pragma once
#include <string>
#include "src/grinding/breakage.hpp"

namespace quern {

struct BreakageRequest {
  std::string source;           // folder of a sweep, or a CSV: docs/breakage.md
  std::string against;          // column of speed or specific energy; empty: the one that is there
  double broken_below = 0.9;
  std::string size;             // of the bodies, "100 mm"; may be empty
};

// Throws InputError: file, line, column, what was found, what is allowed.
BreakageStudy read_breakage(const BreakageRequest& request);

}  // namespace quern
