#include "src/engine/soundness.hpp"
#include <algorithm>
#include <cmath>
#include "src/contact/shape_meeting.hpp"

namespace quern {
namespace {

bool below(Index index, std::size_t count) { return index >= 0 && static_cast<std::size_t>(index) < count; }
bool below_or_none(Index index, std::size_t count) { return index == -1 || below(index, count); }

// Arrays that are there for every particle, or not at all.
template <class T>
bool either(const std::vector<T>& array, bool there, std::size_t count) {
  return array.size() == (there ? count : 0);
}

template <class T>
bool all_below(const std::vector<T>& indices, std::size_t count) {
  return std::all_of(indices.begin(), indices.end(), [&](T index) { return static_cast<std::size_t>(index) < count; });
}

bool each_once(const std::vector<Index>& ids) {
  std::vector<bool> seen(ids.size());
  for (const Index id : ids) {
    if (!below(id, ids.size()) || seen[static_cast<std::size_t>(id)]) return false;
    seen[static_cast<std::size_t>(id)] = true;
  }
  return true;
}

bool sound_particles(const Simulation& s, const Extent& extent) {
  const Particles& p = s.particles;
  const std::size_t n = extent.particles;
  for (const auto* rows : {&p.position, &p.velocity, &p.spin, &p.acceleration, &p.angular_acceleration}) {
    if (rows->size() != n) return false;
    for (const Quad& q : *rows)
      if (!std::isfinite(q.x) || !std::isfinite(q.y) || !std::isfinite(q.z)) return false;
  }
  // Radii and masses enter the search of neighbours.
  for (std::size_t i = 0; i < n; ++i)
    if (!(p.position[i].w > 0 && p.velocity[i].w > 0 && p.acceleration[i].w > 0) || !std::isfinite(p.position[i].w) || !std::isfinite(p.velocity[i].w)) return false;
  return p.material.size() == n && p.species.size() == n && p.id.size() == n && static_cast<std::size_t>(p.owned) == n && all_below(p.material, s.materials.size()) &&
         all_below(p.species, std::max<std::size_t>(1, s.species.size())) && each_once(p.id) && either(p.orientation, extent.orientations, n) && either(p.shape, extent.shapes, n) &&
         either(p.momentum, extent.shapes, n) && either(p.inertia, extent.shapes, n) && all_below(p.shape, std::max<std::size_t>(1, s.shapes.size()));
}

bool sound_bonds(const Simulation& s, const Extent& extent) {
  const Bonds& bonds = s.bonds;
  return bonds.list.size() == extent.bonds && bonds.failures.size() <= extent.bonds &&
         std::all_of(bonds.list.begin(), bonds.list.end(),
                     [&](const Bond& bond) { return below(bond.first, extent.particles) && below(bond.second, extent.particles) && below(bond.material, bonds.materials.size()); }) &&
         std::all_of(bonds.failures.begin(), bonds.failures.end(), [&](const BondFailure& failure) { return below(failure.bond, extent.bonds); });
}

// Rows that the block names by offsets: its own, its halo, and two idle ones.
bool sound_offset(const ContactBlock& block, Index offset) {
  return offset % 4 == 0 && below(offset / 4, static_cast<std::size_t>(block.size()) + block.halo.size() + 2);
}

bool sound_list(const ContactBlock& block, const CandidateList& list) {
  const std::size_t n = list.first.size();
  if (list.count < 0 || list.second.size() != n || list.slot.size() != n || n < static_cast<std::size_t>(list.count)) return false;
  if (n > 0 && n < static_cast<std::size_t>(list.count) + list_padding) return false;
  if (!list.overlap_at_rest.empty() && list.overlap_at_rest.size() < static_cast<std::size_t>(list.count)) return false;
  if (!list.guess.empty() && list.guess.size() < static_cast<std::size_t>(list.count)) return false;
  for (std::size_t k = 0; k < n; ++k)
    if (!sound_offset(block, list.first[k]) || !sound_offset(block, list.second[k]) || !below_or_none(list.slot[k], block.sliding.size())) return false;
  return true;
}

bool sound_walls(const Simulation& s, const ContactBlock& block) {
  if (block.wall_normals.size() != block.wall_slots.size()) return false;
  for (const Index slot : block.wall_slots)
    if (!below(slot, block.sliding.size())) return false;
  for (const WallCandidate& c : block.wall_candidates) {
    if (c.particle < block.first || c.particle >= block.last || !below(c.wall, s.walls.size())) return false;
    if (c.touches < 0 || (c.touches > 0 && (c.first_slot < 0 || static_cast<std::size_t>(c.first_slot) + static_cast<std::size_t>(c.touches) > block.wall_slots.size()))) return false;
    const Mesh* mesh = std::get_if<Mesh>(&s.walls[static_cast<std::size_t>(c.wall)].surface);
    if (mesh == nullptr) continue;
    if (c.first_triangle < 0 || c.last_triangle < c.first_triangle || static_cast<std::size_t>(c.last_triangle) > block.triangles.size() || c.watched > c.last_triangle - c.first_triangle) return false;
    for (Index k = c.first_triangle; k < c.last_triangle; ++k)
      if (!below(block.triangles[static_cast<std::size_t>(k)], mesh->facets.size())) return false;
  }
  return true;
}

bool sound_block_bonds(const Simulation& s, const ContactBlock& block) {
  if (block.bonds.count < 0 || static_cast<std::size_t>(block.bonds.count) > block.bonds.batches.size() * bonds_per_batch) return false;
  for (const BondBatch& batch : block.bonds.batches)
    for (int lane = 0; lane < bonds_per_batch; ++lane)
      if (!below_or_none(batch.bond[lane], s.bonds.list.size()) || !sound_offset(block, batch.first[lane]) || !sound_offset(block, batch.second[lane])) return false;
  return true;
}

bool sound_block(const Simulation& s, const ContactBlock& block, const Extent& extent) {
  const std::size_t slots = block.sliding.size(), kinds = s.pair_laws.size();
  const bool flags = block.records == extent.records && block.rolls == extent.rolls && block.remembers == extent.remembers && block.shapes == extent.others;
  const bool memory = slots >= 1 && either(block.rolling, block.rolls, slots) && either(block.effects, block.remembers, 2 * slots) && either(block.shaped, block.shapes, shaped_rows * slots) &&
                      either(block.record, block.records, slots);
  if (!flags || !memory || (block.candidates.size() != kinds && block.candidates.size() != 2 * kinds)) return false;
  for (const Index slot : block.free_slots)
    if (slot < 1 || !below(slot, slots)) return false;
  for (const HaloRow& row : block.halo)
    if (!below(row.row, extent.particles) || !below(row.image, 27)) return false;
  return std::all_of(block.candidates.begin(), block.candidates.end(), [&](const CandidateList& list) { return sound_list(block, list); }) && sound_walls(s, block) && sound_block_bonds(s, block);
}

bool sound_contacts(const Simulation& s, const Extent& extent) {
  const Contacts& c = s.contacts;
  const auto n = static_cast<Index>(extent.particles);
  if (c.block_size < 1 || c.records != extent.records || c.rolls != extent.rolls || c.remembers != extent.remembers || c.shapes != extent.others) return false;
  if (!(c.skin >= 0) || !(c.wall_skin >= 0) || !std::isfinite(c.skin) || !std::isfinite(c.wall_skin) || c.wall_sums.size() > s.walls.size()) return false;
  // The blocks part the rows between them.
  const auto size = static_cast<std::int64_t>(c.block_size);
  for (std::size_t b = 0; b < c.blocks.size(); ++b) {
    const ContactBlock& block = c.blocks[b];
    const auto first = std::min<std::int64_t>(n, static_cast<std::int64_t>(b) * size), last = std::min<std::int64_t>(n, first + size);
    if (block.first != first || block.last != last || !sound_block(s, block, extent)) return false;
  }
  return (c.blocks.empty() && n == 0) || static_cast<std::int64_t>(c.blocks.size()) * size >= n;
}

}  // namespace

Extent::Extent(const Simulation& started)
    : particles(started.particles.position.size()),
      bonds(started.bonds.list.size()),
      orientations(!started.particles.orientation.empty()),
      shapes(!started.particles.shape.empty()),
      records(started.contacts.records),
      rolls(started.contacts.rolls),
      remembers(started.contacts.remembers),
      others(started.contacts.shapes),
      time_step(started.clock.time_step) {}

bool sound(const Simulation& read, const Extent& extent) {
  const Clock& clock = read.clock;
  return clock.step >= 0 && clock.time_step == extent.time_step && std::isfinite(clock.origin) && sound_particles(read, extent) && sound_bonds(read, extent) && sound_contacts(read, extent);
}

}  // namespace quern
