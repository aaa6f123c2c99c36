// Squeeze of a film between two bodies (Reynolds): F = −6π η R*² v_n / max(h, cut-off), h the gap, below the film's thickness.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Lubrication {
  double viscosity = 0;  // η [Pa s]; 0: off
  double thickness = 0;  // [m]
  double cutoff = 0;     // [m]

  // The dashpot [kg/s].
  template <class T>
  QUERN_INLINE T operator()(const T& gap, const T& radius) const {
    const T damping = T(6 * 3.14159265358979323846 * viscosity) * radius * radius / greater(gap, T(cutoff));
    return select(gap < T(thickness), damping, T(0.0));
  }
};

}  // namespace quern
