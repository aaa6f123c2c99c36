// Changes of a law's loading curve F_e = C δ^r: a power more, a part that grows with the overlap, and powder between the bodies.
//   F_e → F_e (δ/δ₁)^p (1 + h δ);  powder: F_e → F_e (1 + n)^(−r), c → c (1 + n)
// Powder (S0 fig. 6: stiffness falls and damping rises with the number n of layers). Derived: n layers and the bodies are n + 1 like
// contacts in series, each of which takes the (n + 1)th part of the overlap. Assumed: the dashpot grows in proportion to n + 1.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Stiffening {
  double hardening = 0;          // h [1/m]
  double power_more = 0;         // p [-]
  double reference_overlap = 1;  // δ₁ [m]
  double powder_layers = 0;      // n [-]

  bool on() const { return hardening != 0 || power_more != 0; }
  double damping_scale() const { return 1 + powder_layers; }

  // `exponent`: r. `part` holds the law's curve at `overlap` and leaves with the changed one.
  template <class T>
  QUERN_INLINE void operator()(const T& overlap, double exponent, NormalPart<T>& part) const {
    if (powder_layers > 0) {
      const double softer = std::pow(1 + powder_layers, -exponent);
      part.elastic = T(softer) * part.elastic;
      part.stiffness = T(softer) * part.stiffness;
      part.energy = T(softer) * part.energy;
    }
    if (!on()) return;
    const double raised = exponent + power_more;
    const T plain = power_more == 0 ? part.elastic : part.elastic * power(overlap * T(1 / reference_overlap), power_more);
    const T more = T(hardening) * overlap, factor = T(1.0) + more;
    part.elastic = plain * factor;
    part.stiffness = T(raised) * plain / greater(overlap, T(1e-300)) * factor + T(hardening) * plain;
    part.energy = plain * overlap * (T(1 / (raised + 1)) + more * T(1 / (raised + 2)));
  }
};

}  // namespace quern
