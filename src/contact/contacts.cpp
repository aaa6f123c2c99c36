#include "src/contact/contacts.hpp"
#include <algorithm>
#include "src/contact/move_contacts.hpp"

namespace quern {
namespace {

constexpr Index most_per_block = 2048, least_per_block = 256, blocks_wanted = 16;
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
      if (period == 0 || (x >= domain.lower[axis] && x < domain.lower[axis] + period)) return x;
      const double inside = x - period * std::floor((x - domain.lower[axis]) / period);
      return inside < domain.lower[axis] + period ? inside : inside - period;
    };
    q = {wrap(q.x, 0), wrap(q.y, 1), wrap(q.z, 2), q.w};
    if (q.x != before.x || q.y != before.y || q.z != before.z) moved = moved + particles.mass(i) * (xyz(q) - before);
  }
  return moved;
}

std::vector<ContactBlock> empty_blocks(const Contacts& contacts, Index particles, std::size_t pair_kinds, std::size_t walls, bool two_lists) {
  const Index count = std::max<Index>(1, (particles + contacts.block_size - 1) / contacts.block_size);
  std::vector<ContactBlock> blocks(at(count));
  for (Index b = 0; b < count; ++b) {
    ContactBlock& block = blocks[at(b)];
    block.first = std::min(particles, b * contacts.block_size);
    block.last = std::min(particles, (b + 1) * contacts.block_size);
    block.records = contacts.records;
    block.rolls = contacts.rolls;
    block.remembers = contacts.remembers;
    block.shapes = contacts.shapes;
    block.take_slot();  // the scratch row
    block.candidates.resize(two_lists ? 2 * pair_kinds : pair_kinds);
    block.walls.resize(pair_kinds);
    if (block.shapes) block.shape_walls.resize(pair_kinds);
    block.wall_sums.resize(walls);
  }
  return blocks;
}

bool overlap_at_rest(const Bonds& bonds) {
  return std::any_of(bonds.list.begin(), bonds.list.end(), [](const Bond& bond) { return bond.overlap > 0; });
}

// Whether an eighth of the places in the blocks' lists of bonds is idle, the bonds there having failed.
bool many_failed(const Contacts& contacts) {
  std::size_t idle = 0, all = 0;
  for (const ContactBlock& block : contacts.blocks) {
    all += block.bonds.batches.size() * bonds_per_batch;
    for (const BondBatch& batch : block.bonds.batches) idle += static_cast<std::size_t>(std::count(batch.bond, batch.bond + bonds_per_batch, -1));
  }
  return 8 * idle > all;
}

// The skin at which a step is cheapest. A narrow one is soon travelled, and a search costs about as much as looking at
// `search_cost` candidates for each particle; a wide one lists candidates that never touch, as the cube of the reach.
void adapt_skin(Contacts& contacts, const Particles& particles) {
  constexpr double search_cost = 120, growth = 1.08;
  double smallest = 1e300, sum = 0;
  for (Index i = 0; i < particles.owned; ++i) smallest = std::min(smallest, particles.radius(i)), sum += particles.radius(i);
  if (contacts.skin == 0) {
    contacts.skin = contacts.wall_skin = 0.3 * smallest;
    return;
  }
  double candidates = 0;
  for (const ContactBlock& block : contacts.blocks)
    for (const CandidateList& list : block.candidates) candidates += list.count;
  const double per_particle = std::max(1.0, candidates / particles.owned), diameter = 2 * sum / particles.owned;
  // Motion by which the skin is used up, per step; what was measured last and what was thought before have equal weight.
  const double steps = static_cast<double>(std::max<std::int64_t>(1, contacts.steps_since_search));
  const double measured = 2 * contacts.travelled / steps;
  contacts.motion = contacts.motion == 0 ? measured : 0.5 * (contacts.motion + measured);
  const auto cost = [&](double skin) {
    const double reach = (diameter + skin) / (diameter + contacts.skin);
    return search_cost * std::min(1.0, contacts.motion / skin) + per_particle * reach * reach * reach;
  };
  double best = 0.05 * smallest;
  for (double skin = best; skin <= smallest; skin *= growth)
    if (cost(skin) < cost(best)) best = skin;
  contacts.skin = best;
  // Walls get what they need to last as long: a turning mesh uses up more, a wall at rest less.
  const double share = contacts.travelled > 0 ? contacts.wall_travelled / contacts.travelled : 1;
  contacts.wall_skin = 0.55 * best * std::clamp(1 + share, 1.0, 6.0);
}

}  // namespace

Triple<double> search_neighbours(Contacts& contacts, Particles& particles, Bonds& bonds, const Domain& domain, const PairKinds& kinds,
                                 std::size_t walls, const Kernels& kernels, ThreadTeam& team) {
  const Triple<double> moved = wrap_positions(particles, domain);
  if (particles.owned > 0) adapt_skin(contacts, particles);

  const Index wanted = std::max<Index>(1, particles.owned / std::clamp(particles.owned / blocks_wanted, least_per_block, most_per_block));
  const Index block_size = std::max<Index>(1, (particles.owned + wanted - 1) / wanted);
  const bool recut = contacts.blocks.empty() || contacts.blocks.back().last != particles.owned || block_size != contacts.block_size;
  const bool sorts = contacts.searches % searches_per_sort == 0;
  std::vector<std::vector<KeptContact>> kept(contacts.blocks.size());
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
    std::vector<ContactBlock> fresh = empty_blocks(contacts, particles.owned, kinds.count, walls, contacts.shapes || overlap_at_rest(bonds));
    kept = move_contacts(contacts.blocks, fresh, block_size, new_row);
    contacts.blocks = std::move(fresh);
  } else {
    team.run(static_cast<int>(kept.size()), [&](int b) { kept[static_cast<std::size_t>(b)] = kept_contacts(contacts.blocks[static_cast<std::size_t>(b)]); });
  }
  const std::vector<CellGrid> grids = make_grids(particles, domain, contacts.skin + contacts.reach, team);
  const bool fills_bonds = !bonds.empty() && (recut || sorts || domain.periodic() || many_failed(contacts));
  std::vector<std::vector<BondRow>> block_bonds(contacts.blocks.size());
  if (fills_bonds || overlap_at_rest(bonds))
    block_bonds = bonds_by_block(bonds, particles, domain, contacts.block_size, contacts.blocks.size());
  const SearchRequest request{&particles, &domain, &grids, kinds.of, kinds.materials, contacts.block_size, contacts.skin + contacts.reach, &kernels, &bonds, fills_bonds};
  team.run(static_cast<int>(contacts.blocks.size()), [&](int b) {
    const auto k = static_cast<std::size_t>(b);
    find_candidates(request, kept[k], block_bonds[k], contacts.blocks[k]);
  });
  link_halos(contacts.blocks, contacts.block_size);
  contacts.travelled = contacts.wall_travelled = 0;
  contacts.steps_since_search = 0;
  ++contacts.searches;
  return moved;
}

}  // namespace quern
