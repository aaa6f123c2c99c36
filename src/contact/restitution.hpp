// The restitution that a head-on collision measures, and the damping that gives the restitution asked for.
#pragma once
#include "src/contact/laws.hpp"

namespace quern {

struct HeadOnCollision {
  double restitution;    // [-]
  double duration;       // first touch to parting [s]
  double peak_force;     // [N]
  double peak_overlap;   // [m]
  double loss;           // [J]
  double damping_rate;   // greatest c/m* on the way in: how fast the dashpot alone would stop the approach [1/s]
};

// Integrates one central collision of effective mass m* [kg] and radius R* [m] at approach speed v [m/s] through the law
// itself (RK4, about a thousand steps to the greatest overlap). The collision ends when the force ends.
HeadOnCollision collide_head_on(const ContactLaw& law, double effective_radius, double effective_mass, double speed);

// The same with the pair's effects, in steps as the engine takes them; ends where the bodies part. Bodies that stay together have the
// restitution they have at the end, and as duration twice the time to the greatest overlap.
HeadOnCollision collide_head_on(const PairLaw& pair, double effective_radius, double effective_mass, double speed);

// β for which the linear law (Schwager & Pöschel 2007) or Hertz–Mindlin measures restitution e in (0, 1].
double linear_damping_ratio(double restitution);
double hertz_damping_ratio(double restitution);

// γ [Pa s] for which the Deresiewicz law measures restitution e at this one speed (elsewhere e falls with speed).
double deresiewicz_damping_modulus(double effective_young, double restitution, double effective_radius, double effective_mass, double speed);

}  // namespace quern
