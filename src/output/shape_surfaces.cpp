#include "src/output/shape_surfaces.hpp"
#include <algorithm>

namespace quern {

ShapeSurfaces shape_surfaces(const Simulation& s, int cells, const std::function<bool(std::size_t)>& shown) {
  const Particles& p = s.particles;
  std::vector<SurfaceMesh> meshes;
  for (const Superquadric& shape : s.shapes) meshes.push_back(surface_mesh(shape, cells));
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < static_cast<std::size_t>(p.owned) && !p.shape.empty(); ++i)
    if (p.shape[i] != 0 && shown(i)) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p.id[a] < p.id[b]; });
  ShapeSurfaces surfaces;
  for (const std::size_t i : order) {
    const Superquadric& shape = s.shapes[p.shape[i]];
    const SurfaceMesh& mesh = meshes[p.shape[i]];
    const Mat3 turn = rotation_of(p.orientation[i]).toRotationMatrix();
    const double size = p.position[i].w / shape.bounding_radius;
    const auto base = static_cast<Index>(surfaces.points.size());
    for (const Vec3& corner : mesh.points) {
      surfaces.points.push_back(vec(p.position[i]) + turn * (size * corner));
      surfaces.normals.push_back(turn * shape.normal(corner));
      surfaces.particle.push_back(i);
    }
    for (const auto& t : mesh.triangles) surfaces.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  return surfaces;
}

double reach(const Simulation& s, std::size_t row, const Vec3& direction) {
  const Particles& p = s.particles;
  if (p.shape.empty() || p.shape[row] == 0) return p.position[row].w;
  const Superquadric& shape = s.shapes[p.shape[row]];
  return p.position[row].w / shape.bounding_radius * shape.support.value(rotation_of(p.orientation[row]).conjugate() * direction);
}

}  // namespace quern
