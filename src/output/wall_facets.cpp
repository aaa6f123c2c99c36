#include "src/output/wall_facets.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace quern {
namespace {

struct Box {
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  void hold(const Vec3& centre, double radius) {
    lower = lower.cwiseMin((centre.array() - radius).matrix());
    upper = upper.cwiseMax((centre.array() + radius).matrix());
  }
};

void hold_surface(const Plane&, const Pose&, Box&) {}
void hold_surface(const Revolved& r, const Pose& pose, Box& box) {
  for (const auto& [radius, z] : {std::pair(r.radius_0, r.z_0), std::pair(r.radius_1, r.z_1)}) {
    const Vec3 axis = pose.axes.col(2), centre = pose.to_fixed({0, 0, z});
    const Vec3 reach = radius * (Vec3::Ones() - axis.cwiseAbs2()).cwiseMax(0).cwiseSqrt();
    box.hold(centre - reach, 0);
    box.hold(centre + reach, 0);
  }
}
void hold_surface(const Mesh& mesh, const Pose& pose, Box& box) {
  for (const Vec3& v : mesh.vertices) box.hold(pose.to_fixed(v), 0);
}

Facets local_facets(const Plane&, const Wall& wall, const Surroundings& shown, int) {
  const Vec3 middle = wall.pose.to_local(shown.centre);
  const double x = middle.x(), y = middle.y(), r = shown.radius;
  return {{{x - r, y - r, 0}, {x + r, y - r, 0}, {x + r, y + r, 0}, {x - r, y + r, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

Facets local_facets(const Revolved& r, const Wall&, const Surroundings&, int around) {
  Facets out;
  for (int k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around, c = std::cos(angle), s = std::sin(angle);
    out.points.emplace_back(r.radius_0 * c, r.radius_0 * s, r.z_0);
    out.points.emplace_back(r.radius_1 * c, r.radius_1 * s, r.z_1);
  }
  for (Index k = 0; k < around; ++k) {
    const Index a = 2 * k, b = a + 1, c = 2 * ((k + 1) % around), d = c + 1;
    if (r.radius_0 > 0) out.triangles.push_back({a, c, d});
    if (r.radius_1 > 0) out.triangles.push_back({a, d, b});
  }
  return out;
}

Facets local_facets(const Mesh& mesh, const Wall&, const Surroundings&, int) { return {mesh.vertices, mesh.triangles}; }

}  // namespace

Surroundings surroundings(const std::vector<Wall>& walls, const std::vector<Quad>& positions) {
  Box box;
  for (const Wall& wall : walls) std::visit([&](const auto& surface) { hold_surface(surface, wall.pose, box); }, wall.surface);
  for (const Quad& q : positions) {
    if (std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z)) box.hold(vec(q), q.w);
  }
  if (!(box.lower.x() <= box.upper.x())) return {};
  return {0.5 * (box.lower + box.upper), 0.5 * (box.upper - box.lower).norm()};
}

Facets facets_of(const Wall& wall, const Surroundings& shown, int around) {
  Facets facets = std::visit([&](const auto& surface) { return local_facets(surface, wall, shown, around); }, wall.surface);
  for (Vec3& point : facets.points) point = wall.pose.to_fixed(point);
  return facets;
}

}  // namespace quern
