#include "src/engine/simulation.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include "src/base/error.hpp"
#include "src/contact/shape_contacts.hpp"
#include "src/contact/workspace.hpp"
#include "src/field/shape_fields.hpp"
#include "src/particle/turning.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// Extent of the particles' box: how far a plane's point may lie from its origin.
double extent_of(const Particles& particles) {
  double largest = 0;
  for (const Quad& q : particles.position) largest = std::max({largest, std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  return 2 * largest;
}

[[noreturn]] void report_lost_particle(const Simulation& s) {
  for (Index i = 0; i < s.particles.owned; ++i) {
    const Quad& x = s.particles.position[at(i)];
    if (!(std::abs(x.x) + std::abs(x.y) + std::abs(x.z) < 1e150))
      throw RunError(fmt::format("at t = {:.6g} s (step {}) particle {} has no finite position any more; a smaller time step is the usual cure",
                                 s.clock.time(), s.clock.step, s.particles.id[at(i)]));
  }
  throw RunError(fmt::format("at t = {:.6g} s (step {}) a velocity is no longer finite; a smaller time step is the usual cure", s.clock.time(),
                             s.clock.step));
}

void advance_particles(Simulation& s, double time_step) {
  std::vector<double>& moved = s.contacts.moved;
  moved.resize(s.contacts.blocks.size());
  s.team->run(static_cast<int>(moved.size()), [&](int b) {
    const ContactBlock& block = s.contacts.blocks[static_cast<std::size_t>(b)];
    std::vector<Quad> before;
    if (s.contacts.shapes) before.assign(s.particles.orientation.begin() + block.first, s.particles.orientation.begin() + block.last);
    if (!s.particles.orientation.empty()) s.kernels->turn(s.particles, block.first, block.last, time_step);
    moved[static_cast<std::size_t>(b)] = s.kernels->advance(s.particles, block.first, block.last, time_step);
    if (s.contacts.shapes) turn_shapes(s.particles, block.first, block.last, before.data(), time_step);
  });
  double largest = 0;
  for (double m : moved) {
    if (!std::isfinite(m)) report_lost_particle(s);
    largest = std::max(largest, m);
  }
  s.contacts.travelled += largest;
  ++s.contacts.steps_since_search;
}

void search(Simulation& s) {
  const Triple<double> moved = search_neighbours(s.contacts, s.particles, s.bonds, s.domain, {s.pair_kind.data(), static_cast<Index>(s.materials.size()), s.pair_laws.size()},
                                                 s.walls.size(), *s.kernels, *s.team);
  s.ledger.field_work -= s.gravity.dot(vec(moved));
  s.team->run(static_cast<int>(s.contacts.blocks.size()),
              [&](int b) { find_wall_candidates(s.walls, s.particles, s.contacts.wall_skin + s.contacts.reach, s.contacts.blocks[static_cast<std::size_t>(b)]); });
}

void find_shape_forces(Simulation& s, const StepContext& context, ContactBlock& block, Workspace& work) {
  const std::size_t kinds = s.pair_laws.size();
  pose_shapes(context, block, work);
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    shape_pair_forces(context, *s.kernels, s.pair_laws[kind], block.candidates[kinds + kind], block, work);
    shape_wall_forces(context, *s.kernels, s.pair_laws[kind], block.shape_walls[kind], block);
  }
}

void find_forces(Simulation& s, const StepContext& context, ContactBlock& block) {
  thread_local Workspace work;  // scratch memory that outlives a call
  block.sums = {};
  block.collisions.clear();
  std::fill(block.wall_sums.begin(), block.wall_sums.end(), WallSums{});
  work.fit(block, !s.particles.orientation.empty());
  s.kernels->load_block(context, block, work);
  find_wall_touches(context, s.walls, block);
  const std::size_t kinds = s.pair_laws.size();
  if (block.shapes) find_shape_forces(s, context, block, work);
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    if (block.candidates[kind].count > 0) s.kernels->pair_forces(context, s.pair_laws[kind], block.candidates[kind], block, work);
    if (block.walls[kind].size() > 0) s.kernels->wall_forces(context, s.pair_laws[kind], block.walls[kind], block);
  }
  for (std::size_t k = kinds; k < block.candidates.size() && !block.shapes; ++k)
    s.kernels->pair_forces(context, s.pair_laws[k - kinds], block.candidates[k], block, work);
  block.bonds.failures.clear();
  if (block.bonds.count > 0) s.kernels->bond_forces(context, block, work);
  if (s.carried_density > 0) take_carried_weight(s.carried_density, s.gravity, s.particles, block.first, block.last, block.load.data());
  if (!s.fields.empty())
    block.sums.field_power = block.shapes ? apply_fields_to_shapes(s.fields, context.time, s.clock.time_step, s.particles, s.shapes.data(), block.first, block.last, block.load.data())
                                          : apply_fields(s.fields, context.time, s.clock.time_step, s.particles, block.first, block.last, block.load.data());
}

