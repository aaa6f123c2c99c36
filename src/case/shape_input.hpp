// Superquadrics in a case: reading them, placing them, and what does not go with them yet.
#pragma once
#include "src/case/case.hpp"
#include "src/case/values.hpp"
#include "src/engine/simulation.hpp"

namespace quern {

// The shape of a species' table; none: spheres.
std::optional<Superquadric> read_shape(const Values& v, const std::string& table);

// Whether the table tells a size distribution: it is then of the diameters of balls of the bodies' volume, and the semi-axes tell their proportions.
bool has_sizes(const Values& v, const std::string& table);

// The diameter of the ball that holds a body of that shape, from the diameter of the ball of its volume [m].
double held_by(const Superquadric& shape, double diameter);

// Agglomerates are made of spheres.
void refuse_shaped_grains(const Values& v, const Case& c);

// Appends a particle of a species that has a shape. `holding_diameter`: of the ball that holds it [m]; `turn`: its axes; velocity [m/s], spin [rad/s].
void add_shape(Simulation& s, const Case& c, std::uint8_t species, const Vec3& centre, double holding_diameter, const Mat3& turn, const Vec3& velocity, const Vec3& spin);

// The largest overlap that a particle of another shape than a sphere has with another one or a wall, in radii of the ball of the smaller one's
// volume. In time that grows with the square of their number: for particles of a list.
double largest_shape_overlap(const Simulation& s);

// Throws InputError that names the key, where a case with superquadrics has walls, effects or forces that know spheres alone.
void refuse_unfit_for_shapes(const Case& c, const Simulation& s);

}  // namespace quern
