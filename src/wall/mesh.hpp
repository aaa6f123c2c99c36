// A triangle mesh as a wall: where a sphere touches it. One touch per feature: a sphere on a finely cut plane feels the
// plane, and a sphere in a corner feels each side once.
#pragma once
#include <array>
#include <vector>
#include "src/wall/surface.hpp"

namespace quern {

// A box tree over the triangles of a mesh (median split; leaves hold a few triangles).
struct BoxTree {
  struct Node {
    float lower[3], upper[3];  // widened to floats outward
    Index first, count;        // leaf: range in `order`; inner: children are `first` and `first + 1`, count = 0
  };
  std::vector<Node> nodes;
  std::vector<Index> order;
};

struct Mesh {
  std::vector<Vec3> vertices;                     // in the wall's own axes [m]
  std::vector<std::array<Index, 3>> triangles;    // counter-clockwise seen from the free side
  BoxTree tree;

  double reach() const;  // greatest distance of a vertex from the origin [m]
};

// Builds the tree; call after the vertices and triangles are in place.
Mesh make_mesh(std::vector<Vec3> vertices, std::vector<std::array<Index, 3>> triangles);

// Appends to `found`, ascending, the triangles within `reach` [m] of a point in the mesh's own axes.
void triangles_near(const Mesh& mesh, const Vec3& point, double reach, std::vector<Index>& found);

inline constexpr int most_touches = 8;

// The touches of a sphere with the triangles listed: the local minima of the distance from its centre to their union that
// are nearer than `radius`, at most `most_touches`, nearest first. Returns their number.
int touch_triangles(const Mesh& mesh, const Index* first, const Index* last, const Vec3& centre, double radius, Touch* touches);

}  // namespace quern
