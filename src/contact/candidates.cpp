#include "src/contact/candidates.hpp"
#include <algorithm>
#include <numeric>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// Places of the halo by particle and image: a hash table with open addresses.
class HaloPlaces {
 public:
  void clear(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    if (size > slots_.size()) slots_.resize(size);
    std::fill(slots_.begin(), slots_.end(), Slot{{-1, 0}, 0});
    used_ = 0;
  }
  // The place of the entry in the halo, which grows by it if it is new.
  Index place(const HaloRow& entry, std::vector<HaloRow>& halo) {
    if (2 * used_ >= slots_.size()) grow();
    Slot& slot = find(entry);
    if (slot.entry.row < 0) {
      slot = {entry, static_cast<Index>(halo.size())};
      halo.push_back(entry);
      ++used_;
    }
    return slot.place;
  }

 private:
  struct Slot {
    HaloRow entry;
    Index place;
  };
  Slot& find(const HaloRow& entry) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t k = (at(entry.row) * 0x9e3779b97f4a7c15ull >> 32 ^ at(entry.image)) & mask;
    while (slots_[k].entry.row >= 0 && (slots_[k].entry.row != entry.row || slots_[k].entry.image != entry.image)) k = (k + 1) & mask;
    return slots_[k];
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size(), Slot{{-1, 0}, 0});
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.entry.row >= 0) find(slot.entry) = slot;
  }
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

