#include "src/contact/shape_contacts.hpp"
#include "src/contact/shape_meeting.hpp"
#include <algorithm>
#include <optional>

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
  std::vector<ParallelPlanes> near; // pairs that did not, and may now
  std::vector<Index> near_candidate;
  std::vector<Gap> gap;            // along those planes
  std::vector<KeptPair> tried;     // of these, those that nearly touch, as if they had: what would be their memory, and what comes of it
  std::vector<Index> trial;        // by place in `near`: place in `tried`; −1: none
  std::vector<Quad> memory;
  std::vector<Meeting> outcome;
  std::vector<ParallelPlanes> planes; // that these outcomes lay between them, by place in `tried`
  std::vector<Gap> plane_gap;
  std::vector<Meeting> meetings;
  std::vector<ShapeTouch> touches;
};

Scratch& scratch() {
  thread_local Scratch s;
  return s;
}

// Of two that did not touch a step ago a plane between them stays in `guess`: its normal, as long as the gap was when it was last made as
// wide as it can be, with the sum of paths at which to look again: until then they cannot have used up the gap.
void sleep(const Vec3& n, double gap, double widest, double paths, Quad& guess) { guess = row(widest * n, paths + (1 - 1e-9) * gap); }

bool known(const Quad& guess) { return guess.x != 0 || guess.y != 0 || guess.z != 0; }

// Whether the balls that hold them leave a gap.
bool clear_of(const PlacedShape& a, const PlacedShape& b, double paths, Quad& guess) {
  const Vec3 apart = a.centre - b.centre;
  const double reach = a.size * a.shape->bounding_radius + b.size * b.shape->bounding_radius, distance = apart.norm();
  if (distance <= reach) return false;
  sleep(apart / distance, distance - reach, distance - reach, paths, guess);
  return true;
}

constexpr Index asleep = -2;  // instead of a place in `tried`

constexpr double worn = 0.3;  // of the widest gap; a plane with less is turned to widen it
double widest(const PlacedShape& a, const PlacedShape& b, const Quad& guess) { return known(guess) ? vec(guess).norm() : (a.centre - b.centre).norm(); }

// Whether they touch, of two that are so far apart along n.
ShapeContact meet(const PlacedShape& a, const PlacedShape& b, const Vec3& n, double gap, double paths, Quad& guess) {
  ShapeContact c;
  if (gap <= 0) c = known(guess) ? touch_from(a, b, n) : touch(a, b);
  if (!c.touching) {
    c = widened(a, b, gap > 0 ? n : c.normal);
    sleep(c.normal, -c.overlap, -c.overlap, paths, guess);
    c.touching = false;
  }
  return c;
}

// What two that nearly touched came to, where that is certain: a place within both, or a plane between them.
std::optional<ShapeContact> outcome(const PlacedShape& a, const PlacedShape& b, const Meeting& met, const Quad* memory, double plane_gap, double paths, Quad& guess) {
  constexpr double shallow = 1e-3;  // overlap over size; deeper, other sides may have less
  if (met.arm.w == 0) return {};
  ShapeContact c;
  if (met.normal.w < 0) {
    if (plane_gap <= 0) return {};
    sleep(vec(met.normal), plane_gap, plane_gap, paths, guess);
    return c;
  }
  const auto within = [](const PlacedShape& body, const Vec3& place) { return body.shape->gauge.value(body.axes.transpose() * (place - body.centre)) <= body.size; };
  const Vec3 middle = a.centre + vec(met.arm);
  if (met.normal.w > shallow * std::min(a.size * a.shape->volume_radius, b.size * b.shape->volume_radius) || !within(a, middle) || !within(b, middle)) return {};
  c.touching = true;
  c.normal = vec(met.normal), c.overlap = met.normal.w;
  c.on_first = a.centre + a.axes * vec(memory[1]), c.on_second = b.centre + b.axes * vec(memory[2]);
  const auto radius = [](const PlacedShape& body, const Quad& place) { return body.size / body.shape->curvature(vec(place) / body.size).mean(); };
  c.radius_first = radius(a, memory[1]), c.radius_second = radius(b, memory[2]);
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
  s.kept.clear(), s.candidate.clear(), s.near.clear(), s.near_candidate.clear(), s.touches.clear();
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
    const PlacedShape &a = s.bodies[at(i)], &b = s.bodies[at(j)];
    if (clear_of(a, b, paths, list.guess[k])) continue;
    const Vec3 n = (known(list.guess[k]) ? vec(list.guess[k]) : Vec3(a.centre - b.centre)).normalized();
    s.near.push_back({row(n), i, j}), s.near_candidate.push_back(static_cast<Index>(k));
  }
  s.gap.resize(s.near.size());
  shape_meetings(kernels).gaps(s.poses.data(), s.near.data(), static_cast<Index>(s.near.size()), s.gap.data());
  s.tried.clear(), s.memory.clear(), s.trial.assign(s.near.size(), -1);
  for (std::size_t m = 0; m < s.near.size(); ++m) {
    const ParallelPlanes& planes = s.near[m];
    Quad& guess = list.guess[at(s.near_candidate[m])];
    const double before = widest(s.bodies[at(planes.first)], s.bodies[at(planes.second)], guess), gap = s.gap[m].first.w;
    if (gap > worn * before) {
      sleep(vec(planes.normal), gap, known(guess) ? before : gap, s.path[at(planes.first)] + s.path[at(planes.second)], guess);
      s.trial[m] = asleep;
    } else if (known(guess)) {
      s.trial[m] = static_cast<Index>(s.tried.size());
      s.tried.push_back({planes.first, planes.second, s.trial[m]});
      s.memory.insert(s.memory.end(), {planes.normal, s.gap[m].first, s.gap[m].second});
    }
  }
  s.outcome.resize(s.tried.size()), s.planes.resize(s.tried.size()), s.plane_gap.resize(s.tried.size());
  shape_meetings(kernels).meet(s.poses.data(), s.tried.data(), static_cast<Index>(s.tried.size()), s.memory.data(), s.outcome.data());
  for (std::size_t t = 0; t < s.tried.size(); ++t) s.planes[t] = {s.outcome[t].arm.w == 0 ? s.memory[shaped_rows * t] : s.outcome[t].normal, s.tried[t].first, s.tried[t].second};
  shape_meetings(kernels).gaps(s.poses.data(), s.planes.data(), static_cast<Index>(s.planes.size()), s.plane_gap.data());
  for (std::size_t m = 0; m < s.near.size(); ++m) {
    if (s.trial[m] == asleep) continue;
    const std::size_t k = at(s.near_candidate[m]), i = at(s.near[m].first), j = at(s.near[m].second);
    const PlacedShape &a = s.bodies[i], &b = s.bodies[j];
    const double paths = s.path[i] + s.path[j];
    std::optional<ShapeContact> certain;
    if (s.trial[m] >= 0) {
      const std::size_t t = at(s.trial[m]);
      certain = outcome(a, b, s.outcome[t], &s.memory[shaped_rows * t], s.plane_gap[t].first.w, paths, list.guess[k]);
    }
    const ShapeContact c = certain ? *certain : meet(a, b, vec(s.near[m].normal), s.gap[m].first.w, paths, list.guess[k]);
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
