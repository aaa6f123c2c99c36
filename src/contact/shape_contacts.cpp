#include "src/contact/shape_contacts.hpp"
#include "src/contact/shape_meeting.hpp"
#include <algorithm>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// The particles of one block on one thread; memory that outlives a call.
struct Scratch {
  std::vector<PlacedShape> bodies; // rows as in the workspace
  std::vector<PosedShape> poses;   // the same, for packs
  std::vector<double> path;        // of any place of them, upper bound [m]
  std::vector<KeptPair> kept;      // pairs that touched a step ago
  std::vector<Index> candidate;    // their places in the list
  std::vector<Meeting> meetings;
  std::vector<ShapeTouch> touches;
};

Scratch& scratch() {
  thread_local Scratch s;
  return s;
}

// Whether two touch that did not a step ago. If not, a plane between them stays in `guess`, its normal as long as the gap was when it was
// last made as wide as it can be, with the sum of paths at which to look again: until then they cannot have used up the gap.
ShapeContact meet(const PlacedShape& a, const PlacedShape& b, double paths, Quad& guess) {
  constexpr double worn = 0.3;  // of the widest gap; a plane with less is turned to widen it
  const Vec3 apart = a.centre - b.centre;
  const double reach = a.size * a.shape->bounding_radius + b.size * b.shape->bounding_radius, distance = apart.norm();
  const bool known = guess.x != 0 || guess.y != 0 || guess.z != 0;
  const auto sleep = [&](const Vec3& n, double gap, double widest) { guess = row(widest * n, paths + (1 - 1e-9) * gap); };
  ShapeContact c;
  if (distance > reach) {
    sleep(apart / distance, distance - reach, distance - reach);
    return c;
  }
  const Vec3 n = (known ? vec(guess) : apart).normalized();
  const double gap = n.dot(apart) - a.size * a.shape->support.value(a.axes.transpose() * n) - b.size * b.shape->support.value(b.axes.transpose() * n);
  if (gap > worn * (known ? vec(guess) : apart).norm()) {
    sleep(n, gap, known ? vec(guess).norm() : gap);
    return c;
  }
  if (gap <= 0) c = known ? touch_from(a, b, n) : touch(a, b);
  if (!c.touching) {
    c = widened(a, b, gap > 0 ? n : c.normal);
    sleep(c.normal, -c.overlap, -c.overlap);
    c.touching = false;
  }
  return c;
}

// The deepest places in each body's own axes, where the next step begins.
void remember(const ShapeContact& c, const PlacedShape& a, const PlacedShape& b, Quad* memory) {
  set(memory[0], c.normal);
  memory[1] = row(a.axes.transpose() * (c.on_first - a.centre));
  memory[2] = row(b.axes.transpose() * (c.on_second - b.centre));
}

}  // namespace

double bounded_radius(double radius, const PlacedShape& body) {
  const double ball = body.size * body.shape->volume_radius;
  return std::clamp(radius, ball / radius_bound, ball * radius_bound);
}

PlacedShape placed(const Superquadric* shapes, std::uint8_t shape, const Quad& position, const Quad& orientation) {
  const Superquadric& form = shapes[shape];
  return {&form, position.w / form.bounding_radius, vec(position), rotation_of(orientation).toRotationMatrix()};
}

void pose_shapes(const StepContext& step, const ContactBlock& block, const Workspace& work) {
  Scratch& s = scratch();
  const Particles& particles = *step.particles;
  const std::size_t count = at(block.size()) + block.halo.size();
  s.bodies.resize(count), s.poses.resize(count), s.path.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t from = at(block.row_of(static_cast<Index>(4 * k)));
    const PlacedShape& body = s.bodies[k] = placed(step.shapes, particles.shape[from], work.position[k], work.orientation[k]);
    const Vec3 inverse = body.shape->gauge.scale / body.size;
    PosedShape& pose = s.poses[k];
    for (int axis = 0; axis < 3; ++axis) pose.axis[axis] = row(body.axes.col(axis), inverse[axis]);
    pose.centre = row(body.centre, body.size * body.shape->volume_radius);
    pose.exponents = {body.shape->n1(), body.shape->n2(), 0, 0};
    s.path[k] = particles.momentum[from].w;
  }
}

