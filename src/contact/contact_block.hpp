// The contacts of one block of particles: candidate pairs, the memory of those that touch, and the forces on other blocks' particles.
// Blocks depend on the number of particles alone. One thread works on a block at a time, on a copy of the block's own particles
// and of its halo: the particles of later blocks (or periodic images) that may touch them. Forces on the halo wait in `load` and
// are added in the order of the blocks. That fixes every sum, whatever the number of threads.
#pragma once
#include <cstddef>
#include <vector>
#include "bonds/bond_list.hpp"
#include "src/contact/laws.hpp"
#include "src/particle/particles.hpp"

namespace quern {

// A collision from first touch to now (of a pair whose effects reach beyond touch: until they end). Kept only where the run records collisions.
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
  double force;        // along the normal at the last step, of a pair with effects; else 0 [N]
  Triple<double> place;  // [m]
  CollisionRecord record;
};

struct WallCandidate {
  Index particle;
  Index wall;
  Index first_triangle, last_triangle;  // range in `triangles`, meshes only
  Index first_slot;                     // of the touches it has now, in `wall_slots`; −1: none
  Index touches;
  double asleep_until;                  // no touch before the path since the search is this long [m]
  Index watched = -1;                   // how many of the triangles, at the front of the range, may be touched; −1: not known
  Triple<double> watched_from{};        // while the particle is near this place, in the wall's axes [m]
};

// A sphere touching a wall, ready for the force kernel.
struct WallTouch {
  Quad normal;    // into the sphere; companion: overlap, negative where there is a gap [m]
  Quad velocity;  // of the wall at the contact point [m/s]
  Quad spin;      // of the wall [rad/s]
  Quad point;     // of contact, from the wall's origin [m]; companion: index of the wall
};

// Pairs of one pair kind that may touch. Particles are named by their offset: four times their row in the workspace, where the
// block's own particles come first and its halo after them (kernels address doubles).
struct CandidateList {
  std::vector<Index> first, second;  // offsets; `first` is the block's own and ascends
  std::vector<Index> slot;           // into the memory of contacts; −1: not touching
  std::vector<double> overlap_at_rest;  // empty, or where each contact begins: pairs that were bonded while they overlapped [m]
  std::vector<Quad> guess;           // empty, or of pairs in which one is no sphere: the normal of a contact or of a plane between them; 0: none known
  Index count = 0;                   // the vectors are longer by padding

  template <class A>
  void archive(A& a) {
    a(first, second, slot, overlap_at_rest, guess, count);
  }
};

// A contact of a particle that is no sphere with another one or with a wall, ready for the force kernel, and its answer.
struct ShapeTouch {
  Quad normal;           // from j, or the wall, to i; companion: overlap [m]
  Quad arm_i, arm_j;     // from the centres, or the wall's origin, to the contact [m]; companions: R* [m], m* [kg]
  Quad velocity;         // of i relative to j there [m/s]
  Quad spin_difference;  // ω_i − ω_j [rad/s]
  Quad spin_sum;         // ω_i + ω_j [rad/s]
  Quad force, moment;    // on i [N]; rolling moment on i [N m]
  Index first, second;   // rows of the workspace; for a wall: row of the particle arrays, wall
  Index slot;            // of the memory
};

// Touching contacts of particles and walls, of one pair kind, in this step.
struct ActiveList {
  std::vector<Index> first, second, slot;  // row of the particle, position in `wall_touches`, slot of the memory
  void clear() { first.clear(), second.clear(), slot.clear(); }
  Index size() const { return static_cast<Index>(first.size()); }
  void push(Index i, Index j, Index s) { first.push_back(i), second.push_back(j), slot.push_back(s); }
};

// A particle of a later block, or a periodic image, as a block sees it.
struct HaloRow {
  Index row;    // of the particle arrays
  Index image;  // see Domain::shift
};

// What acts on a particle.
struct alignas(64) Load {
  Quad force, torque;  // [N], [N m]
};

