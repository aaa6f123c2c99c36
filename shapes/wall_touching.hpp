// Where a superquadric touches surfaces of revolution about the z axis of its surroundings, which its pose is told in, and edges.
#pragma once
#include "shapes/touching.hpp"

namespace quern {

inline constexpr int most_places = 4;

// The inside of a cylinder's jacket: every place that is farther from the axis than its surroundings and than the radius. A body that
// leans against the jacket with two edges touches twice. Returns how many; normals point to the axis, on_second lies on the jacket. Where none
// does, `gap` becomes a distance by which all of the body is within the jacket for certain.
int touch_inside_cylinder(const PlacedShape& body, double radius, ShapeContact* contacts, double& gap);

// The outside of a cylinder's jacket without ends.
ShapeContact touch_outside_cylinder(const PlacedShape& body, double radius);

// A straight line without ends, through a place; and a point. In any axes.
ShapeContact touch_line(const PlacedShape& body, const Vec3& place, const Vec3& direction);
ShapeContact touch_point(const PlacedShape& body, const Vec3& place);

// A straight edge from one place to another.
ShapeContact touch_edge(const PlacedShape& body, const Vec3& from, const Vec3& to);

// A circle about the axis, the edge of a thin sheet that lies beyond it (a hole) or within it (a rim): touches its tangents at the places
// deepest in the body among those of the sheet around them. Returns how many, at most most_places.
enum class Sheet { beyond, within };
int touch_circle(const PlacedShape& body, double radius, double height, Sheet sheet, ShapeContact* contacts);

// Where a triangle, whose plane has that unit normal, is deepest in a body: the place of least gauge.
struct DeepestPlace {
  Vec3 place;
  double gauge;  // below 1: within the body
  int edge;      // on which, or at an end of which, it lies: that from this corner to the next; −1: at the face
};
DeepestPlace deepest_place(const PlacedShape& body, const Vec3* corners, const Vec3& normal);

}  // namespace quern
