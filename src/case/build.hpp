// From a case to a simulation that is ready to start.
#pragma once
#include "src/case/case.hpp"
#include "src/engine/simulation.hpp"
#include "src/engine/time_step.hpp"

namespace quern {

struct Built {
  Simulation simulation;      // everything in place; call start() next
  ObserverSettings observe;   // with the indices of walls filled in
  TimeStepLimit limit;        // of the time step, and what sets it
  double expected_speed = 0;  // the greatest speed of approach that the limit reckons with [m/s]
  double filling = 0;         // bulk volume of all particles over the volume of the mill; 0 without a mill
  std::vector<std::pair<std::string, BodyReport>> bodies;  // by agglomerate: what one is like
  std::vector<std::string> warnings;  // of the case and of building
};

// Makes materials, laws, walls, frames and particles, and sets the time step. Throws InputError (file, line, key) where the case
// cannot be built: a law or modulus is missing for bodies that can meet, a mesh is open, particles overlap at the start, a
// charge does not fit, or the time step asked for is above its limit.
Built build_case(const Case& c);
Simulation build(const Case& c);

// The law of two materials, `mass` [kg] and `diameter` [m] being the greatest ball of the pair.
PairLaw law_of(const PairCase& pair, const Material& a, const Material& b, double mass, double diameter, const std::string& file);

}  // namespace quern
