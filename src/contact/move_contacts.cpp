#include "src/contact/move_contacts.hpp"
#include <algorithm>
#include <utility>
#include "src/contact/shape_meeting.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// What a contact remembers, on its way from one block to another.
struct Memory {
  Quad sliding, rolling, effects[2], shaped[shaped_rows];
  CollisionRecord record;
};

Memory memory_of(const ContactBlock& block, Index slot) {
  Memory memory{block.sliding[at(slot)], {}, {}, {}, {}};
  if (block.rolls) memory.rolling = block.rolling[at(slot)];
  if (block.remembers) std::copy_n(&block.effects[2 * at(slot)], 2, memory.effects);
  if (block.shapes) std::copy_n(&block.shaped[shaped_rows * at(slot)], shaped_rows, memory.shaped);
  if (block.records) memory.record = block.record[at(slot)];
  return memory;
}

Index settle(ContactBlock& block, const Memory& memory) {
  const Index slot = block.take_slot();
  block.sliding[at(slot)] = memory.sliding;
  if (block.rolls) block.rolling[at(slot)] = memory.rolling;
  if (block.remembers) std::copy_n(memory.effects, 2, &block.effects[2 * at(slot)]);
  if (block.shapes) std::copy_n(memory.shaped, shaped_rows, &block.shaped[shaped_rows * at(slot)]);
  if (block.records) block.record[at(slot)] = memory.record;
  return slot;
}

Quad reversed(const Quad& spring) { return {-spring.x, -spring.y, -spring.z, spring.w}; }

struct MovedPair {
  Index first, second;
  Index old_block, slot;
  bool turned;
};

void move_wall_contacts(const ContactBlock& old, std::vector<ContactBlock>& fresh, Index block_size, const std::vector<Index>& new_row) {
  for (const WallCandidate& candidate : old.wall_candidates) {
    if (candidate.touches == 0) continue;
    WallCandidate moved = candidate;
    moved.particle = new_row[at(candidate.particle)];
    ContactBlock& target = fresh[at(moved.particle / block_size)];
    moved.first_slot = static_cast<Index>(target.wall_slots.size());
    for (Index k = 0; k < candidate.touches; ++k) {
      target.wall_slots.push_back(settle(target, memory_of(old, old.wall_slots[at(candidate.first_slot + k)])));
      target.wall_normals.push_back(old.wall_normals[at(candidate.first_slot + k)]);
    }
    target.wall_candidates.push_back(moved);
  }
}

}  // namespace

std::vector<std::vector<KeptContact>> move_contacts(const std::vector<ContactBlock>& old_blocks, std::vector<ContactBlock>& fresh, Index block_size,
                                                    const std::vector<Index>& new_row) {
  std::vector<std::vector<MovedPair>> by_block(fresh.size());
  for (std::size_t b = 0; b < old_blocks.size(); ++b) {
    for_touching_pairs(old_blocks[b], [&](Index i, Index j, Index slot) {
      const Index first = new_row[at(i)], second = new_row[at(j)];
      by_block[at(std::min(first, second) / block_size)].push_back(
          {std::min(first, second), std::max(first, second), static_cast<Index>(b), slot, first > second});
    });
    move_wall_contacts(old_blocks[b], fresh, block_size, new_row);
  }
  std::vector<std::vector<KeptContact>> kept(fresh.size());
  for (std::size_t b = 0; b < fresh.size(); ++b) {
    ContactBlock& block = fresh[b];
    std::sort(block.wall_candidates.begin(), block.wall_candidates.end(),
              [](const WallCandidate& x, const WallCandidate& y) { return x.particle != y.particle ? x.particle < y.particle : x.wall < y.wall; });
    std::sort(by_block[b].begin(), by_block[b].end(),
              [](const MovedPair& x, const MovedPair& y) { return x.first != y.first ? x.first < y.first : x.second < y.second; });
    for (const MovedPair& pair : by_block[b]) {
      Memory memory = memory_of(old_blocks[at(pair.old_block)], pair.slot);
      if (pair.turned) {
        memory.sliding = reversed(memory.sliding), memory.rolling = reversed(memory.rolling);
        memory.shaped[0] = reversed(memory.shaped[0]);
        std::swap(memory.shaped[1], memory.shaped[2]);
      }
      kept[b].push_back({pair.first, pair.second, settle(block, memory)});
    }
  }
  return kept;
}

}  // namespace quern
