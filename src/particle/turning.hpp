// How bodies turn whose three moments of inertia differ.
#pragma once
#include <cstddef>
#include "src/base/vec.hpp"
#include "src/particle/particles.hpp"

namespace quern {

// Turns a free rigid body by `time` [s]: unit quaternion (own axes into fixed ones), angular momentum in the fixed frame [kg m²/s], moments
// about its own axes [kg m²]. Five exact turns about single axes, second order and symplectic (NO_SQUISH: Miller et al. 2002); the
// angular momentum itself stays to the bit, the energy oscillates with the square of the step and does not drift.
Rotation turned_freely(const Rotation& orientation, const Vec3& momentum, const Vec3& moments, double time);

// ω of a body [rad/s], fixed frame.
Vec3 spin_of(const Rotation& orientation, const Vec3& momentum, const Vec3& moments);

// One step of the particles of rows [first, last) that are no spheres, in two halves about Kernels::turn and ::advance, which know spheres
// alone: `before` are these rows' orientations at the start of the step. Predicts the angular momentum as Kernels::advance does the velocity.
// The companion of each row of `momentum`, of spheres too, grows by how far any place of the particle can have come [m].
void turn_shapes(Particles& particles, Index first, Index last, const Quad* before, double time_step);

// Completes the angular momenta with the torques found in this step (row `first` has loads[0]), as Kernels::correct does velocities; call
// it before. Afterwards set_spins.
struct Torques {
  const double* first;    // x of the first row's torque [N m]
  std::ptrdiff_t stride;  // in doubles, from row to row
};
void correct_momenta(Particles& particles, Index first, Index last, const Torques& torques, double time_step);
void set_spins(Particles& particles, Index first, Index last);

// Gives a particle that is no sphere this spin [rad/s].
void set_spin(Particles& particles, Index row, const Vec3& spin);

}  // namespace quern
