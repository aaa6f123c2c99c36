#include "src/wall/walls.hpp"
#include "src/contact/shape_contacts.hpp"
#include "src/contact/shape_meeting.hpp"
#include "src/wall/shape_walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace quern {
namespace {

// The touch of a smooth surface in its own axes; false when there is a gap between it and the sphere of that radius. A sphere wholly
// behind a sheet with one free side does not touch it; a plane has nothing but solid behind.
bool touch_smooth(const Surface& surface, const Vec3& local, double radius, Touch& touch, double& gap) {
  if (const Plane* plane = std::get_if<Plane>(&surface)) {
    gap = local.z() - radius;
    if (gap < 0) touch = plane->touch(local);
  } else {
    touch = std::get_if<Revolved>(&surface)->touch(local);
    gap = std::abs(touch.distance) - radius;
  }
  return gap < 0;
}

void into_fixed_frame(const Pose& pose, Touch* touches, int count) {
  for (int k = 0; k < count; ++k) {
    touches[k].point = pose.to_fixed(touches[k].point);
    touches[k].normal = pose.axes * touches[k].normal;
  }
}

// The touches with a mesh, in its own axes. Only triangles that may be touched while the particle stays near are looked at.
int touch_watched(const Mesh& mesh, WallCandidate& candidate, Index* triangles, const Vec3& local, double radius, Touch* touches, double& gap) {
  const double margin = 0.05 * radius;
  double moved = (local - vec(candidate.watched_from)).norm();
  if (candidate.watched < 0 || moved > margin) {
    double nearest = 0;
    candidate.watched =
        watch_triangles(mesh, triangles + candidate.first_triangle, triangles + candidate.last_triangle, local, radius + margin, nearest);
    candidate.watched_from = triple(local);
    moved = 0;
    if (candidate.watched == 0) {
      gap = nearest - radius;
      return 0;
    }
  }
  const Index* first = triangles + candidate.first_triangle;
  const int count = touch_triangles(mesh, first, first + candidate.watched, local, radius, touches, &gap);
  gap = std::min(gap, margin - moved);
  return count;
}

// The touches of a candidate now, nearer than `radius`, in the fixed frame; the gap beyond that if there are none.
int touch_candidate(const Wall& wall, WallCandidate& candidate, ContactBlock& block, const Quad& position, double radius, Touch* touches, double& gap) {
  const Vec3 local = wall.pose.to_local(vec(position));
  int count = 0;
  if (const Mesh* mesh = std::get_if<Mesh>(&wall.surface)) {
    count = touch_watched(*mesh, candidate, block.triangles.data(), local, radius, touches, gap);
  } else {
    count = touch_smooth(wall.surface, local, radius, touches[0], gap) ? 1 : 0;
  }
  into_fixed_frame(wall.pose, touches, count);
  return count;
}

// Gives each touch the slot of last step's touch whose normal is nearest, the closest pairs first; −1 where there is none.
// Claimed slots become −1 in `old_slots`.
void match(const Quad* old_normals, Index* old_slots, Index old_count, const Touch* touches, int count, Index* slots) {
  constexpr double alike = 0.7;
  if (old_count == 1 && count == 1) {
    const bool same = dot(xyz(old_normals[0]), triple(touches[0].normal)) > alike;
    slots[0] = same ? std::exchange(old_slots[0], -1) : -1;
    return;
  }
  std::fill(slots, slots + count, -1);
  for (;;) {
    double best = alike;
    Index best_old = -1;
    int best_new = -1;
    for (int k = 0; k < count; ++k) {
      if (slots[k] >= 0) continue;
      for (Index o = 0; o < old_count; ++o) {
        if (old_slots[o] < 0) continue;
        const double along = dot(xyz(old_normals[o]), triple(touches[k].normal));
        if (along > best) best = along, best_old = o, best_new = k;
      }
    }
    if (best_old < 0) return;
    slots[best_new] = old_slots[best_old];
    old_slots[best_old] = -1;
  }
}

WallTouch wall_touch(const Wall& wall, Index index, const Touch& touch, double radius) {
  const Vec3 arm = touch.point - wall.pose.origin;
  WallTouch t;
  set(t.normal, touch.normal);
  t.normal.w = radius - touch.distance;
  set(t.velocity, wall.pose.velocity_at(touch.point));
  set(t.spin, wall.pose.angular_velocity);
  set(t.point, arm);
  t.point.w = static_cast<double>(index);
  return t;
}

// The touches of a particle that is no sphere; where it is known to stay clear of the wall, how far.
int touch_candidate_shape(const StepContext& step, const Wall& wall, WallCandidate& candidate, ContactBlock& block, Touch* touches, ShapeContact* contacts, double& gap) {
  const Particles& p = *step.particles;
  const auto row = static_cast<std::size_t>(candidate.particle);
  gap = 0;
  if (touch_candidate(wall, candidate, block, p.position[row], p.position[row].w, touches, gap) == 0) return 0;
  const Index* triangles = block.triangles.data();
  const int count = touch_shape(wall, placed(step.shapes, p.shape[row], p.position[row], p.orientation[row]), triangles + candidate.first_triangle,
                                triangles + candidate.last_triangle, contacts, gap);
  for (int k = 0; k < count; ++k) touches[k].normal = contacts[k].normal;
  return count;
}

bool earlier(const WallCandidate& a, const WallCandidate& b) {
  return a.particle != b.particle ? a.particle < b.particle : a.wall < b.wall;
}

}  // namespace

