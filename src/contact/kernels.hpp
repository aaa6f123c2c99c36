// The inner loops, compiled once for each instruction set and chosen when the program starts.
#pragma once
#include "src/base/domain.hpp"
#include "src/contact/contact_block.hpp"
#include "src/particle/particles.hpp"

namespace quern {

// What every kernel reads.
struct StepContext {
  Particles* particles;
  const Domain* domain;
  const std::uint8_t* pair_kind;  // [material_i * material_count + material_j]
  Index material_count;
  Index block_size;               // particles per block: block of row j is j / block_size
  double time_step;               // [s]; 0 where forces are evaluated without a step
  double ahead;                   // half the next step [s]
  double time;                    // at the end of the step [s]
};

struct Kernels {
  const char* name;
  // Lists the candidate pairs that overlap now in block.pairs; gives new contacts a slot and ends those that parted.
  void (*find_touching)(const StepContext&, ContactBlock&);
  // Forces of the listed pairs, or wall touches, of one kind.
  void (*pair_forces)(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
  void (*wall_forces)(const StepContext&, const PairLaw&, const ActiveList&, ContactBlock&);
};

// The best for this processor, or the one the name asks for ("portable", "avx2", "avx512").
const Kernels& best_kernels();
const Kernels* find_kernels(const char* name);

namespace portable { extern const Kernels kernels; }
namespace avx2 { extern const Kernels kernels; }
namespace avx512 { extern const Kernels kernels; }

// Writes down the end of a contact of particle i with particle j (wall < 0) or with a wall.
void end_collision(const StepContext&, ContactBlock&, Index i, Index j, Index wall, Index slot, bool lasting);

}  // namespace quern