// Adds what the halos of blocks hold for a block's particles, in the order of the blocks, then completes their velocities.
void finish_block(Simulation& s, std::size_t mine, double time_step) {
  ContactBlock& block = s.contacts.blocks[mine];
  for (const Incoming& run : block.incoming) {
    const ContactBlock& other = s.contacts.blocks[at(run.block)];
    const Load* halo_load = other.load.data() + other.size();
    for (std::size_t k = at(run.from); k < at(run.to); ++k) add(block.load[at(other.halo[k].row - block.first)], halo_load[k]);
  }
  if (block.shapes) correct_momenta(s.particles, block.first, block.last, {&block.load[0].torque.x, sizeof(Load) / sizeof(double)}, time_step);
  s.kernels->correct(s.particles, block, time_step, triple(s.gravity));
  if (block.shapes) set_spins(s.particles, block.first, block.last);
}

// Forces on all particles, then their velocities. Once a block and all whose halo holds particles of it have their forces, nobody
// reads its particles any more: where that is so when its own forces are known, it is finished at once, while it is in the cache.
void apply_contacts(Simulation& s, const StepContext& context) {
  std::vector<ContactBlock>& blocks = s.contacts.blocks;
  const auto count = static_cast<int>(blocks.size());
  if (count == 1) {
    find_forces(s, context, blocks[0]);
    finish_block(s, 0, context.time_step);
    return;
  }
  std::vector<std::atomic<Index>> awaited(blocks.size());
  std::vector<std::uint8_t> finished(blocks.size(), 0);
  for (std::size_t b = 0; b < blocks.size(); ++b) awaited[b].store(static_cast<Index>(blocks[b].incoming.size()), std::memory_order_relaxed);
  s.team->run(count, [&](int b) {
    const auto mine = static_cast<std::size_t>(b);
    find_forces(s, context, blocks[mine]);
    for (Index target : blocks[mine].outgoing) awaited[at(target)].fetch_sub(1, std::memory_order_release);
    if (awaited[mine].load(std::memory_order_acquire) == 0) {
      finish_block(s, mine, context.time_step);
      finished[mine] = 1;
    }
  });
  if (std::find(finished.begin(), finished.end(), 0) == finished.end()) return;
  s.team->run(count, [&](int b) {
    if (const auto mine = static_cast<std::size_t>(b); !finished[mine]) finish_block(s, mine, context.time_step);
  });
}

void note_failures(Simulation& s, const ContactBlock& block) {
  for (BondFailure failure : block.bonds.failures) {
    Bond& bond = s.bonds.list[at(failure.bond)];
    bond.state = BondState::broken;
    failure.first = bond.first, failure.second = bond.second;
    s.bonds.failures.push_back(failure);
    s.ledger.bond_failure += failure.energy;
  }
}

