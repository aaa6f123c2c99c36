#include "src/engine/ledger.hpp"
#include <algorithm>

namespace quern {

double Ledger::closure() const {
  // What turns a particle without working on it, as the Magnus force does, leaves the rounding of its kinetic energy alone.
  const double scale = std::max({throughput, dissipated(), exchanged, 1e-6 * kinetic});
  return scale > 0 ? gap() / scale : 0.0;
}

}  // namespace quern
