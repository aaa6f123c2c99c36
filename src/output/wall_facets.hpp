// Walls as triangles, for files and pictures alone: the contact works on the surfaces themselves.
#pragma once
#include <array>
#include <vector>
#include "src/wall/walls.hpp"

namespace quern {

struct Facets {
  std::vector<Vec3> points;  // in the fixed frame [m]
  std::vector<std::array<Index, 3>> triangles;
};

// A sphere about a simulation's particles and its finite walls.
struct Surroundings {
  Vec3 centre = Vec3::Zero();  // [m]
  double radius = 0;           // [m]
};
Surroundings surroundings(const std::vector<Wall>& walls, const std::vector<Quad>& positions);

// The wall where it stands now. Of a plane, which has no end, the square over the surroundings.
Facets facets_of(const Wall& wall, const Surroundings& shown, int around = 96);

}  // namespace quern
