// Everything that watches one run. Use: make from settings; see() after every step; finish() before the results are read.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct Observers {
  ObserverSettings settings;

  Observers() = default;
  explicit Observers(const ObserverSettings& chosen) : settings(chosen) {}

  // Whether Simulation::start must record collisions.
  bool needs_collisions() const { return settings.spectrum || settings.charge; }
  // Call once after Simulation::start and after each step.
  void see(const Simulation& simulation);
  // Takes in what is still going on (contacts that last). May be called any number of times and the run may go on after it.
  void finish(const Simulation& simulation);

  std::vector<Headline> headlines() const;
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a);
};

}  // namespace quern
