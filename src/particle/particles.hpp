// src/particle — the particle arrays, species, size distributions, insertion and packing. No contact laws.
#pragma once
#include <vector>
#include "src/base/triple.hpp"

namespace quern {

struct Superquadric;

// Structure of arrays; each array has one 32-byte row per particle, so that eight rows load and transpose into SIMD packs.
// Rows [0, owned) move; rows from `owned` on are ghosts: copies of particles that someone else moves.
struct Particles {
  std::vector<Quad> position;              // x [m], companion: radius [m]
  std::vector<Quad> velocity;              // v [m/s], companion: mass [kg]. During the force evaluation: predicted (see contact/kernels.hpp)
  std::vector<Quad> spin;                  // ω [rad/s], companion: moment of inertia [kg m²]
  std::vector<Quad> acceleration;          // of the last force evaluation [m/s²], companion: 1/inertia, of the mass and what fluid moves with it [1/kg]
  std::vector<Quad> angular_acceleration;  // [rad/s²], companion: 1/moment of inertia [1/(kg m²)]
  std::vector<std::uint8_t> material;      // index into the materials
  std::vector<std::uint8_t> species;       // index into the species
  std::vector<Index> id;                   // stable name: order of insertion
  // Unit quaternions that turn a particle's own axes into the fixed ones (x, y, z, companion: the scalar part). Empty unless something,
  // bonds for one, needs to know how particles have turned.
  std::vector<Quad> orientation;
  // Of particles that are no spheres. Empty unless there are any; their `position` then has the radius of the ball that holds them, their
  // `angular_acceleration` the torque (with the companion 1), and `spin` follows from the angular momentum.
  std::vector<std::uint8_t> shape;         // index into the shapes; 0: a sphere
  std::vector<Quad> momentum;              // angular momentum [kg m²/s]
  std::vector<Quad> inertia;               // moments about the particle's own axes [kg m²]
  Index owned = 0;

  Index size() const { return static_cast<Index>(position.size()); }
  double radius(Index i) const { return position[static_cast<std::size_t>(i)].w; }
  double mass(Index i) const { return velocity[static_cast<std::size_t>(i)].w; }

  // Appends a solid sphere at rest and returns its row. [m], [kg/m³]
  Index add_sphere(const Triple<double>& centre, double radius, double density, std::uint8_t material_index, std::uint8_t species_index);

  // Appends a solid superquadric at rest, unturned, of the shape with that index (not 0), whose semi-axes are `size` times the shape's.
  Index add_shape(const Triple<double>& centre, const Superquadric& form, std::uint8_t shape_index, double size, double density, std::uint8_t material_index,
                  std::uint8_t species_index);

  // From now on particles have an orientation; those that had none stand unturned.
  void keep_orientations();

  // Row k becomes what row order[k] was.
  void reorder(const std::vector<Index>& order);
};

}  // namespace quern
