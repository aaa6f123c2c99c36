#include "src/contact/contacts.hpp"
#include <algorithm>
#include "src/contact/cell_grid.hpp"

namespace quern {
namespace {

constexpr Index particles_per_block = 1024, most_blocks = 64;
constexpr std::int64_t searches_per_sort = 32;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Triple<double> wrap_positions(Particles& particles, const Domain& domain) {
  Triple<double> moved{0, 0, 0};
  if (!domain.periodic()) return moved;
  for (Index i = 0; i < particles.owned; ++i) {
    Quad& q = particles.position[at(i)];
    const Triple<double> before = xyz(q);
    const auto wrap = [&](double x, int axis) {
      const double period = domain.period[axis];
      if (period == 0) return x;
      const double inside = x - period * std::floor((x - domain.lower[axis]) / period);
      return inside < domain.lower[axis] + period ? inside : inside - period;
    };
    q = {wrap(q.x, 0), wrap(q.y, 1), wrap(q.z, 2), q.w};
    moved = moved + particles.mass(i) * (xyz(q) - before);
  }
  return moved;
}

// The touching pairs that a block's particles had, by row: what the new candidates inherit.
struct Heirloom {
  std::vector<Index> start, second, slot;
};

Heirloom keep_rows(const ContactBlock& block) {
  Heirloom kept;
  kept.start.push_back(0);
  for (Index i = block.first; i < block.last; ++i) {
    for (Index k = block.row_start[at(i - block.first)]; k < block.row_start[at(i - block.first) + 1]; ++k)
      if (block.slot[at(k)] >= 0) kept.second.push_back(block.neighbour[at(k)]), kept.slot.push_back(block.slot[at(k)]);
    kept.start.push_back(static_cast<Index>(kept.second.size()));
  }
  return kept;
}

// After the particles changed rows or blocks: hands each new block the memory of its contacts, packed in the order of rows.
// A pair whose first and second changed places turns its springs round.
std::vector<Heirloom> move_contacts(Contacts& contacts, std::vector<ContactBlock>& fresh, const std::vector<Index>& new_row) {
  struct Moved {
    Index first, second;
    bool turned;
    ContactMemory memory;
    CollisionRecord record;
  };
  std::vector<std::vector<Moved>> by_block(fresh.size());
  const auto block_of = [&](Index row) { return at(row / contacts.block_size); };
  const auto record_of = [&](const ContactBlock& b, Index slot) { return contacts.records ? b.record[at(slot)] : CollisionRecord{}; };
  for (const ContactBlock& old : contacts.blocks) {
    for (Index i = old.first; i < old.last; ++i)
      for (Index k = old.row_start[at(i - old.first)]; k < old.row_start[at(i - old.first) + 1]; ++k) {
        const Index slot = old.slot[at(k)];
        if (slot < 0) continue;
        const Index a = new_row[at(i)], b = new_row[at(old.neighbour[at(k)])];
        by_block[block_of(std::min(a, b))].push_back({std::min(a, b), std::max(a, b), a > b, old.memory[at(slot)], record_of(old, slot)});
      }
    for (const WallCandidate& candidate : old.wall_candidates) {
      if (candidate.touches == 0) continue;
      WallCandidate moved = candidate;
      moved.particle = new_row[at(candidate.particle)];
      ContactBlock& target = fresh[block_of(moved.particle)];
      moved.first_slot = static_cast<Index>(target.wall_slots.size());
      for (Index k = 0; k < candidate.touches; ++k) {
        const Index slot = old.wall_slots[at(candidate.first_slot + k)], taken = target.take_slot();
        target.memory[at(taken)] = old.memory[at(slot)];
        if (contacts.records) target.record[at(taken)] = old.record[at(slot)];
        target.wall_slots.push_back(taken);
        target.wall_normals.push_back(old.wall_normals[at(candidate.first_slot + k)]);
      }
      target.wall_candidates.push_back(moved);
    }
  }
  std::vector<Heirloom> kept(fresh.size());
  for (std::size_t b = 0; b < fresh.size(); ++b) {
    ContactBlock& block = fresh[b];
    std::sort(block.wall_candidates.begin(), block.wall_candidates.end(),
              [](const WallCandidate& x, const WallCandidate& y) { return x.particle != y.particle ? x.particle < y.particle : x.wall < y.wall; });
    std::vector<Moved>& moved = by_block[b];
    std::sort(moved.begin(), moved.end(), [](const Moved& x, const Moved& y) { return x.first != y.first ? x.first < y.first : x.second < y.second; });
    std::size_t next = 0;
    kept[b].start.push_back(0);
    for (Index i = block.first; i < block.last; ++i) {
      for (; next < moved.size() && moved[next].first == i; ++next) {
        const Index slot = block.take_slot();
        ContactMemory memory = moved[next].memory;
        if (moved[next].turned) {
          memory.sliding = {-memory.sliding.x, -memory.sliding.y, -memory.sliding.z, memory.sliding.w};
          memory.rolling = {-memory.rolling.x, -memory.rolling.y, -memory.rolling.z, memory.rolling.w};
        }
        block.memory[at(slot)] = memory;
        if (contacts.records) block.record[at(slot)] = moved[next].record;
        kept[b].second.push_back(moved[next].second);
        kept[b].slot.push_back(slot);
      }
      kept[b].start.push_back(static_cast<Index>(kept[b].second.size()));
    }
  }
  return kept;
}

std::vector<ContactBlock> empty_blocks(const Contacts& contacts, Index particles, std::size_t pair_kinds, std::size_t walls) {
  const Index count = std::max<Index>(1, (particles + contacts.block_size - 1) / contacts.block_size);
  std::vector<ContactBlock> blocks(at(count));
  for (Index b = 0; b < count; ++b) {
    ContactBlock& block = blocks[at(b)];
    block.first = std::min(particles, b * contacts.block_size);
    block.last = std::min(particles, (b + 1) * contacts.block_size);
    block.records = contacts.records;
    block.memory.emplace_back();
    if (contacts.records) block.record.emplace_back();
    block.row_start.assign(at(block.last - block.first) + 1, 0);
    block.pairs.resize(pair_kinds);
    block.walls.resize(pair_kinds);
    block.remote.resize(at(count));
    block.wall_sums.resize(walls);
  }
  return blocks;
}

void find_candidates(const Particles& particles, const Domain& domain, const std::vector<CellGrid>& grids, double skin, const Heirloom& kept,
                     ContactBlock& block) {
  block.neighbour.clear();
  block.slot.clear();
  const bool periodic = domain.periodic();
  std::vector<Index> found;
  for (Index i = block.first; i < block.last; ++i) {
    const Quad here = particles.position[at(i)];
    std::size_t count = 0;
    for (const CellGrid& grid : grids)
      for_runs_near(grid, here, here.w + grid.largest_radius + skin, [&](Index from, Index to) {
        if (found.size() < count + at(to - from)) found.resize(2 * (count + at(to - from)));
        for (Index k = from; k < to; ++k) {
          const Quad& other = grid.position[at(k)];
          Triple<double> apart = {here.x - other.x, here.y - other.y, here.z - other.z};
          if (periodic) apart = domain.nearest(apart);
          const double reach = here.w + other.w + skin;
          found[count] = grid.row[at(k)];
          count += static_cast<std::size_t>((dot(apart, apart) < reach * reach) & (grid.row[at(k)] > i));
        }
      });
    std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count));
    const std::size_t row = at(i - block.first);
    Index inherit = kept.start.empty() ? 0 : kept.start[row];
    const Index end = kept.start.empty() ? 0 : kept.start[row + 1];
    for (std::size_t k = 0; k < count; ++k) {
      block.neighbour.push_back(found[k]);
      block.slot.push_back(inherit < end && kept.second[at(inherit)] == found[k] ? kept.slot[at(inherit++)] : -1);
    }
    block.row_start[row + 1] = static_cast<Index>(block.neighbour.size());
  }
  block.neighbour.resize(block.neighbour.size() + candidate_padding, 0);
  block.slot.resize(block.slot.size() + candidate_padding, -1);
}

