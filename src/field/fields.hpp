// src/field — gravity, drag and the other body forces: forces on single particles that depend on their place, velocity and spin.
//
// Gravity alone is part of the step itself (Simulation::gravity). A new field is one header and one word in the list below: it has
// at(time, time_step), whose result gives the load on a particle (position and radius, velocity and mass, spin and moment of inertia).
#pragma once
#include <string>
#include <variant>
#include <vector>
#include "src/contact/contact_block.hpp"
#include "src/field/medium.hpp"
#include "src/field/table_force.hpp"
#include "src/field/turning_frame.hpp"

namespace quern {

using Field = std::variant<TurningFrame, AirDrag, SphereDrag, ViscousDrag, Buoyancy, Magnus, TableForce>;

// Adds the fields at `time`, of steps of `time_step` > 0 [s], to the loads of the rows [first, last), of which load[0] belongs to `first`. Returns their power on these
// particles [W]; velocities are those that the forces see.
double apply_fields(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, Index first, Index last, Load* load);

// The force of all of them on the particle of a row [N].
Vec3 field_force(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, std::size_t row);

// What quern calls a field: its effect, or "force." and the case's name of a table.
std::string name_of(const Field& field);

// How fast it can change the motion of a ball of that radius and inertia, up to that speed and spin; see medium.hpp [1/s].
double rate_of(const Field& field, double radius, double inertia, double speed, double spin);

// Added mass: fluid of `carried_density` × a particle's volume moves with it. It adds to the inertia by which forces are divided ...
void add_carried_inertia(double carried_density, Particles& particles);
// ... but no gravity acts on it: this takes from the loads what the step, which gives all inertia the same, gives it too much.
void take_carried_weight(double carried_density, const Vec3& gravity, const Particles& particles, Index first, Index last, Load* load);

}  // namespace quern
