// The runs of a comparison with a machine: in processes of their own, kept in a folder, and known again there.
#pragma once
#include <string>
#include "src/diagnose/machine/machine_experiment.hpp"

namespace quern {

// Thrown where a signal has stopped the runs; those that finished are kept.
struct Stopped {
  int signal;
};

// Runs whose folders are below `directory`, `jobs` at a time (0: one per core); tells how long they will take, if they are any.
CaseRunner run_cases_in(const std::string& directory, int jobs, bool quiet);

}  // namespace quern
