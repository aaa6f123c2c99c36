// bonds — solid-bridge bonds between particles, their failure, agglomerates and fragments. No mills.
//
// The bonds of a simulation (physics of the parallel bond, Potyondy & Cundall 2004). A bond carries tension, shear, bending and twist,
// measured from the configuration in which it was made (Wang 2009: total, not summed step by step), so that rigid motion never loads it.
#pragma once
#include <functional>
#include <vector>
#include "bonds/bond_material.hpp"
#include "src/base/domain.hpp"
#include "src/particle/particles.hpp"

namespace quern {

enum class BondState : std::int32_t {
  intact,
  broken,    // its grains still keep the overlap with which they were bonded
  released,  // broken, and its grains have parted since: their contact is like any other
};

enum class BondFailureMode : std::int32_t { tension, shear };

// One bond: what it is and whether it still holds.
struct Bond {
  Quad relation;           // q_second* q_first when it was made
  Triple<double> axis;     // unit vector from the first grain to the second, in the axes of the first
  double length;           // L_0, between the centres [m]
  double radius;           // R_b [m]
  double normal_stiffness, shear_stiffness;     // k_bn, k_bs [N/m³]
  double normal_damping, shear_damping;         // [kg/s]
  double bending_damping, twisting_damping;     // [kg m²/s]
  double tensile_strength, shear_strength;      // [Pa]
  double overlap;          // of its grains when they were bonded: their contact begins there [m]
  Index first, second;     // ids of its grains, first < second
  Index material;
  BondState state;
};

struct BondFailure {
  double time;             // [s]
  double energy;           // elastic energy released [J]
  Triple<double> place;    // middle of the bond [m]
  Triple<double> normal;   // of the crack: unit vector between the centres then, from the first grain to the second
  Index bond;              // in the list
  Index first, second;     // ids of its grains
  BondFailureMode mode;    // the criterion that was exceeded by more
};

struct Bonds {
  std::vector<BondMaterial> materials;
  std::vector<Bond> list;              // intact and broken, in the order of making
  std::vector<BondFailure> failures;   // since the start, in the order of time

  bool empty() const { return list.empty(); }
  // Broken bonds over all bonds ever made [-].
  double damage() const { return list.empty() ? 0 : static_cast<double>(failures.size()) / static_cast<double>(list.size()); }

  template <class A>
  void archive(A& a) {
    a(list, failures);
  }
};

// Bonds the particles of two rows as they stand now, without stress, and returns the bond's index. Call before the simulation starts.
// Throws InputError if they are one particle, have one centre, or in a periodic direction lie half a period or more apart.
Index bond_particles(Bonds& bonds, Particles& particles, const Domain& domain, Index row, Index other_row, Index material, std::uint64_t seed);

// Bonds all pairs whose surfaces are nearer than `gap` [m] (overlapping ones too) and that have no bond yet; `material_of` says of which
// material two rows' bond is, −1: none. Returns how many were made.
std::int64_t bond_particles_nearer_than(Bonds& bonds, Particles& particles, const Domain& domain, double gap,
                                        const std::function<Index(Index, Index)>& material_of, std::uint64_t seed);
std::int64_t bond_particles_nearer_than(Bonds& bonds, Particles& particles, const Domain& domain, double gap, Index material, std::uint64_t seed);

}  // namespace quern
