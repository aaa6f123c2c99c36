// All contacts of a simulation: blocks of particles with their candidate pairs, and when those must be searched again.
#pragma once
#include "src/base/threads.hpp"
#include "src/contact/kernels.hpp"

namespace quern {

struct Contacts {
  std::vector<ContactBlock> blocks;
  Index block_size = 1;
  bool records = false;
  double skin = 0;              // candidates are nearer than this beyond touching [m]
  double travelled = 0;         // an upper bound of any particle's path since the last search [m]
  double wall_travelled = 0;    // the same for walls
  std::int64_t searches = 0;
  std::int64_t steps_since_search = 0;
  std::vector<Collision> ended;   // in the last step
  StepSums sums;                  // of the last step
  std::vector<WallSums> wall_sums;

  bool stale() const { return blocks.empty() || 2 * travelled > skin || travelled + wall_travelled > skin; }
};

// Cuts the particles into blocks, sorts them in space every so often, and searches all candidate pairs within the skin.
// Touching contacts keep their memory. `reach` [m]: no wall moves faster than the skin allows between searches (see engine).
void search_neighbours(Contacts& contacts, Particles& particles, const Domain& domain, std::size_t pair_kinds, std::size_t walls, ThreadTeam& team);

}  // namespace quern
