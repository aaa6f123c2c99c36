// Runs of cases in processes of their own, some at a time; finished ones are known again by their complete case.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>
#include "src/case/grid.hpp"

namespace quern {

struct Point {
  std::string file;                    // of the case
  std::vector<std::string> overrides;  // "key=value"
  std::string directory;
  std::string text;                    // the complete case, by which a finished run is known again
  bool finished = false;
  int status = 0;                      // of a run that failed
  int process = 0;
  std::string label = {};              // what the terminal calls it; default: its overrides
};

// Named by the keys that differ between the runs of a grid, whose overrides come first.
std::string folder_name(const std::vector<SweptKey>& swept, const std::vector<std::string>& overrides);

// Marks the points whose results are there already; returns how many.
std::size_t keep_finished(std::vector<Point>& points);

// Runs the others, `jobs` at a time (0: one per core), tells of each on the terminal and calls `after` when one has finished.
// `threads` of each run: none given: the cores shared out; 0: as many as pay.
// Returns 0; 1 where a run failed; 128 + signal when stopped by one, which ends the runs too.
int run_points(std::vector<Point>& points, int jobs, const std::function<void()>& after, std::optional<int> threads = {});

std::string content_of(const std::string& file);
// Throws RunError where it cannot be written.
void write_aside(const std::string& file, const std::string& content);

}  // namespace quern
