#include "src/contact/contact_block.hpp"
#include <algorithm>
#include "src/contact/shape_meeting.hpp"

namespace quern {

Index ContactBlock::take_slot() {
  if (free_slots.empty()) {
    sliding.emplace_back();
    if (rolls) rolling.emplace_back();
    if (remembers) effects.resize(2 * sliding.size());
    if (shapes) shaped.resize(shaped_rows * sliding.size());
    if (records) record.emplace_back();
    return static_cast<Index>(sliding.size()) - 1;
  }
  const Index s = free_slots.back();
  free_slots.pop_back();
  const auto at = static_cast<std::size_t>(s);
  sliding[at] = {};
  if (rolls) rolling[at] = {};
  if (remembers) effects[2 * at] = effects[2 * at + 1] = {};
  if (shapes) std::fill_n(&shaped[shaped_rows * at], shaped_rows, Quad{});
  if (records) record[at] = {};
  return s;
}

void ContactBlock::release_slot(Index s) { free_slots.push_back(s); }

}  // namespace quern
