#include "src/contact/contact_block.hpp"

namespace quern {

void ActiveList::grow() {
  const std::size_t size = first.size() < 64 ? 128 : first.size() * 2;
  first.resize(size);
  second.resize(size);
  slot.resize(size);
}

Index ContactBlock::take_slot() {
  if (free_slots.empty()) {
    memory.emplace_back();
    if (records) record.emplace_back();
    return static_cast<Index>(memory.size()) - 1;
  }
  const Index s = free_slots.back();
  free_slots.pop_back();
  memory[static_cast<std::size_t>(s)] = {};
  if (records) record[static_cast<std::size_t>(s)] = {};
  return s;
}

void ContactBlock::release_slot(Index s) { free_slots.push_back(s); }

void ContactBlock::push_remote(std::size_t block, const Remote& r) { remote[block].push_back(r); }

}  // namespace quern
