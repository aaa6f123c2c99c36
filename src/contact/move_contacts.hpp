// Contacts whose particles changed rows or blocks.
#pragma once
#include "src/contact/candidates.hpp"

namespace quern {

// Hands each fresh block the memory of its contacts, packed in the order of rows, and returns its touching pairs. The particle of
// row r is now in row new_row[r]. A pair whose first and second changed places turns its springs round.
std::vector<std::vector<KeptContact>> move_contacts(const std::vector<ContactBlock>& old_blocks, std::vector<ContactBlock>& fresh, Index block_size,
                                                    const std::vector<Index>& new_row);

}  // namespace quern
