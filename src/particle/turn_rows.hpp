// turn_shapes and set_spins (see turning.hpp) for one instruction set; all give the same bits.
#pragma once
#include "src/particle/particles.hpp"

namespace quern {

namespace portable {
void turn_shapes(Particles&, Index first, Index last, const Quad* before, double time_step);
void set_spins(Particles&, Index first, Index last);
}
namespace avx2 {
void turn_shapes(Particles&, Index first, Index last, const Quad* before, double time_step);
void set_spins(Particles&, Index first, Index last);
}
namespace avx512 {
void turn_shapes(Particles&, Index first, Index last, const Quad* before, double time_step);
void set_spins(Particles&, Index first, Index last);
}

}  // namespace quern
