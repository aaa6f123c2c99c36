// Where particles that are no spheres touch walls.
#pragma once
#include "shapes/wall_touching.hpp"
#include "src/wall/walls.hpp"

namespace quern {

// Whether such particles can touch the wall: all but cones.
bool takes_shapes(const Wall& wall);

// The touches of a body, told in the fixed frame; at most most_places. Of a mesh, with these of its triangles alone. Where there are none,
// `gap` becomes a distance that lies between the two for certain, which may be 0.
int touch_shape(const Wall& wall, const PlacedShape& body, const Index* first_triangle, const Index* last_triangle, ShapeContact* contacts, double& gap);
// The same with all triangles near; for setting up, not for the step.
int touch_shape(const Wall& wall, const PlacedShape& body, ShapeContact* contacts);

// Ready for the force kernel. `radius`: R* [m].
ShapeTouch shape_touch(const Particles& particles, Index row, const Wall& wall, Index index, const ShapeContact& contact, double radius, Index slot);

}  // namespace quern
