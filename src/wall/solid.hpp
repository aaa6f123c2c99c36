// Whether a point lies in the solid behind a wall: what a touch alone cannot tell for a point deep inside a mesh.
#pragma once
#include <vector>
#include "src/wall/walls.hpp"

namespace quern {

// The closed meshes among some walls. Each edge of a closed mesh is shared by two triangles, once in either sense.
class Solids {
 public:
  explicit Solids(const std::vector<Wall>& walls);
  // Whether a point of the fixed frame is enclosed by a closed mesh whose triangles look outward. A mesh that looks inward (a
  // vessel) and a mesh with open edges enclose no solid.
  bool contain(const Vec3& point) const;

 private:
  std::vector<const Wall*> meshes_;
};

}  // namespace quern
