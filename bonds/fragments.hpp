// Fragments: what still hangs together of bodies of bonded grains. A fragment is a connected component of the graph whose edges are the
// intact bonds; a body is what hung together when its bonds were made. Grains are the particles that have had a bond: others, such as
// the balls of a mill, belong to no fragment.
#pragma once
#include <vector>
#include "bonds/bonds.hpp"

namespace quern {

// Velocity and energy leave the grains' motion about the fragment's centre out.
struct Fragment {
  Index id;                     // least id of its grains
  Index body;                   // least id of the grains of the body that it comes from
  Index grains;                 // how many
  double mass;                  // [kg]
  double volume;                // of its grains [m³]
  Triple<double> centre;        // of mass; of a fragment that reaches across a periodic boundary near its grain of least id [m]
  Triple<double> velocity;      // of that centre [m/s]
  double kinetic_energy() const { return 0.5 * mass * dot(velocity, velocity); }  // [J]
};

// Masses and volumes are whole multiples of one number, which is so small (2⁻⁵¹ of the whole or less) that their sums are not rounded: the
// masses of the fragments sum to the whole exactly, in any order, and the whole stays the same however it breaks. A grain's own mass is
// met to 2⁻⁵² of the whole.
struct Fragments {
  std::vector<Fragment> list;                  // by mass, largest first; equal ones by id
  std::vector<std::vector<Index>> members;     // of each: the rows of its grains, by id
  std::vector<Triple<double>> places;          // by row: where a grain is, beside the grain of its fragment with the least id [m]
  std::vector<Index> of_row;                   // by row: place in the list; −1: no grain
  double mass = 0, volume = 0;                 // of all [kg], [m³]
};

// The fragments now. Works for any rows that particles have; grains that are no more there are left out.
Fragments find_fragments(const Bonds& bonds, const Particles& particles, const Domain& domain);

// The bodies as if no bond had broken; of the same particles, where they are now.
Fragments find_bodies(const Bonds& bonds, const Particles& particles, const Domain& domain);

// Spheres: x, y, z, radius [m].
// The side of the smallest square opening through which they pass together on a straight way, turned as suits them best [m]: what a sieve
// measures. Long bodies pass lengthwise, so that it is the middle of three extents for most; flat ones pass across the corners of the
// opening (Fernlund 1998, Eng. Geol. 50:111). Found by trial of directions and refined: at most 1 % too large.
double smallest_square_opening(const std::vector<Quad>& spheres);

// The same of one fragment.
double sieve_size(const Fragments& fragments, std::size_t fragment, const Particles& particles);

}  // namespace quern
