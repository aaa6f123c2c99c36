// report.html of a run or of a sweep, whole in itself, made from what stands in the directory.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct ReportWritten {
  std::vector<std::string> files;    // relative to the directory
  std::vector<std::string> remarks;  // plain sentences: what could not be shown
};

// From the directory of a run, also of one that goes on or was killed. Throws InputError where there is no run, WriteError where the page
// cannot be written. `draw`: pictures of its tables that are missing are drawn too.
ReportWritten write_run_report(const std::string& directory, bool draw = false);

// From the directory of a sweep: its table, and each headline number against what was swept. Throws as above.
ReportWritten write_sweep_report(const std::string& directory);

}  // namespace quern
