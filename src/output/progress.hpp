// How far a run is and how long it will still take, on stderr: a bar on a terminal, a line every tenth elsewhere.
#pragma once
#include <chrono>
#include <string>

namespace quern {

class Progress {
 public:
  // From `start` to `end` [s] of simulated time.
  Progress(double start, double end, bool quiet);
  // Cheap enough for every step.
  void show(double time);
  // Ends the bar's line.
  void end();
  double wall_clock() const;  // since the start [s]

 private:
  using Instant = std::chrono::steady_clock::time_point;
  double start_, end_;
  bool quiet_, terminal_;
  Instant begin_, shown_;
  int tenths_ = 0, calls_ = 0;
  bool open_ = false;
};

// "42 s", "3 min 20 s", "2 h 05 min".
std::string spoken_duration(double seconds);

}  // namespace quern
