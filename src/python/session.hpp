// src/python — the library as a Python module: cases, simulations that step, their arrays and tables. No physics.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>
#include "src/case/build.hpp"
#include "src/observe/observers.hpp"
#include "src/output/health.hpp"

namespace quern {

// A simulation with all that watches it, as `quern run` has it, but nothing is written. The arrays of its particles stay where they are in
// memory for as long as it lives: rows change their order, but none is added once a simulation has started.
class Session {
 public:
  // Threads: 0 for as many as pay. Throws InputError where the case cannot be built.
  explicit Session(const Case& c, int threads);

  // Goes on by a number of steps, or to the step at which `quern run` with this duration ends. Calls `pause` several times a second; what
  // that throws ends the stepping after a whole step. Throws RunError where the run has failed.
  void step(std::int64_t steps, const std::function<void()>& pause);
  void run_until(double time, const std::function<void()>& pause);

  const Simulation& simulation() const { return built_.simulation; }
  // Of this instant.
  Ledger ledger() const;
  // What the observers saw so far.
  std::vector<Table> tables();
  std::vector<Headline> headlines();
  const std::vector<std::string>& warnings() const { return built_.warnings; }
  double duration() const { return duration_; }

 private:
  double duration_;  // [s]
  Built built_;
  Observers observers_;
  std::vector<Headline> known_before_;
  std::optional<Health> health_;
};

}  // namespace quern