void shape_pair_forces(const StepContext& step, const Kernels& kernels, const PairLaw& pair, CandidateList& list, ContactBlock& block, const Workspace& work) {
  Scratch& s = scratch();
  s.kept.clear(), s.candidate.clear(), s.touches.clear();
  const auto body = [&](Index offset) -> const PlacedShape& { return s.bodies[at(offset / 4)]; };
  const auto begin = [&](std::size_t k, const Vec3& normal, double overlap, const Vec3& arm_i) {
    const Index i = list.first[k] / 4, j = list.second[k] / 4, slot = list.slot[k];
    const Vec3 arm_j = arm_i + vec(work.position[at(i)]) - vec(work.position[at(j)]);
    const Vec3 spin_i = vec(work.spin[at(i)]), spin_j = vec(work.spin[at(j)]);
    const double mass_i = work.velocity[at(i)].w, mass_j = work.velocity[at(j)].w;
    ShapeTouch& t = s.touches.emplace_back();
    t.normal = row(normal, overlap);
    t.arm_i = row(arm_i, block.shaped[shaped_rows * at(slot)].w);
    t.arm_j = row(arm_j, mass_i * mass_j / (mass_i + mass_j));
    t.velocity = row(vec(work.velocity[at(i)]) + spin_i.cross(arm_i) - vec(work.velocity[at(j)]) - spin_j.cross(arm_j));
    t.spin_difference = row(spin_i - spin_j);
    t.spin_sum = row(spin_i + spin_j);
    t.first = i, t.second = j, t.slot = slot;
  };
  const auto found = [&](std::size_t k, const ShapeContact& c, const PlacedShape& a, const PlacedShape& b) {
    remember(c, a, b, &block.shaped[shaped_rows * at(list.slot[k])]);
    begin(k, c.normal, c.overlap, 0.5 * (c.on_first + c.on_second) - a.centre);
  };
  const auto end = [&](std::size_t k, const Vec3& normal) {
    end_contact(step, block, block.row_of(list.first[k]), block.row_of(list.second[k]), -1, list.slot[k]);
    list.slot[k] = -1;
    list.guess[k] = row(normal);
  };

  for (std::size_t k = 0; k < at(list.count); ++k) {
    const Index i = list.first[k] / 4, j = list.second[k] / 4;
    if (list.slot[k] >= 0) {
      s.kept.push_back({i, j, list.slot[k]}), s.candidate.push_back(static_cast<Index>(k));
      continue;
    }
    const double paths = s.path[at(i)] + s.path[at(j)];
    if (paths < list.guess[k].w) continue;
    const PlacedShape &a = body(list.first[k]), &b = body(list.second[k]);
    const ShapeContact c = meet(a, b, paths, list.guess[k]);
    if (!c.touching) continue;
    const double ri = bounded_radius(c.radius_first, a), rj = bounded_radius(c.radius_second, b);
    list.slot[k] = block.take_slot();
    block.shaped[shaped_rows * at(list.slot[k])].w = ri * rj / (ri + rj);
    found(k, c, a, b);
  }
  s.meetings.resize(s.kept.size());
  shape_meetings(kernels).meet(s.poses.data(), s.kept.data(), static_cast<Index>(s.kept.size()), block.shaped.data(), s.meetings.data());
  for (std::size_t m = 0; m < s.kept.size(); ++m) {
    const Meeting& met = s.meetings[m];
    const std::size_t k = at(s.candidate[m]);
    if (met.arm.w == 0) {
      const PlacedShape &a = body(list.first[k]), &b = body(list.second[k]);
      const ShapeContact c = touch_from(a, b, vec(block.shaped[shaped_rows * at(list.slot[k])]));
      if (c.touching)
        found(k, c, a, b);
      else
        end(k, c.normal);
    } else if (met.normal.w >= 0) {
      set(block.shaped[shaped_rows * at(list.slot[k])], vec(met.normal));
      begin(k, vec(met.normal), met.normal.w, vec(met.arm));
    } else {
      end(k, vec(met.normal));
    }
  }
  std::vector<ShapeTouch>& touches = s.touches;
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
