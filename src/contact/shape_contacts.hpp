// Contacts of particles that are no spheres.
#pragma once
#include "shapes/touching.hpp"
#include "src/contact/kernels.hpp"
#include "src/contact/workspace.hpp"

namespace quern {

// R of one body's surface for a law, from its mean curvature: within this factor of the radius of the ball of its volume, since faces
// have no curvature and sharp edges nearly no radius.
inline constexpr double radius_bound = 5;
double bounded_radius(double radius, const PlacedShape& body);

PlacedShape placed(const Superquadric* shapes, std::uint8_t shape, const Quad& position, const Quad& orientation);

// What shape_pair_forces needs of a block's particles, once before it is called for each pair kind.
void pose_shapes(const StepContext& step, const ContactBlock& block, const Workspace& work);

// Finds which pairs of one list touch now, gives new ones a slot, ends those that parted, and adds their forces to the block's loads.
void shape_pair_forces(const StepContext& step, const Kernels& kernels, const PairLaw& pair, CandidateList& list, ContactBlock& block, const Workspace& work);

// Adds the forces of the walls touched by particles that are no spheres, which find_wall_touches left in the block.
void shape_wall_forces(const StepContext& step, const Kernels& kernels, const PairLaw& pair, std::vector<ShapeTouch>& touches, ContactBlock& block);

}  // namespace quern