QUERN_INLINE void add(Load& to, const Load& what) {
  to.force.x += what.force.x, to.force.y += what.force.y, to.force.z += what.force.z;
  to.torque.x += what.torque.x, to.torque.y += what.torque.y, to.torque.z += what.torque.z;
}

// A run of another block's halo that lies in this block.
struct Incoming {
  Index block, from, to;
};

struct StepSums {
  double elastic_energy = 0;   // stored now [J]
  double normal_loss = 0;      // lost in this step [J]
  double sliding_loss = 0;     // [J]
  double rolling_loss = 0;     // [J]
  double wall_work = 0;        // done by the walls on the particles in this step [J]
  double field_power = 0;      // of the fields now [W]
  double bond_energy = 0;      // stored in bonds now [J]
  double bond_power = 0;       // that the damping of bonds takes now [W]
  Index pair_contacts = 0, wall_contacts = 0;
};

struct WallSums {
  Triple<double> force{};   // of the particles on the wall [N]
  Triple<double> torque{};  // about the wall's origin [N m]
};

// Lists that kernels read are longer than their count by this: a SIMD batch.
inline constexpr Index list_padding = 8;

struct ContactBlock {
  Index first = 0, last = 0;               // rows of the particle arrays
  std::vector<CandidateList> candidates;   // by pair kind; then, where any pair has an overlap at rest or is of other shapes, those pairs by pair kind
  std::vector<HaloRow> halo;               // grouped by block, ascending
  std::vector<Load> load;                  // on the block's own particles, on its halo, and on the two idle ones, in this step
  std::vector<Incoming> incoming;          // whose halo holds particles of this block, in the order of the blocks
  std::vector<Index> outgoing;             // the blocks that the halo lies in

  BondList bonds;

  std::vector<WallCandidate> wall_candidates;
  std::vector<Index> triangles;
  std::vector<WallTouch> wall_touches;
  std::vector<Index> wall_slots;      // slots of this step's wall touches, in the order of the candidates
  std::vector<Quad> wall_normals;     // their normals, by which a touch finds its memory again
  std::vector<ActiveList> walls;      // by pair kind
  std::vector<std::vector<ShapeTouch>> shape_walls;  // the same of particles that are no spheres; empty unless there are any

  // What touching contacts remember, by slot: a spring and its energy. Row 0 is scratch, for the idle lanes of a SIMD batch.
  std::vector<Quad> sliding;
  std::vector<Quad> rolling;          // empty unless `rolls`
  std::vector<Quad> effects;          // two rows to a slot, see Remembered; empty unless `remembers`
  std::vector<Quad> shaped;           // rows to a slot: see shaped_rows; R* is kept from first touch; empty unless `shapes`
  std::vector<CollisionRecord> record;  // empty unless `records`
  std::vector<Index> free_slots;
  bool rolls = false;                 // whether any pair has rolling resistance
  bool remembers = false;             // whether any pair has effects beyond its law
  bool records = false;               // whether collisions are written down
  bool shapes = false;                // whether any particle is no sphere

  std::vector<WallSums> wall_sums;    // by wall
  std::vector<Collision> collisions;  // ended in this step
  StepSums sums;

  Index size() const { return last - first; }
  // The row of the particle arrays that an offset names.
  Index row_of(Index offset) const {
    const Index local = offset / 4;
    return local < size() ? first + local : halo[static_cast<std::size_t>(local - size())].row;
  }
  Index take_slot();                  // a cleared row of memory
  void release_slot(Index s);
};

// Calls visit(row i, row j, slot) for each touching pair of the block, by pair kind, then in the order of i.
template <class Visit>
void for_touching_pairs(const ContactBlock& block, Visit&& visit) {
  for (const CandidateList& list : block.candidates)
    for (std::size_t k = 0; k < static_cast<std::size_t>(list.count); ++k)
      if (list.slot[k] >= 0) visit(block.row_of(list.first[k]), block.row_of(list.second[k]), list.slot[k]);
}

}  // namespace quern
