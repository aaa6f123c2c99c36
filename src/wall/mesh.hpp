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

// A triangle's corners and unit normal side by side, as the touches read them, and a circle that holds it. Without area the normal
// is zero.
struct Facet {
  Vec3 corner[3];
  Vec3 normal;
  Vec3 middle;
  double radius;
};

// A sheet of triangles; a sphere touches it from either side. Made by make_mesh; not changed afterwards.
struct Mesh {
  std::vector<Vec3> vertices;                     // in the wall's own axes [m]
  std::vector<std::array<Index, 3>> triangles;    // counter-clockwise seen from the free side
  std::vector<Facet> facets;                      // one for each triangle
  BoxTree tree;
  double farthest = 0;

  double reach() const { return farthest; }  // greatest distance of a vertex from the origin [m]
};

// Builds the facets and the tree.
Mesh make_mesh(std::vector<Vec3> vertices, std::vector<std::array<Index, 3>> triangles);

// Appends to `found`, ascending, the triangles within `reach` [m] of a point in the mesh's own axes, and maybe some a little farther.
void triangles_near(const Mesh& mesh, const Vec3& point, double reach, std::vector<Index>& found);
// The same, beginning at some nodes of the tree.
void triangles_near(const Mesh& mesh, const std::vector<Index>& nodes, const Vec3& point, double reach, std::vector<Index>& found);
// Nodes, some tens at most, that together hold all triangles below the given nodes within `reach` of a point: where searches around
// there may begin. {0} is the whole tree.
std::vector<Index> nodes_near(const Mesh& mesh, std::vector<Index> nodes, const Vec3& point, double reach);

// Brings the triangles of a list that may be nearer to a point than `reach` to its front and returns how many they are; `nearest` [m]
// becomes a distance that none of the list falls below.
Index watch_triangles(const Mesh& mesh, Index* first, Index* last, const Vec3& point, double reach, double& nearest);

inline constexpr int most_touches = 8;

// The touches of a sphere with the triangles listed (in any order; all those within `radius` of the centre must be there): the local
// minima of the distance from its centre to their union that are nearer than `radius`, at most `most_touches`, nearest first.
// Minima whose normals differ by less than a degree count as one, the nearest: a plane whose vertices were rounded to
// floats stays a plane, a drum cut into 360 facets or more a drum. Returns their number. `gap`: how much farther than `radius` all of
// them are at least, where there is no touch.
int touch_triangles(const Mesh& mesh, const Index* first, const Index* last, const Vec3& centre, double radius, Touch* touches, double* gap = nullptr);

// Whether a place lies on a triangle, within a tolerance [m].
bool lies_on(const Mesh& mesh, Index triangle, const Vec3& place, double tolerance);

}  // namespace quern
