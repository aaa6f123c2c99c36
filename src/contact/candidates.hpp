// The candidate pairs of one block: who may touch whom before the next search.
#pragma once
#include "src/contact/cell_grid.hpp"
#include "src/contact/kernels.hpp"

namespace quern {

// A pair that keeps its memory through a search, or a plane between the two (see CandidateList::guess).
struct KeptContact {
  Index first, second, slot;  // rows of the particle arrays, first < second; slot of the memory, −1: not touching
  Quad guess = {};
};

// The touching pairs of a block, and those of shapes between which a plane is known, in ascending order of `first`.
std::vector<KeptContact> kept_contacts(const ContactBlock& block);

struct SearchRequest {
  const Particles* particles;
  const Domain* domain;
  const std::vector<CellGrid>* grids;
  const std::uint8_t* pair_kind;  // as in StepContext
  Index material_count, block_size;
  double skin;                    // [m]
  const Kernels* kernels;
  const Bonds* bonds;
  bool fills_bonds;               // whether the blocks' bonds are listed anew; else only their places in the halo are
};

// Fills block.candidates and block.halo with all pairs nearer than touching by the skin; `kept` pairs take their slots along. The
// block's bonds go into block.bonds, and their grains into the halo however far they are.
void find_candidates(const SearchRequest& request, const std::vector<KeptContact>& kept, const std::vector<BondRow>& bonds, ContactBlock& block);

// Tells each block which halos hold particles of it, and where its own halo lies.
void link_halos(std::vector<ContactBlock>& blocks, Index block_size);

}  // namespace quern