// How far the effects of each pair reach, whose R* lies between half the smallest radius and the largest.
void note_effects(Simulation& s) {
  double smallest = 1e300, largest = 0;
  for (Index i = 0; i < s.particles.owned; ++i) smallest = std::min(smallest, s.particles.radius(i)), largest = std::max(largest, s.particles.radius(i));
  for (PairLaw& pair : s.pair_laws) {
    s.contacts.remembers |= pair.extras.any();
    pair.reach = largest > 0 ? pair.extras.reach(0.5 * smallest, largest) : 0;
    s.contacts.reach = std::max(s.contacts.reach, pair.reach);
  }
}

// Collects what the blocks noted, in their order.
void gather_sums(Simulation& s, double time_step) {
  Contacts& c = s.contacts;
  const double power_before = c.sums.bond_power, field_before = c.sums.field_power;
  c.sums = {};
  c.wall_sums.assign(s.walls.size(), {});
  c.ended.clear();
  for (const ContactBlock& block : c.blocks) {
    c.sums.elastic_energy += block.sums.elastic_energy;
    c.sums.normal_loss += block.sums.normal_loss;
    c.sums.sliding_loss += block.sums.sliding_loss;
    c.sums.rolling_loss += block.sums.rolling_loss;
    c.sums.wall_work += block.sums.wall_work;
    c.sums.field_power += block.sums.field_power;
    c.sums.bond_energy += block.sums.bond_energy;
    c.sums.bond_power += block.sums.bond_power;
    c.sums.pair_contacts += block.sums.pair_contacts;
    c.sums.wall_contacts += block.sums.wall_contacts;
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
      c.wall_sums[w].force = c.wall_sums[w].force + block.wall_sums[w].force;
      c.wall_sums[w].torque = c.wall_sums[w].torque + block.wall_sums[w].torque;
    }
    c.ended.insert(c.ended.end(), block.collisions.begin(), block.collisions.end());
    note_failures(s, block);
  }
  for (std::size_t w = 0; w < s.walls.size(); ++w) {
    s.walls[w].force = c.wall_sums[w].force;
    s.walls[w].torque = c.wall_sums[w].torque;
  }
  s.ledger.elastic = c.sums.elastic_energy;
  s.ledger.normal_loss += c.sums.normal_loss;
  s.ledger.sliding_loss += c.sums.sliding_loss;
  s.ledger.rolling_loss += c.sums.rolling_loss;
  s.ledger.bond_energy = c.sums.bond_energy;
  s.ledger.bond_loss += 0.5 * time_step * (power_before + c.sums.bond_power);
  s.ledger.wall_work += c.sums.wall_work;
  s.ledger.field_work += 0.5 * time_step * (field_before + c.sums.field_power);
  s.ledger.throughput += std::abs(c.sums.wall_work);
}

}  // namespace

double Simulation::solid_radius(Index i) const {
  if (particles.shape.empty()) return particles.radius(i);
  const Superquadric& shape = shapes[particles.shape[at(i)]];
  return particles.radius(i) / shape.bounding_radius * shape.volume_radius;
}

void Simulation::move_walls() {
  const std::vector<Pose> poses = poses_at(frames, clock.time());
  for (Wall& wall : walls) wall.pose = wall.frame < 0 ? wall.rest : carried(poses[at(wall.frame)], wall.rest);
}

StepContext Simulation::context() const {
  return {const_cast<Particles*>(&particles), &domain,      pair_kind.data(), static_cast<Index>(materials.size()), pair_laws.data(), clock.time_step,
          0.5 * clock.time_step,              clock.time(), contacts.travelled + contacts.wall_travelled,   shapes.data()};
}

