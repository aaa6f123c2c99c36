// The contacts of one block of particles: candidate pairs, the memory of those that touch, and this step's list of them.
// Blocks depend on the number of particles alone. One thread works on a block at a time and writes only the block's own
// particles; forces on particles of later blocks wait in `remote` and are added in the order of the blocks. That fixes
// every sum, whatever the number of threads.
#pragma once
#include <vector>
#include "src/contact/laws.hpp"

namespace quern {

// What a touching contact remembers: the sliding and the rolling spring, each with its energy as companion.
struct alignas(64) ContactMemory {
  Quad sliding, rolling;
};

// A collision from first touch to now. Kept only where the run records collisions.
struct alignas(64) CollisionRecord {
  double start_time = -1;        // [s]; negative until the first force
  double normal_speed = 0;       // approach speed at first touch [m/s]
  double tangential_speed = 0;   // [m/s]
  double peak_force = 0;         // normal [N]
  double peak_overlap = 0;       // [m]
  double normal_loss = 0;        // [J]
  double tangential_loss = 0;    // sliding and rolling [J]
  double effective_mass = 0;     // [kg]
};

// A finished (or, at the end of a run, still lasting) collision, as observers see it.
struct Collision {
  Index first_id;      // particle
  Index second_id;     // particle, or −1 − wall
  std::uint8_t first_species;
  std::uint8_t second_species;  // 255 for a wall
  bool lasting;        // still touching when it was written down
  double end_time;     // [s]
  double first_mass;   // [kg]
  Triple<double> place;  // [m]
  CollisionRecord record;
};

struct WallCandidate {
  Index particle;
  Index wall;
  Index first_triangle, last_triangle;  // range in `triangles`, meshes only
  Index first_slot;                     // of the touches it has now, in `wall_slots`; −1: none
  Index touches;
};

// A sphere touching a wall, ready for the force kernel.
struct WallTouch {
  Quad normal;    // into the sphere; companion: overlap [m]
  Quad velocity;  // of the wall at the contact point [m/s]
  Quad spin;      // of the wall [rad/s]
  Quad point;     // of contact, from the wall's origin [m]; companion: index of the wall
};

struct Remote {
  Quad force, torque;
  Index particle;
};

// Touching contacts of one pair of materials in this step. Grows out of line: the kernels that fill it are compiled for
// several instruction sets and must not leave copies of shared functions behind.
struct ActiveList {
  std::vector<Index> first, second, slot;  // second: particle row, or position in `wall_touches`
  Index count = 0;
  void clear() { count = 0; }
  Index size() const { return count; }
  QUERN_INLINE void push(Index i, Index j, Index s) {
    if (static_cast<std::size_t>(count) == first.size()) grow();
    const auto at = static_cast<std::size_t>(count++);
    first[at] = i, second[at] = j, slot[at] = s;
  }
  void grow();
};

struct StepSums {
  double elastic_energy = 0;   // stored now [J]
  double normal_loss = 0;      // lost in this step [J]
  double sliding_loss = 0;     // [J]
  double rolling_loss = 0;     // [J]
  double wall_work = 0;        // done by the walls on the particles in this step [J]
  Index pair_contacts = 0, wall_contacts = 0;
};

struct WallSums {
  Triple<double> force{};   // of the particles on the wall [N]
  Triple<double> torque{};  // about the wall's origin [N m]
};

// Candidates beyond the end that a kernel may read: a SIMD batch, and those it asks the cache for in advance.
inline constexpr Index candidates_ahead = 24, candidate_padding = candidates_ahead + 8;

struct ContactBlock {
  Index first = 0, last = 0;          // rows of the particle arrays
  std::vector<Index> row_start;       // of each particle's candidates in `neighbour`
  std::vector<Index> neighbour;       // rows j > i, ascending; padded
  std::vector<Index> slot;            // into `memory`; −1: not touching; padded

  std::vector<WallCandidate> wall_candidates;
  std::vector<Index> triangles;
  std::vector<WallTouch> wall_touches;
  std::vector<Index> wall_slots;      // slots of this step's wall touches, in the order of the candidates
  std::vector<Quad> wall_normals;     // their normals, by which a touch finds its memory again

  std::vector<ContactMemory> memory;  // row 0 is scratch, for the idle lanes of a SIMD batch
  std::vector<CollisionRecord> record;
  std::vector<Index> free_slots;

  std::vector<ActiveList> pairs, walls;      // by pair kind
  std::vector<std::vector<Remote>> remote;   // by later block
  std::vector<WallSums> wall_sums;           // by wall
  std::vector<Collision> collisions;         // ended in this step
  StepSums sums;

  bool records = false;               // whether collisions are written down

  Index take_slot();                  // a cleared row of memory
  void release_slot(Index s);
  void push_remote(std::size_t block, const Remote& r);
};

}  // namespace quern
