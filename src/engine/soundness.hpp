// Whether a state that was read from a file can be stepped: that every index in it leads to something that is there.
#pragma once
#include "src/engine/simulation.hpp"

namespace quern {

// What does not change while a simulation runs.
struct Extent {
  std::size_t particles = 0, bonds = 0;
  bool orientations = false, shapes = false;
  bool records = false, rolls = false, remembers = false, others = false;  // of the contacts
  double time_step = 0;  // [s]

  explicit Extent(const Simulation& started);
};

// `read` is what a state was read into, before its blocks were linked; `extent` that of the simulation as it was built and started.
bool sound(const Simulation& read, const Extent& extent);

}  // namespace quern