void Simulation::start(bool record_collisions) {
  contacts = {};
  contacts.records = record_collisions;
  for (const PairLaw& pair : pair_laws) contacts.rolls |= pair.rolling.model != RollingModel::none;
  contacts.shapes = !particles.shape.empty();
  note_effects(*this);
  move_walls();
  extent_of_particles = extent_of(particles);
  if (carried_density > 0) add_carried_inertia(carried_density, particles);
  search(*this);
  // Forces where everything stands, without moving anything: the accelerations that the first step begins with.
  StepContext standing = context();
  standing.time_step = 0;
  apply_contacts(*this, standing);
  ledger = {};
  gather_sums(*this, 0);
  measure_energy();
  ledger.stored_at_start = ledger.stored();
  reference_energy = {ledger.kinetic, ledger.potential};
}

void Simulation::step() { go_on(1, clock.time_step); }

void Simulation::fly(std::int64_t steps) { go_on(steps, static_cast<double>(steps) * clock.time_step); }

void Simulation::fly_for(double time) {
  clock.origin += time;
  go_on(0, time);
}

void Simulation::go_on(std::int64_t steps, double time_step) {
  advance_particles(*this, time_step);
  clock.step += steps;
  move_walls();
  double closing = 0;
  if (!walls.empty()) {
    const double extent = extent_of_particles;
    for (const Wall& wall : walls) closing = std::max(closing, closing_speed(wall, extent));
  }
  contacts.wall_travelled += closing * time_step;
  if (contacts.stale()) {
    search(*this);
    extent_of_particles = extent_of(particles);
  }
  StepContext now = context();
  now.time_step = time_step;
  apply_contacts(*this, now);
  gather_sums(*this, time_step);
}

std::array<double, 2> Simulation::kinetic_and_potential() const {
  std::vector<std::array<double, 2>> parts(contacts.blocks.size());
  team->run(static_cast<int>(parts.size()), [&](int b) {
    const ContactBlock& block = contacts.blocks[static_cast<std::size_t>(b)];
    double kinetic = 0, potential = 0;
    for (Index i = block.first; i < block.last; ++i) {
      const Quad &v = particles.velocity[at(i)], &w = particles.spin[at(i)];
      const double inertia = carried_density > 0 ? v.w + carried_density * ball_volume(particles.radius(i)) : v.w;
      const double turning = block.shapes && particles.shape[at(i)] != 0 ? dot(xyz(particles.momentum[at(i)]), xyz(w)) : w.w * dot(xyz(w), xyz(w));
      kinetic += 0.5 * (inertia * dot(xyz(v), xyz(v)) + turning);
      potential -= v.w * dot(triple(gravity), xyz(particles.position[at(i)]));
    }
    parts[static_cast<std::size_t>(b)] = {kinetic, potential};
  });
  std::array<double, 2> total{0, 0};
  for (const auto& [kinetic, potential] : parts) total[0] += kinetic, total[1] += potential;
  return total;
}

void Simulation::measure_energy() {
  const auto [kinetic, potential] = kinetic_and_potential();
  ledger.kinetic = kinetic;
  ledger.potential = potential;
  ledger.exchanged = std::max({ledger.exchanged, std::abs(kinetic - reference_energy[0]), std::abs(potential - reference_energy[1])});
}

std::vector<Collision> Simulation::lasting_collisions() const {
  std::vector<Collision> lasting;
  const StepContext now = context();
  for (const ContactBlock& block : contacts.blocks) {
    ContactBlock scratch;  // end_collision reads the records and writes only `collisions`
    scratch.records = block.records;
    scratch.record = block.record;
    scratch.remembers = block.remembers;
    scratch.effects = block.effects;
    for_touching_pairs(block, [&](Index i, Index j, Index slot) { end_collision(now, scratch, i, j, -1, slot, true); });
    for (const WallCandidate& c : block.wall_candidates)
      for (Index k = 0; k < c.touches; ++k) end_collision(now, scratch, c.particle, 0, c.wall, block.wall_slots[at(c.first_slot + k)], true);
    lasting.insert(lasting.end(), scratch.collisions.begin(), scratch.collisions.end());
  }
  return lasting;
}

}  // namespace quern
