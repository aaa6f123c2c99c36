#include "src/wall/solid.hpp"
#include <algorithm>
#include <utility>

namespace quern {
namespace {

bool closed(const Mesh& mesh) {
  std::vector<std::pair<Index, Index>> edges, reversed;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.emplace_back(t[k], t[(k + 1) % 3]);
      reversed.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::sort(reversed.begin(), reversed.end());
  return !edges.empty() && edges == reversed;
}

bool ray_meets_box(const BoxTree::Node& node, const Vec3& from, const Vec3& direction) {
  double enter = 0, leave = 1e300;
  for (int k = 0; k < 3; ++k) {
    const double a = (double(node.lower[k]) - from[k]) / direction[k], b = (double(node.upper[k]) - from[k]) / direction[k];
    enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

// +1 where the ray leaves the solid through the triangle, −1 where it enters, 0 where it misses.
int crossing(const Mesh& mesh, Index triangle, const Vec3& from, const Vec3& direction) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const Vec3 a = mesh.vertices[static_cast<std::size_t>(t[0])] - from, b = mesh.vertices[static_cast<std::size_t>(t[1])] - from,
             c = mesh.vertices[static_cast<std::size_t>(t[2])] - from;
  // Signed volumes: the ray passes through the triangle when it has its three edges on the same side.
  const double u = direction.dot(a.cross(b)), v = direction.dot(b.cross(c)), w = direction.dot(c.cross(a));
  const int sign = (u > 0 && v > 0 && w > 0) ? 1 : (u < 0 && v < 0 && w < 0) ? -1 : 0;
  if (sign == 0) return 0;
  const Vec3 normal = (b - a).cross(c - a);
  return normal.dot(a) / normal.dot(direction) > 0 ? sign : 0;
}

// How often the mesh winds about a point.
int winding(const Mesh& mesh, const Vec3& point) {
  // Oblique, so that it meets no edge of a mesh that is aligned with its axes.
  const Vec3 direction(0.5377183, 0.7182839, 0.4415927);
  int sum = 0;
  std::vector<Index> open{0};
  while (!open.empty()) {
    const BoxTree::Node& node = mesh.tree.nodes[static_cast<std::size_t>(open.back())];
    open.pop_back();
    if (!ray_meets_box(node, point, direction)) continue;
    if (node.count == 0) {
      open.push_back(node.first), open.push_back(node.first + 1);
      continue;
    }
    for (Index k = node.first; k < node.first + node.count; ++k)
      sum += crossing(mesh, mesh.tree.order[static_cast<std::size_t>(k)], point, direction);
  }
  return sum;
}

}  // namespace

Solids::Solids(const std::vector<Wall>& walls) {
  for (const Wall& wall : walls) {
    const Mesh* mesh = std::get_if<Mesh>(&wall.surface);
    if (mesh != nullptr && !mesh->tree.nodes.empty() && closed(*mesh)) meshes_.push_back(&wall);
  }
}

bool Solids::contain(const Vec3& point) const {
  return std::any_of(meshes_.begin(), meshes_.end(),
                     [&](const Wall* wall) { return winding(std::get<Mesh>(wall->surface), wall->pose.to_local(point)) > 0; });
}

}  // namespace quern
