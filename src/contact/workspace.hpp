// What one thread works on: a copy of a block's particles and of its halo, in one piece, small enough for the cache.
#pragma once
#include "src/contact/contact_block.hpp"

namespace quern {

struct Workspace {
  // Rows: the block's own particles, its halo, then two at rest for the idle lanes of a SIMD batch.
  std::vector<Quad> position, velocity, spin;  // as in Particles; images are where the block sees them
  std::vector<Quad> orientation;               // empty unless particles have one
  std::vector<Index> first, second, slot;      // pairs of one kind that touch now, padded
  std::vector<double> overlap_at_rest;         // of those pairs; only where the list of candidates has it
  Index active = 0;                            // how many

  // Makes room for a block.
  void fit(const ContactBlock& block, bool oriented);
};

}  // namespace quern