int touch_wall(const Wall& wall, const Vec3& centre, double radius, Touch* touches) {
  const Vec3 local = wall.pose.to_local(centre);
  int count = 0;
  if (const Mesh* mesh = std::get_if<Mesh>(&wall.surface)) {
    std::vector<Index> triangles;
    triangles_near(*mesh, local, radius, triangles);
    count = touch_triangles(*mesh, triangles.data(), triangles.data() + triangles.size(), local, radius, touches);
  } else {
    double gap = 0;
    count = touch_smooth(wall.surface, local, radius, touches[0], gap) ? 1 : 0;
  }
  into_fixed_frame(wall.pose, touches, count);
  return count;
}

double closing_speed(const Wall& wall, double domain_size) {
  const Pose& pose = wall.pose;
  const Vec3 axis = pose.axes.col(2);
  if (std::holds_alternative<Plane>(wall.surface))
    return std::abs(pose.velocity.dot(axis)) + pose.angular_velocity.cross(axis).norm() * domain_size;
  if (const Revolved* r = std::get_if<Revolved>(&wall.surface)) {
    const double reach = std::max(std::hypot(r->radius_0, r->z_0), std::hypot(r->radius_1, r->z_1));
    return pose.velocity.norm() + pose.angular_velocity.cross(axis).norm() * reach;
  }
  return pose.velocity.norm() + pose.angular_velocity.norm() * std::get<Mesh>(wall.surface).reach();
}

void find_wall_candidates(const std::vector<Wall>& walls, const Particles& particles, double skin, ContactBlock& block) {
  // Only candidates that touch have something to hand over.
  std::vector<WallCandidate> touching;
  for (const WallCandidate& c : block.wall_candidates)
    if (c.touches > 0) touching.push_back(c);
  std::sort(touching.begin(), touching.end(), earlier);
  const std::vector<Index> old_slots = std::move(block.wall_slots);
  const std::vector<Quad> old_normals = std::move(block.wall_normals);
  block.wall_slots = {};
  block.wall_normals = {};
  block.wall_candidates.clear();
  block.triangles.clear();

  // Where to begin in the tree of each mesh: near the ball that holds the block's particles, and then those of a few rows.
  constexpr Index group = 16;
  std::vector<std::vector<Index>> near_block(walls.size(), {0}), near_group(walls.size());
  const auto narrow = [&](Index first, Index last, const std::vector<std::vector<Index>>& from, std::vector<std::vector<Index>>& to) {
    Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
    double largest = 0;
    for (Index i = first; i < last; ++i) {
      const Quad& position = particles.position[static_cast<std::size_t>(i)];
      lower = lower.cwiseMin(vec(position)), upper = upper.cwiseMax(vec(position));
      largest = std::max(largest, position.w);
    }
    const double reach = (1 + 1e-9) * 0.5 * (upper - lower).norm() + largest + skin;
    for (std::size_t w = 0; w < walls.size(); ++w)
      if (const Mesh* mesh = std::get_if<Mesh>(&walls[w].surface))
        to[w] = nodes_near(*mesh, from[w], walls[w].pose.to_local(0.5 * (lower + upper)), reach);
  };
  if (block.last > block.first) narrow(block.first, block.last, std::vector<std::vector<Index>>(near_block), near_block);

  auto old = touching.begin();
  for (Index i = block.first; i < block.last; ++i) {
    if ((i - block.first) % group == 0) narrow(i, std::min(block.last, i + group), near_block, near_group);
    const Quad& position = particles.position[static_cast<std::size_t>(i)];
    const double reach = position.w + skin;
    for (Index w = 0; w < static_cast<Index>(walls.size()); ++w) {
      const Wall& wall = walls[static_cast<std::size_t>(w)];
      const Vec3 local = wall.pose.to_local(vec(position));
      const auto triangles_before = static_cast<Index>(block.triangles.size());
      bool near = false;
      if (const Mesh* mesh = std::get_if<Mesh>(&wall.surface)) {
        triangles_near(*mesh, near_group[static_cast<std::size_t>(w)], local, reach, block.triangles);
        near = static_cast<Index>(block.triangles.size()) > triangles_before;
      } else {
        Touch touch;
        double gap = 0;
        near = touch_smooth(wall.surface, local, reach, touch, gap);
      }
      const bool touched = old != touching.end() && old->particle == i && old->wall == w;
      if (!near && !touched) continue;
      WallCandidate candidate{i, w, triangles_before, static_cast<Index>(block.triangles.size()), -1, 0, 0.0, -1, {}};
      if (touched) {
        candidate.first_slot = static_cast<Index>(block.wall_slots.size());
        candidate.touches = old->touches;
        const auto from = static_cast<std::ptrdiff_t>(old->first_slot);
        block.wall_slots.insert(block.wall_slots.end(), old_slots.begin() + from, old_slots.begin() + from + old->touches);
        block.wall_normals.insert(block.wall_normals.end(), old_normals.begin() + from, old_normals.begin() + from + old->touches);
        ++old;
      }
      block.wall_candidates.push_back(candidate);
    }
  }
}

