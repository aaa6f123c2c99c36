// The inner loops, compiled once for each instruction set and chosen when the program starts.
#pragma once
#include "src/base/domain.hpp"
#include "src/contact/contact_block.hpp"
#include "src/particle/particles.hpp"

namespace quern {

struct CellGrid;
struct Superquadric;
struct Workspace;

// What every kernel reads.
struct StepContext {
  Particles* particles;
  const Domain* domain;
  const std::uint8_t* pair_kind;  // [material_i * material_count + material_j]
  Index material_count;
  const PairLaw* pair_laws;       // by pair kind
  double time_step;               // [s]; 0 where forces are evaluated without a step
  double ahead;                   // half the next step [s]
  double time;                    // at the end of the step [s]
  double path;                    // by which a particle may have come nearer to a wall since the search [m]
  const Superquadric* shapes;     // by the index that particles have
};

// What a neighbour search finds for one particle.
struct Found {
  std::vector<Index> row, image;  // the first `count` of them
  Index count = 0;
  void reserve(Index room);   // so many more
};

struct Kernels {
  const char* name;
  // Moves rows [first, last) by one step and predicts their velocities; returns the largest distance moved, NaN where a number
  // is no longer finite. Velocity Verlet with a predicted velocity (physics §1): second order also where forces depend on velocity.
  //   advance:  x += v dt + a dt²/2,  v ← v + a dt   (the prediction that the forces see)
  //   correct:  v += (a_new − a) dt/2                 (= v + (a + a_new) dt/2)
  // Without velocity-dependent forces this is velocity Verlet to the bit of its rounding; momentum is kept by construction.
  double (*advance)(Particles&, Index first, Index last, double time_step);
  // Turns the orientations of rows [first, last) by one step; call before `advance`. The spin of the middle of the step acts all
  // through it: second order, and |q| stays 1 to rounding.
  void (*turn)(Particles&, Index first, Index last, double time_step);
  // Turns the loads of a block's own particles into accelerations and completes the velocities.
  void (*correct)(Particles&, const ContactBlock&, double time_step, const Triple<double>& gravity);
  // Fills the workspace with a block's particles and halo, and clears their loads.
  void (*load_block)(const StepContext&, ContactBlock&, Workspace&);
  // Finds the candidate pairs of one kind that overlap now and adds their forces to the block's loads. New contacts get
  // a slot; those that parted end.
  void (*pair_forces)(const StepContext&, const PairLaw&, CandidateList&, ContactBlock&, Workspace&);
  void (*wall_forces)(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
  // The answers to contacts of other shapes than spheres; updates their memory and the block's sums.
  void (*shape_forces)(const StepContext&, const PairLaw&, ShapeTouch*, Index count, ContactBlock&);
  // Adds the forces of the block's bonds to its loads; bonds that fail are noted in block.bonds.failures and pull no more.
  void (*bond_forces)(const StepContext&, ContactBlock&, Workspace&);
  // Appends the particles nearer to particle i than touching by the skin, of greater rows than its own, to `found` (see
  // Found); all those of one grid.
  void (*find_near)(const Domain&, const CellGrid&, const Quad& centre, double skin, Index i, Found&);
};

// The best for this processor, or the one the name asks for ("portable", "avx2", "avx512").
const Kernels& best_kernels();
const Kernels* find_kernels(const char* name);

namespace portable { extern const Kernels kernels; }
namespace avx2 { extern const Kernels kernels; }
namespace avx512 { extern const Kernels kernels; }

// The kernels `pair_forces` and `wall_forces` hand over to these where a pair has effects; in files of their own.
namespace portable {
void pair_forces_with_effects(const StepContext&, const PairLaw&, CandidateList&, ContactBlock&, Workspace&);
void wall_forces_with_effects(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
}
namespace avx2 {
void pair_forces_with_effects(const StepContext&, const PairLaw&, CandidateList&, ContactBlock&, Workspace&);
void wall_forces_with_effects(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
}
namespace avx512 {
void pair_forces_with_effects(const StepContext&, const PairLaw&, CandidateList&, ContactBlock&, Workspace&);
void wall_forces_with_effects(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
}

// Ends a contact of particle i with particle j (wall < 0) or with a wall: what its effects still hold is lost, it is written down,
// and its memory is free again.
void end_contact(const StepContext&, ContactBlock&, Index i, Index j, Index wall, Index slot);

// Writes down the end of a contact of particle i with particle j (wall < 0) or with a wall.
void end_collision(const StepContext&, ContactBlock&, Index i, Index j, Index wall, Index slot, bool lasting);

}  // namespace quern
