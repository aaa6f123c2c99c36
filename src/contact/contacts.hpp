// All contacts of a simulation: blocks of particles with their candidate pairs, and when those must be searched again.
#pragma once
#include "src/base/threads.hpp"
#include "src/contact/kernels.hpp"

namespace quern {

struct Contacts {
  std::vector<ContactBlock> blocks;
  Index block_size = 1;
  bool records = false;         // whether collisions are written down
  bool rolls = false;           // whether any pair has rolling resistance
  bool remembers = false;       // whether any pair has effects beyond its law
  bool shapes = false;          // whether any particle is no sphere
  double reach = 0;             // beyond touch, of the pair that reaches farthest [m]
  double skin = 0;              // candidate pairs are nearer than this beyond reach [m]
  double wall_skin = 0;         // and particles and walls nearer than this [m]
  double motion = 0;            // by which the skin is used up [m/step]
  double travelled = 0;         // an upper bound of any particle's path since the last search [m]
  double wall_travelled = 0;    // the same for walls
  std::int64_t searches = 0;
  std::int64_t steps_since_search = 0;
  std::vector<double> moved;      // by block: the largest distance in the last step [m]
  std::vector<Collision> ended;   // in the last step
  StepSums sums;                  // of the last step
  std::vector<WallSums> wall_sums;

  bool stale() const { return blocks.empty() || 2 * travelled > skin || travelled + wall_travelled > wall_skin; }
};

// Which law serves which two materials.
struct PairKinds {
  const std::uint8_t* of;  // [a * materials + b]
  Index materials;
  std::size_t count;
};

// Searches the candidate pairs of all particles within the skin, whose width follows from how long the last search served;
// every so often it sorts the particles in space first. Touching contacts, of pairs and of walls, keep their memory.
// Bonds are handed to the blocks. Positions are brought back into the periodic domain; returns Σ m Δx of those moves [kg m].
Triple<double> search_neighbours(Contacts& contacts, Particles& particles, Bonds& bonds, const Domain& domain, const PairKinds& kinds,
                                 std::size_t walls, const Kernels& kernels, ThreadTeam& team);

}  // namespace quern
