// Measured sizes in, a grinding study out; all checking of what was handed over.
#pragma once
#include <string>
#include <vector>
#include "src/grinding/study.hpp"

namespace quern {

struct GrindingRequest {
  std::string file;                 // CSV: docs/grinding.md; or the folder of a sweep whose runs sieved their fragments
  std::string sweep;                // folder of a sweep, whose sweep.csv has E_i; may be empty: `file`, where that is one
  std::string against;              // column, of the sweep where there is one, that the rate is held against; empty: E_i, or the only further one
  std::vector<std::string> limits;  // known limits: "D80=20 um", "0" for all
  std::string until;                // the last time that counts, "60 s"; empty: all
};

// Throws InputError: file, line, column, what was found, what is allowed.
GrindingStudy read_grinding(const GrindingRequest& request);

}  // namespace quern
