// The intact bonds of one block of particles, in the form in which the kernels read them: eight at a time, with everything that does not
// change while a bond holds worked out beforehand. A bond belongs to the block of that of its grains which has the lower row.
#pragma once
#include <vector>
#include "bonds/bonds.hpp"

namespace quern {

inline constexpr int bonds_per_batch = 8;

// Lengths are in units of L_0: a strain is a stretch over L_0, energies are of a strain or an angle of one.
struct alignas(64) BondBatch {
  double axis[3][bonds_per_batch];
  double relation[4][bonds_per_batch];           // x, y, z, w
  double inverse_length[bonds_per_batch];        // 1/L_0 [1/m]
  double normal[bonds_per_batch];                // k_bn A L_0² [J]
  double shear[bonds_per_batch];                 // k_bs A L_0² [J]
  double slenderness[bonds_per_batch];           // 2 R_b/L_0
  double tension_limit[bonds_per_batch];         // σ_max/(k_bn L_0), a strain
  double shear_limit[bonds_per_batch];           // τ_max/(k_bs L_0)
  double normal_damping[bonds_per_batch], shear_damping[bonds_per_batch];      // [kg/s]
  double bending_damping[bonds_per_batch], twisting_damping[bonds_per_batch];  // [kg m²/s]
  Index first[bonds_per_batch], second[bonds_per_batch];  // offsets of the grains in the workspace, as in CandidateList
  Index bond[bonds_per_batch];                            // in Bonds::list; −1: an idle lane
  Index spare[bonds_per_batch];                           // fills the row of 64 bytes
};

// A bond by the rows of its grains.
struct BondRow {
  Index low, high;       // low < high
  Index bond;            // in Bonds::list
  bool first_is_low;
  bool intact;
  double overlap;        // > 0: where the contact of its grains begins [m]
};

struct BondList {
  std::vector<BondBatch> batches;
  Index count = 0;                     // of bonds, broken ones since the last search included
  std::vector<BondFailure> failures;   // in this step

  void clear() { batches.clear(), count = 0; }
  void push(const Bond& bond, Index index, Index first_offset, Index second_offset);
  // Fills the idle lanes of the last batch with bonds of no stiffness between two places of the workspace.
  void close(Index idle_offset);
  // Writes a failure down and makes its lane idle. Only time, energy, place, normal and mode need be given.
  void fail(BondBatch& batch, int lane, BondFailure failure);

  template <class A>
  void archive(A& a) {
    a(batches, count);
  }
};

// The intact bonds, and broken ones whose grains keep an overlap, by the block of their lower row; in each block ascending by that row.
// Broken bonds whose grains have parted are released.
std::vector<std::vector<BondRow>> bonds_by_block(Bonds& bonds, const Particles& particles, const Domain& domain, Index block_size, std::size_t blocks);

}  // namespace quern
