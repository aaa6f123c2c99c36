// Particles that are no spheres as triangles, for files and pictures.
#pragma once
#include <array>
#include <functional>
#include <vector>
#include "src/engine/simulation.hpp"

namespace quern {

struct ShapeSurfaces {
  std::vector<Vec3> points, normals;            // in the fixed frame [m], unit
  std::vector<std::array<Index, 3>> triangles;  // seen from outside they turn left
  std::vector<std::size_t> particle;            // row of the particle that each point belongs to
};

// Of those that `shown` (by row) lets through, in the order of their ids; see surface_mesh for `cells`.
ShapeSurfaces shape_surfaces(const Simulation& simulation, int cells, const std::function<bool(std::size_t)>& shown);

// How far any particle reaches from its centre along a unit vector [m].
double reach(const Simulation& simulation, std::size_t row, const Vec3& direction);

}  // namespace quern
