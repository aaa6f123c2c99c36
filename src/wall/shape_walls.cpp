#include "src/wall/shape_walls.hpp"
#include <algorithm>
#include <cmath>
#include <vector>

namespace quern {
namespace {

bool is_cylinder(const Revolved& r) { return r.radius_0 == r.radius_1; }
bool is_disc(const Revolved& r) { return r.z_0 == r.z_1; }

constexpr double one_degree = 1 - 1.5230484360873042e-4;  // its cosine

// A sheet between two circles, in its own axes. Its face touches where the place of its plane that is deepest in the body lies on it; its edges
// where else they are deepest. An edge pushes off the sheet or along its normal, never towards it: where a drum's end meets its jacket, an edge would.
int touch_disc(const Revolved& r, const PlacedShape& body, ShapeContact* contacts) {
  const double inner = std::min(r.radius_0, r.radius_1), outer = std::max(r.radius_0, r.radius_1);
  const Vec3 normal = (body.centre.z() < r.z_0 ? -1 : 1) * Vec3::UnitZ();
  ShapeContact face = touch_plane(body, {0, 0, r.z_0}, normal);
  if (!face.touching) return 0;
  const double distance = std::abs(body.centre.z() - r.z_0);
  const Vec3 deepest = body.centre + distance / (distance + face.overlap) * (face.on_first - body.centre);
  const auto put = [&](const Vec3& place) { face.on_second = place, face.on_first = place - face.overlap * normal; };
  const auto off = [](const Vec3& place) { return place.head<2>().norm(); };
  const double at = off(deepest);
  int count = 0;
  if (at >= inner && at <= outer) {
    if (off(face.on_second) < inner || off(face.on_second) > outer) put(deepest);
    contacts[count++] = face;
  }
  const auto edge = [&](double radius, Sheet sheet) {
    ShapeContact found[most_places];
    const int places = touch_circle(body, radius, r.z_0, sheet, found);
    for (int k = 0; k < places && count < most_places; ++k) {
      const double outward = found[k].normal.head<2>().dot(found[k].on_second.head<2>());
      if (sheet == Sheet::beyond ? outward > 0 : outward < 0) put(found[k].on_second), found[k] = face;
      if (std::none_of(contacts, contacts + count, [&](const ShapeContact& c) { return c.normal.dot(found[k].normal) > one_degree; })) contacts[count++] = found[k];
    }
  };
  if (inner > 0) edge(inner, Sheet::beyond);
  if (at > outer) edge(outer, Sheet::within);
  return count;
}

// In the wall's own axes.
int touch_revolved(const Revolved& r, const PlacedShape& body, ShapeContact* contacts, double& gap) {
  if (is_disc(r)) return touch_disc(r, body, contacts);
  int count = 0;
  const bool inside = r.side == Revolved::Side::inside || (r.side == Revolved::Side::both && body.centre.head<2>().norm() < r.radius_0);
  if (inside) {
    count = touch_inside_cylinder(body, r.radius_0, contacts, gap);
  } else {
    contacts[0] = touch_outside_cylinder(body, r.radius_0);
    count = contacts[0].touching ? 1 : 0;
  }
  const double lower = std::min(r.z_0, r.z_1), upper = std::max(r.z_0, r.z_1);
  return static_cast<int>(std::remove_if(contacts, contacts + count, [&](const ShapeContact& c) { return c.on_second.z() < lower || c.on_second.z() > upper; }) - contacts);
}

// In the mesh's own axes. One contact for each place of the surface that is deepest among those around it: a triangle's is dropped
// where a triangle that holds its place has a deeper one.
int touch_mesh(const Mesh& mesh, const Index* first, const Index* last, const PlacedShape& body, ShapeContact* contacts) {
  struct Near {
    DeepestPlace deepest;
    Index triangle;
  };
  thread_local std::vector<Near> near;  // scratch memory that outlives a call
  near.clear();
  const auto facet = [&](Index triangle) -> const Facet& { return mesh.facets[static_cast<std::size_t>(triangle)]; };
  const double bound = body.size * body.shape->bounding_radius, tolerance = 1e-6 * bound;
  for (const Index* t = first; t != last; ++t) {
    const Facet& f = facet(*t);
    if (f.normal.isZero(0) || (body.centre - f.middle).squaredNorm() > (bound + f.radius) * (bound + f.radius)) continue;
    if (std::abs(f.normal.dot(body.centre - f.corner[0])) > body.size * body.shape->support.value(body.axes.transpose() * f.normal)) continue;
    const DeepestPlace deepest = deepest_place(body, f.corner, f.normal);
    if (deepest.gauge <= 1) near.push_back({deepest, *t});
  }
  std::sort(near.begin(), near.end(), [](const Near& a, const Near& b) { return a.deepest.gauge != b.deepest.gauge ? a.deepest.gauge < b.deepest.gauge : a.triangle < b.triangle; });
  // At a face as at its plane, whose contact may lie on a neighbour; where it lies beside the mesh, at the deepest place.
  const auto contact_of = [&](const Near& at) {
    const Facet& f = facet(at.triangle);
    const int edge = at.deepest.edge;
    if (edge >= 0) return touch_edge(body, f.corner[edge], f.corner[(edge + 1) % 3]);
    ShapeContact c = touch_plane(body, f.corner[0], f.normal.dot(body.centre - f.corner[0]) < 0 ? Vec3(-f.normal) : f.normal);
    if (std::none_of(near.begin(), near.end(), [&](const Near& other) { return lies_on(mesh, other.triangle, c.on_second, tolerance); }))
      c.on_second = at.deepest.place, c.on_first = c.on_second - c.overlap * c.normal;
    return c;
  };
  int count = 0;
  for (std::size_t k = 0; k < near.size() && count < most_places; ++k) {
    bool deepest = true;
    for (std::size_t j = 0; j < k && deepest; ++j) deepest = !lies_on(mesh, near[j].triangle, near[k].deepest.place, tolerance);
    if (!deepest) continue;
    const ShapeContact contact = contact_of(near[k]);
    for (int c = 0; c < count && deepest; ++c) deepest = contacts[c].normal.dot(contact.normal) < one_degree;
    if (deepest) contacts[count++] = contact;
  }
  return count;
}

}  // namespace

bool takes_shapes(const Wall& wall) {
  if (!std::holds_alternative<Revolved>(wall.surface)) return true;
  const Revolved* revolved = std::get_if<Revolved>(&wall.surface);
  return is_cylinder(*revolved) || is_disc(*revolved);
}

int touch_shape(const Wall& wall, const PlacedShape& body, ShapeContact* contacts) {
  std::vector<Index> triangles;
  if (const Mesh* mesh = std::get_if<Mesh>(&wall.surface))
    triangles_near(*mesh, wall.pose.to_local(body.centre), body.size * body.shape->bounding_radius, triangles);
  double gap = 0;
  return touch_shape(wall, body, triangles.data(), triangles.data() + triangles.size(), contacts, gap);
}

int touch_shape(const Wall& wall, const PlacedShape& body, const Index* first_triangle, const Index* last_triangle, ShapeContact* contacts, double& gap) {
  gap = 0;
  if (std::holds_alternative<Plane>(wall.surface)) {
    contacts[0] = touch_plane(body, wall.pose.origin, wall.pose.axes.col(2));
    gap = std::max(0.0, -contacts[0].overlap);
    return contacts[0].touching ? 1 : 0;
  }
  const Revolved* revolved = std::get_if<Revolved>(&wall.surface);
  PlacedShape local = body;
  local.centre = wall.pose.to_local(body.centre);
  local.axes = wall.pose.axes.transpose() * body.axes;
  const int count = revolved ? touch_revolved(*revolved, local, contacts, gap) : touch_mesh(std::get<Mesh>(wall.surface), first_triangle, last_triangle, local, contacts);
  for (int k = 0; k < count; ++k) {
    contacts[k].normal = wall.pose.axes * contacts[k].normal;
    contacts[k].on_first = wall.pose.to_fixed(contacts[k].on_first);
    contacts[k].on_second = wall.pose.to_fixed(contacts[k].on_second);
  }
  return count;
}

ShapeTouch shape_touch(const Particles& p, Index i, const Wall& wall, Index index, const ShapeContact& contact, double radius, Index slot) {
  const auto at = static_cast<std::size_t>(i);
  const Vec3 place = contact.on_second, arm = place - vec(p.position[at]), spin = vec(p.spin[at]);
  ShapeTouch t;
  t.normal = row(contact.normal, contact.overlap);
  t.arm_i = row(arm, radius);
  t.arm_j = row(place - wall.pose.origin, p.velocity[at].w);
  t.velocity = row(vec(p.velocity[at]) + spin.cross(arm) - wall.pose.velocity_at(place));
  t.spin_difference = row(spin - wall.pose.angular_velocity);
  t.spin_sum = row(spin + wall.pose.angular_velocity);
  t.first = i, t.second = index, t.slot = slot;
  return t;
}

}  // namespace quern
