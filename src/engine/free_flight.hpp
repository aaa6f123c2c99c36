// How long a few bodies fly freely: what lets their steps be longer there (Simulation::fly).
#pragma once
#include "src/engine/simulation.hpp"

namespace quern {

// A number of time steps, at most `most`, in which nothing acts on another or comes to do so, judged by gaps, speeds and twice the present
// accelerations; 1 where something is near, where walls move or where space is periodic. Looks at every pair: for a few particles.
std::int64_t free_steps(const Simulation& simulation, std::int64_t most);

// From the surface of a sphere to a wall, negative inside it; beyond `reach` + radius of a mesh, `reach` [m].
double gap_to(const Wall& wall, const Vec3& centre, double radius, double reach);

}  // namespace quern