// Orders the halo by block, otherwise as found; returns the new place of each entry.
std::vector<Index> group_by_block(std::vector<HaloRow>& halo, Index block_size) {
  std::vector<Index> blocks;  // that occur, ascending: few
  std::vector<Index> block(halo.size());
  for (std::size_t k = 0; k < halo.size(); ++k) {
    block[k] = halo[k].row / block_size;
    if (k == 0 || block[k] != block[k - 1])
      if (const auto place = std::lower_bound(blocks.begin(), blocks.end(), block[k]); place == blocks.end() || *place != block[k])
        blocks.insert(place, block[k]);
  }
  std::vector<Index> rank(halo.size()), next(blocks.size() + 1, 0);
  for (std::size_t k = 0; k < halo.size(); ++k) {
    rank[k] = k > 0 && block[k] == block[k - 1] ? rank[k - 1]
                                                : static_cast<Index>(std::lower_bound(blocks.begin(), blocks.end(), block[k]) - blocks.begin());
    ++next[at(rank[k]) + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<HaloRow> grouped(halo.size());
  std::vector<Index> place(halo.size());
  for (std::size_t k = 0; k < halo.size(); ++k) {
    place[k] = next[at(rank[k])]++;
    grouped[at(place[k])] = halo[k];
  }
  halo = std::move(grouped);
  return place;
}

// The image of `other` that is nearest to a place.
Index nearest_image(const Domain& domain, const Quad& here, const Quad& other) {
  const double apart[3] = {here.x - other.x, here.y - other.y, here.z - other.z};
  Index image = Domain::itself;
  for (int axis = 0, weight = 1; axis < 3; ++axis, weight *= 3)
    image += weight * static_cast<Index>(std::nearbyint(apart[axis] * domain.inverse(axis)));
  return image;
}

// Lists a block's bonds; a grain in the halo is named by its place there before it is grouped by block.
void fill_bonds(const SearchRequest& request, const std::vector<BondRow>& bonds, HaloPlaces& places, ContactBlock& block) {
  block.bonds.clear();
  const Particles& particles = *request.particles;
  for (const BondRow& bond : bonds) {
    if (!bond.intact) continue;
    const Index image = nearest_image(*request.domain, particles.position[at(bond.low)], particles.position[at(bond.high)]);
    const bool mine = bond.high < block.last && image == Domain::itself;
    const Index low = 4 * (bond.low - block.first);
    const Index high = 4 * (mine ? bond.high - block.first : block.size() + places.place({bond.high, image}, block.halo));
    block.bonds.push(request.bonds->list[at(bond.bond)], bond.bond, bond.first_is_low ? low : high, bond.first_is_low ? high : low);
  }
}

// Gives the grains of a block's bonds that lay in the old halo their places in the new one. In a domain without images only.
void place_bonds(const std::vector<HaloRow>& old_halo, HaloPlaces& places, ContactBlock& block) {
  const Index own = block.size(), idle = own + static_cast<Index>(old_halo.size());
  for (BondBatch& batch : block.bonds.batches)
    for (Index* offsets : {batch.first, batch.second})
      for (int lane = 0; lane < bonds_per_batch; ++lane)
        if (const Index local = offsets[lane] / 4; local >= own && local < idle)
          offsets[lane] = 4 * (own + places.place(old_halo[at(local - own)], block.halo));
}

// Scratch memory that outlives a call.
struct Scratch {
  std::vector<HaloRow> old_halo;
  Found found;
  HaloPlaces places;
};

}  // namespace

std::vector<KeptContact> kept_contacts(const ContactBlock& block) {
  std::vector<KeptContact> kept;
  if (block.shapes) {
    for (const CandidateList& list : block.candidates)
      for (std::size_t k = 0; k < static_cast<std::size_t>(list.count); ++k)
        if (list.slot[k] >= 0 || (!list.guess.empty() && list.guess[k].w > 0))
          kept.push_back({block.row_of(list.first[k]), block.row_of(list.second[k]), list.slot[k], list.guess.empty() ? Quad{} : list.guess[k]});
  } else {
    for_touching_pairs(block, [&](Index i, Index j, Index slot) { kept.push_back({i, j, slot}); });
  }
  if (block.candidates.size() > 1) std::stable_sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return kept;
}

void find_candidates(const SearchRequest& request, const std::vector<KeptContact>& kept, const std::vector<BondRow>& bonds, ContactBlock& block) {
  thread_local Scratch scratch;
  const Particles& particles = *request.particles;
  const Index own = block.size();
  scratch.places.clear(block.halo.size());
  scratch.old_halo.swap(block.halo);
  block.halo.clear();
  for (CandidateList& list : block.candidates) {
    for (std::vector<Index>* indices : {&list.first, &list.second, &list.slot}) indices->clear();
    list.overlap_at_rest.clear();
    list.guess.clear();
    list.count = 0;
  }
  const std::size_t pair_kinds = block.walls.size();  // lists beyond these are of pairs with an overlap at rest, or of other shapes
  std::size_t next = 0;       // of `kept`
  std::size_t next_bond = 0;  // of `bonds`
  for (Index i = block.first; i < block.last; ++i) {
    const Quad here = particles.position[at(i)];
    scratch.found.count = 0;
    for (const CellGrid& grid : *request.grids) request.kernels->find_near(*request.domain, grid, here, request.skin, i, scratch.found);
    const std::size_t inherit = next;
    while (next < kept.size() && kept[next].first == i) ++next;
    const std::size_t first_bond = next_bond;
    while (next_bond < bonds.size() && bonds[next_bond].low == i) ++next_bond;
    const std::uint8_t* kinds = request.pair_kind + particles.material[at(i)] * request.material_count;
    for (Index k = 0; k < scratch.found.count; ++k) {
      const HaloRow other = {scratch.found.row[at(k)], scratch.found.image[at(k)]};
      Index slot = -1;
      Quad guess;
      for (std::size_t old = inherit; old < next; ++old)
        if (kept[old].second == other.row) slot = kept[old].slot, guess = kept[old].guess;
      const bool mine = other.row < block.last && other.image == Domain::itself;
      const Index local = mine ? other.row - block.first : own + scratch.places.place(other, block.halo);
      std::size_t kind = kinds[particles.material[at(other.row)]];
      const BondRow* rests = nullptr;
      for (std::size_t b = first_bond; b < next_bond; ++b)
        if (bonds[b].high == other.row && bonds[b].overlap > 0) rests = &bonds[b];
      if (rests) kind += pair_kinds;
      const bool shaped = block.shapes && (particles.shape[at(i)] | particles.shape[at(other.row)]) != 0;
      if (shaped) kind += pair_kinds;
      CandidateList& list = block.candidates[kind];
      if (shaped) list.guess.push_back(guess);
      if (rests) list.overlap_at_rest.push_back(rests->overlap);
      list.first.push_back(4 * (i - block.first));
      list.second.push_back(4 * local);
      list.slot.push_back(slot);
    }
  }
  if (request.fills_bonds)
    fill_bonds(request, bonds, scratch.places, block);
  else
    place_bonds(scratch.old_halo, scratch.places, block);
  const std::vector<Index> place = group_by_block(block.halo, request.block_size);
  for (CandidateList& list : block.candidates) {
    list.count = static_cast<Index>(list.first.size());
    for (Index& offset : list.second)
      if (offset >= 4 * own) offset = 4 * (own + place[at(offset / 4 - own)]);
    list.first.resize(list.first.size() + list_padding, 0);
    list.second.resize(list.second.size() + list_padding, 0);
    list.slot.resize(list.slot.size() + list_padding, -1);
    if (!list.overlap_at_rest.empty()) list.overlap_at_rest.resize(list.slot.size(), 0);
    if (!list.guess.empty()) list.guess.resize(list.slot.size());
  }
  for (BondBatch& batch : block.bonds.batches)
    for (Index* offsets : {batch.first, batch.second})
      for (int lane = 0; lane < bonds_per_batch; ++lane)
        if (offsets[lane] >= 4 * own && offsets[lane] < 4 * (own + static_cast<Index>(block.halo.size()))) offsets[lane] = 4 * (own + place[at(offsets[lane] / 4 - own)]);
  block.bonds.close(4 * (own + static_cast<Index>(block.halo.size())));
  block.load.resize(at(own) + block.halo.size() + 2);
}

void link_halos(std::vector<ContactBlock>& blocks, Index block_size) {
  for (ContactBlock& block : blocks) block.incoming.clear(), block.outgoing.clear();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::vector<HaloRow>& halo = blocks[b].halo;
    for (std::size_t from = 0, to; from < halo.size(); from = to) {
      const Index target = halo[from].row / block_size;
      for (to = from; to < halo.size() && halo[to].row / block_size == target;) ++to;
      blocks[at(target)].incoming.push_back({static_cast<Index>(b), static_cast<Index>(from), static_cast<Index>(to)});
      blocks[b].outgoing.push_back(target);
    }
  }
}

}  // namespace quern
