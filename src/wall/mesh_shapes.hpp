// Simple bodies as triangle meshes.
#pragma once
#include "src/wall/mesh.hpp"

namespace quern {

enum class FreeSide { inside, outside };

// The jacket of a cylinder about z from z_0 to z_1 [m], cut into `facets` (≥ 3) flat strips of two triangles whose edges lie on
// `radius` [m]. One edge lies at angle 0.
Mesh cylinder_jacket(double radius, double z_0, double z_1, int facets, FreeSide side);

// The twelve triangles of a box.
Mesh box_mesh(const Vec3& lower, const Vec3& upper, FreeSide side);

// A flat disc about z at height z [m], of `facets` (≥ 3) triangles that meet in its middle; its normal is +z.
Mesh disc_mesh(double radius, double z, int facets);

// Both as one mesh; equal vertices stay two.
Mesh joined(const Mesh& a, const Mesh& b);

}  // namespace quern
