// What a pair of materials has beyond its law: effects that a case switches on (docs/effects.md). A pair without any takes no notice.
#pragma once
#include <algorithm>
#include "src/contact/effects/adhesion.hpp"
#include "src/contact/effects/force_table.hpp"
#include "src/contact/effects/liquid_bridge.hpp"
#include "src/contact/effects/lubrication.hpp"
#include "src/contact/effects/plastic.hpp"
#include "src/contact/effects/speed_restitution.hpp"
#include "src/contact/effects/stiffening.hpp"
#include "src/contact/effects/torsion.hpp"

namespace quern {

struct Extras {
  double tangential_compliance = 1;  // κ; 0: rigid
  SpeedRestitution restitution;
  double viscoelastic_time = 0;      // A in F = −A (dF_e/dδ) v_n [s] (Kuwabara & Kono 1987; Brilliantov et al. 1996)
  Stiffening stiffening;
  Plastic plastic;
  ForceTable table;
  Adhesion adhesion;
  double wave_admittance = 0;        // Y = 1/(ρcA) of a rod behind the contact [s/kg]: its end moves with u̇ = Y F (S0 eq. 11, derived anew)
  Torsion torsion;
  Lubrication lubrication;
  LiquidBridge bridge;

  bool any() const {
    return tangential_compliance != 1 || restitution.exponent != 0 || viscoelastic_time > 0 || stiffening.on() || stiffening.powder_layers > 0 ||
           plastic.on() || table.on() || adhesion.work > 0 || wave_admittance > 0 || torsion.coefficient > 0 || lubrication.viscosity > 0 || bridge.volume > 0;
  }
  // How far beyond touch some effect acts, between bodies of R* within these bounds [m].
  double reach(double smallest_radius, double largest_radius) const {
    double most = 0;
    if (adhesion.work > 0) most = adhesion.reach(largest_radius);
    if (bridge.volume > 0) most = std::max(most, bridge.reach(smallest_radius));
    if (lubrication.viscosity > 0) most = std::max(most, lubrication.thickness);
    return (1 + 1e-9) * most;
  }
};

// What a contact with effects remembers from step to step: two rows of the block's memory.
template <class T>
struct Remembered {
  T touching;   // scale of the law's dashpot since first touch; 0: the bodies do not touch
  T greatest;   // overlap so far [m]
  T rod_end;    // displacement of the rod's end, half a step ahead [m]
  T age;        // time since first touch [s]; −1: a bridge of liquid holds bodies that have parted
  T energy;     // stored along the normal at the last step [J]
  T force;      // along the normal then [N]
  T velocity;   // v_n then [m/s]
  T torsion;    // moment about the normal then [N m]
};

}  // namespace quern
