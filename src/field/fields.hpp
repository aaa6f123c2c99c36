// src/field — gravity, drag and the other body forces: forces on single particles that depend on their place, velocity and spin.
//
// Gravity alone is part of the step itself (Simulation::gravity). A new field is one header and one word in the list below: it has
// at(time, time_step), whose result gives the load on a particle (position and radius, velocity and mass, spin and moment of inertia).
#pragma once
#include <variant>
#include <vector>
#include "src/contact/contact_block.hpp"
#include "src/field/turning_frame.hpp"

namespace quern {

using Field = std::variant<TurningFrame>;

// Adds the fields at `time`, of steps of `time_step` > 0 [s], to the loads of the rows [first, last), of which load[0] belongs to `first`. Returns their power on these
// particles [W]; velocities are those that the forces see.
double apply_fields(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, Index first, Index last, Load* load);

}  // namespace quern
