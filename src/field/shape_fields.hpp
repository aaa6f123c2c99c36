// Fields on particles that are no spheres: what a fluid does to the ball of the same volume, through the centre of mass.
#pragma once
#include "shapes/superquadric.hpp"
#include "src/field/fields.hpp"

namespace quern {

// Whether quern knows what the field does to such a particle: a frame's torques on it would be others than on a sphere, and tables have none to tell.
bool takes_shapes(const Field& field);

// apply_fields for rows of which some are no spheres; `shapes` by their index.
double apply_fields_to_shapes(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, const Superquadric* shapes, Index first, Index last, Load* load);

}  // namespace quern
