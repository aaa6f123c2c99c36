#include "src/contact/shape_contacts.hpp"
#include <algorithm>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Rotation rotation(const Quad& q) { return {q.w, q.x, q.y, q.z}; }

Quad row(const Vec3& v, double companion = 0) { return {v.x(), v.y(), v.z(), companion}; }

// What two of a list do now. The plane between them, or the normal of their contact, is remembered in `guess`.
ShapeContact meet(const PlacedShape& a, const PlacedShape& b, bool touched, Quad& guess) {
  const Vec3 apart = a.centre - b.centre;
  const double reach = a.size * a.shape->bounding_radius + b.size * b.shape->bounding_radius;
  ShapeContact c;
  if (apart.squaredNorm() >= reach * reach) return c;
  const bool known = guess.x != 0 || guess.y != 0 || guess.z != 0;
  if (!touched) {
    // A plane that was between them a step ago most often still is.
    const Vec3 n = known ? vec(guess) : apart.normalized();
    if (a.size * a.shape->support.value(a.axes.transpose() * n) + b.size * b.shape->support.value(b.axes.transpose() * n) < n.dot(apart)) {
      guess = row(n);
      return c;
    }
  }
  c = known ? touch_from(a, b, vec(guess)) : touch(a, b);
  guess = row(c.normal);
  return c;
}

}  // namespace

double bounded_radius(double radius, const PlacedShape& body) {
  const double ball = body.size * body.shape->volume_radius;
  return std::clamp(radius, ball / radius_bound, ball * radius_bound);
}

PlacedShape placed(const Superquadric* shapes, std::uint8_t shape, const Quad& position, const Quad& orientation) {
  const Superquadric& form = shapes[shape];
  return {&form, position.w / form.bounding_radius, vec(position), rotation(orientation).toRotationMatrix()};
}

void shape_pair_forces(const StepContext& step, const Kernels& kernels, const PairLaw& pair, CandidateList& list, ContactBlock& block, const Workspace& work) {
  thread_local std::vector<ShapeTouch> touches;  // scratch memory that outlives a call
  touches.clear();
  const Particles& particles = *step.particles;
  for (Index k = 0; k < list.count; ++k) {
    const Index i = list.first[at(k)] / 4, j = list.second[at(k)] / 4;
    const Index row_i = block.row_of(list.first[at(k)]), row_j = block.row_of(list.second[at(k)]);
    const PlacedShape a = placed(step.shapes, particles.shape[at(row_i)], work.position[at(i)], work.orientation[at(i)]);
    const PlacedShape b = placed(step.shapes, particles.shape[at(row_j)], work.position[at(j)], work.orientation[at(j)]);
    Index& slot = list.slot[at(k)];
    const ShapeContact c = meet(a, b, slot >= 0, list.guess[at(k)]);
    if (!c.touching) {
      if (slot >= 0) end_contact(step, block, row_i, row_j, -1, slot);
      slot = -1;
      continue;
    }
    if (slot < 0) {
      slot = block.take_slot();
      const double ri = bounded_radius(c.radius_first, a), rj = bounded_radius(c.radius_second, b);
      block.shaped[at(slot)].w = ri * rj / (ri + rj);
    }
    Quad& memory = block.shaped[at(slot)];
    memory = row(c.normal, memory.w);
    const Vec3 place = 0.5 * (c.on_first + c.on_second), arm_i = place - a.centre, arm_j = place - b.centre;
    const Vec3 spin_i = vec(work.spin[at(i)]), spin_j = vec(work.spin[at(j)]);
    const double mass_i = work.velocity[at(i)].w, mass_j = work.velocity[at(j)].w;
    ShapeTouch t;
    t.normal = row(c.normal, c.overlap);
    t.arm_i = row(arm_i, memory.w);
    t.arm_j = row(arm_j, mass_i * mass_j / (mass_i + mass_j));
    t.velocity = row(vec(work.velocity[at(i)]) + spin_i.cross(arm_i) - vec(work.velocity[at(j)]) - spin_j.cross(arm_j));
    t.spin_difference = row(spin_i - spin_j);
    t.spin_sum = row(spin_i + spin_j);
    t.first = i, t.second = j, t.slot = slot;
    touches.push_back(t);
  }
  const auto count = static_cast<Index>(touches.size());
  if (count == 0) return;
  kernels.shape_forces(step, pair, touches.data(), count, block);
  for (const ShapeTouch& t : touches) {
    const Vec3 force = vec(t.force), moment = vec(t.moment);
    add(block.load[at(t.first)], {row(force), row(moment + vec(t.arm_i).cross(force))});
    add(block.load[at(t.second)], {row(-force), row(-moment - vec(t.arm_j).cross(force))});
  }
  block.sums.pair_contacts += count;
}

void shape_wall_forces(const StepContext& step, const Kernels& kernels, const PairLaw& pair, std::vector<ShapeTouch>& touches, ContactBlock& block) {
  const auto count = static_cast<Index>(touches.size());
  if (count == 0) return;
  kernels.shape_forces(step, pair, touches.data(), count, block);
  for (const ShapeTouch& t : touches) {
    const Vec3 force = vec(t.force), moment = vec(t.moment), arm = vec(t.arm_j);
    add(block.load[at(t.first - block.first)], {row(force), row(moment + vec(t.arm_i).cross(force))});
    WallSums& wall = block.wall_sums[at(t.second)];
    wall.force = wall.force - triple(force);
    wall.torque = wall.torque - triple(Vec3(arm.cross(force) + moment));
    // The wall's velocity at the contact and its spin, from what the particle has relative to them.
    const Particles& p = *step.particles;
    const Vec3 spin = vec(p.spin[at(t.first)]);
    const Vec3 velocity = vec(p.velocity[at(t.first)]) + spin.cross(vec(t.arm_i)) - vec(t.velocity);
    block.sums.wall_work += step.time_step * (force.dot(velocity) + moment.dot(spin - vec(t.spin_difference)));
  }
  block.sums.wall_contacts += count;
}

}  // namespace quern
