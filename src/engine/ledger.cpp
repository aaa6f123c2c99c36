#include "src/engine/ledger.hpp"
#include <algorithm>

namespace quern {

double Ledger::closure() const {
  const double scale = std::max({throughput, dissipated(), exchanged});
  return scale > 0 ? gap() / scale : 0.0;
}

}  // namespace quern
