// Simple bodies as triangle meshes.
#pragma once
#include "src/base/pose.hpp"
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

// A mesh given in the axes of a pose, in those in which the pose is given; its velocities do not count.
Mesh moved(const Mesh& mesh, const Pose& pose);

// A closed line in the plane, without its first corner repeated [m].
using Outline = std::vector<std::array<double, 2>>;

// A circle about `centre` cut into `facets` (≥ 3); its corners lie on `radius` [m], the first in the direction of x.
Outline circle(double radius, const std::array<double, 2>& centre, int facets);

// A flat body from z_0 to z_1 [m] with upright sides, closed and looking outward: what the outline encloses less the holes. Outlines may
// run either way round; holes lie inside the outline and apart from each other.
Mesh plate(const Outline& outline, const std::vector<Outline>& holes, double z_0, double z_1);

}  // namespace quern
