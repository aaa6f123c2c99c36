// Whether a run still means anything.
#pragma once
#include <optional>
#include <string>
#include "src/engine/simulation.hpp"

namespace quern {

class Health {
 public:
  // Call once the simulation has been started.
  explicit Health(const Simulation& simulation);

  // One plain sentence where the run has failed: a number that is not finite, a particle that left the walls, or energy out of
  // nothing. Needs a ledger that is up to date (Simulation::measure_energy).
  std::optional<std::string> complaint(const Simulation& simulation) const;

 private:
  double kinetic_ = 0, potential_ = 0, elastic_ = 0;  // at the start [J]
  double rounding_ = 0;                               // energy that rounded places may put into bonds [J]
  bool closed_ = false;                               // whether walls hold the particles in
  double reach_ = 0;                                  // how far from the walls' middle a particle may be [m]
};

}  // namespace quern