// A skin serves best when a search lasts some ten to twenty steps: below, searching costs more; above, idle candidates do.
void adapt_skin(Contacts& contacts, const Particles& particles) {
  double smallest = 1e300;
  for (Index i = 0; i < particles.owned; ++i) smallest = std::min(smallest, particles.radius(i));
  if (contacts.skin == 0) {
    contacts.skin = 0.3 * smallest;
  } else if (contacts.steps_since_search < 10) {
    contacts.skin *= 1.2;
  } else if (contacts.steps_since_search > 20) {
    contacts.skin *= 0.9;
  }
  contacts.skin = std::clamp(contacts.skin, 0.05 * smallest, 1.0 * smallest);
}

}  // namespace

Triple<double> search_neighbours(Contacts& contacts, Particles& particles, const Domain& domain, std::size_t pair_kinds, std::size_t walls,
                                 ThreadTeam& team) {
  const Triple<double> moved = wrap_positions(particles, domain);
  if (particles.owned > 0) adapt_skin(contacts, particles);

  const Index wanted = std::clamp<Index>(particles.owned / particles_per_block, 1, most_blocks);
  const Index block_size = std::max<Index>(1, (particles.owned + wanted - 1) / wanted);
  const bool recut = contacts.blocks.empty() || contacts.blocks.back().last != particles.owned || block_size != contacts.block_size;
  const bool sorts = contacts.searches % searches_per_sort == 0;
  std::vector<Heirloom> kept(contacts.blocks.size());
  if (recut || sorts) {
    std::vector<Index> new_row(at(particles.size()));
    for (Index i = 0; i < particles.size(); ++i) new_row[at(i)] = i;
    if (sorts && particles.owned > 0) {
      double largest = 0;
      for (Index i = 0; i < particles.owned; ++i) largest = std::max(largest, particles.radius(i));
      const std::vector<Index> order = spatial_order(particles, 2 * largest);
      particles.reorder(order);
      for (Index row = 0; row < particles.size(); ++row) new_row[at(order[at(row)])] = row;
    }
    contacts.block_size = block_size;
    std::vector<ContactBlock> fresh = empty_blocks(contacts, particles.owned, pair_kinds, walls);
    kept = move_contacts(contacts, fresh, new_row);
    contacts.blocks = std::move(fresh);
  } else {
    team.run(static_cast<int>(contacts.blocks.size()), [&](int b) { kept[static_cast<std::size_t>(b)] = keep_rows(contacts.blocks[static_cast<std::size_t>(b)]); });
  }
  const std::vector<CellGrid> grids = make_grids(particles, domain, contacts.skin);
  team.run(static_cast<int>(contacts.blocks.size()), [&](int b) {
    const auto k = static_cast<std::size_t>(b);
    find_candidates(particles, domain, grids, contacts.skin, kept[k], contacts.blocks[k]);
  });
  contacts.travelled = contacts.wall_travelled = 0;
  contacts.steps_since_search = 0;
  ++contacts.searches;
  return moved;
}

}  // namespace quern
