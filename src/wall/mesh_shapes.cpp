#include "src/wall/mesh_shapes.hpp"

#include <cmath>

namespace quern {
namespace {

Vec3 on_circle(double radius, double z, int k, int facets) {
  const double angle = 2 * M_PI * k / facets;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

void turn_over(std::vector<std::array<Index, 3>>& triangles) {
  for (auto& t : triangles) std::swap(t[1], t[2]);
}

}  // namespace

Mesh cylinder_jacket(double radius, double z_0, double z_1, int facets, FreeSide side) {
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;
  for (Index k = 0; k < facets; ++k) {
    vertices.push_back(on_circle(radius, std::min(z_0, z_1), k, facets));
    vertices.push_back(on_circle(radius, std::max(z_0, z_1), k, facets));
    const Index low = 2 * k, high = low + 1, next_low = 2 * ((k + 1) % facets), next_high = next_low + 1;
    triangles.push_back({low, next_low, next_high});
    triangles.push_back({low, next_high, high});
  }
  if (side == FreeSide::inside) turn_over(triangles);
  return make_mesh(std::move(vertices), std::move(triangles));
}

Mesh box_mesh(const Vec3& lower, const Vec3& upper, FreeSide side) {
  std::vector<Vec3> vertices;
  for (int corner = 0; corner < 8; ++corner)
    vertices.emplace_back(corner & 1 ? upper.x() : lower.x(), corner & 2 ? upper.y() : lower.y(), corner & 4 ? upper.z() : lower.z());
  std::vector<std::array<Index, 3>> triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (side == FreeSide::inside) turn_over(triangles);
  return make_mesh(std::move(vertices), std::move(triangles));
}

Mesh disc_mesh(double radius, double z, int facets) {
  std::vector<Vec3> vertices = {Vec3(0, 0, z)};
  std::vector<std::array<Index, 3>> triangles;
  for (Index k = 0; k < facets; ++k) {
    vertices.push_back(on_circle(radius, z, k, facets));
    triangles.push_back({0, 1 + k, 1 + (k + 1) % facets});
  }
  return make_mesh(std::move(vertices), std::move(triangles));
}

Mesh joined(const Mesh& a, const Mesh& b) {
  std::vector<Vec3> vertices = a.vertices;
  vertices.insert(vertices.end(), b.vertices.begin(), b.vertices.end());
  std::vector<std::array<Index, 3>> triangles = a.triangles;
  const auto shift = static_cast<Index>(a.vertices.size());
  for (const auto& t : b.triangles) triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return make_mesh(std::move(vertices), std::move(triangles));
}

Mesh moved(const Mesh& mesh, const Pose& pose) {
  std::vector<Vec3> vertices;
  for (const Vec3& vertex : mesh.vertices) vertices.push_back(pose.to_fixed(vertex));
  return make_mesh(std::move(vertices), mesh.triangles);
}

}  // namespace quern