void find_wall_touches(const StepContext& step, const std::vector<Wall>& walls, ContactBlock& block) {
  const Particles& particles = *step.particles;
  for (ActiveList& list : block.walls) list.clear();
  for (std::vector<ShapeTouch>& list : block.shape_walls) list.clear();
  block.wall_touches.clear();
  // This step's slots and normals are appended behind last step's, which go when all have been matched.
  const std::size_t old_size = block.wall_slots.size();
  Touch touches[most_touches];
  Index slots[most_touches];
  ShapeContact contacts[most_places];
  for (WallCandidate& candidate : block.wall_candidates) {
    const auto i = static_cast<std::size_t>(candidate.particle);
    const bool shaped = block.shapes && particles.shape[i] != 0;
    // What turns may come nearer with other places than its centre: its own path, which knows that, is added.
    const double path = shaped ? particles.momentum[i].w + step.path : step.path;
    if (candidate.touches == 0 && path < candidate.asleep_until) continue;
    const Wall& wall = walls[static_cast<std::size_t>(candidate.wall)];
    double gap = 0;
    const std::size_t kind = step.pair_kind[particles.material[i] * step.material_count + wall.material];
    const double radius = particles.position[i].w + step.pair_laws[kind].reach;
    const int count = shaped ? touch_candidate_shape(step, wall, candidate, block, touches, contacts, gap)
                             : touch_candidate(wall, candidate, block, particles.position[i], radius, touches, gap);
    if (count == 0) {
      candidate.asleep_until = path + (1 - 1e-9) * gap;
      if (candidate.touches == 0) continue;
    }

    if (candidate.touches > 0) {
      const auto first_old = static_cast<std::size_t>(candidate.first_slot);
      Index* old_slots = block.wall_slots.data() + first_old;
      match(block.wall_normals.data() + first_old, old_slots, candidate.touches, touches, count, slots);
      for (Index o = 0; o < candidate.touches; ++o) {
        if (old_slots[o] < 0) continue;
        end_contact(step, block, candidate.particle, 0, candidate.wall, old_slots[o]);
      }
    } else {
      std::fill(slots, slots + count, -1);
    }

    candidate.first_slot = count > 0 ? static_cast<Index>(block.wall_slots.size() - old_size) : -1;
    candidate.touches = count;
    ActiveList& list = block.walls[kind];
    for (int k = 0; k < count; ++k) {
      const bool fresh = slots[k] < 0;
      if (fresh) slots[k] = block.take_slot();
      if (shaped) {
        Quad& memory = block.shaped[shaped_rows * static_cast<std::size_t>(slots[k])];
        if (fresh) memory.w = bounded_radius(contacts[k].radius_first, placed(step.shapes, particles.shape[i], particles.position[i], particles.orientation[i]));
        block.shape_walls[kind].push_back(shape_touch(particles, candidate.particle, wall, candidate.wall, contacts[k], memory.w, slots[k]));
        block.wall_slots.push_back(slots[k]);
        block.wall_normals.push_back(block.shape_walls[kind].back().normal);
        continue;
      }
      list.push(candidate.particle, static_cast<Index>(block.wall_touches.size()), slots[k]);
      block.wall_touches.push_back(wall_touch(wall, candidate.wall, touches[k], particles.position[i].w));
      block.wall_slots.push_back(slots[k]);
      block.wall_normals.push_back(block.wall_touches.back().normal);
    }
  }
  block.wall_slots.erase(block.wall_slots.begin(), block.wall_slots.begin() + static_cast<std::ptrdiff_t>(old_size));
  block.wall_normals.erase(block.wall_normals.begin(), block.wall_normals.begin() + static_cast<std::ptrdiff_t>(old_size));
}

}  // namespace quern
