// Equivalent linearization of the power law (physics: S0 §4).
#pragma once
#include "src/contact/laws.hpp"

namespace quern {

struct Linearization {
  double stiffness;     // k' [N/m]
  double damping;       // q' [kg/s]
  double loss;          // of the nonlinear collision [J]
  double restitution;   // of the nonlinear collision [-]
  double duration;      // of the nonlinear collision [s]
  double linear_loss;   // of the collision with k' and q' [J]
};

// k' = ∫x f dt / ∫x² dt and q' = ∫ẋ f dt / ∫ẋ² dt (S0 eqs. 23–24) over one collision of the law
// m ẍ + q ẋ x^s + k x^r = 0 (S0 eq. 12) that begins at `speed` [m/s]; `mass` [kg] is the effective mass (of a ball against a
// fixed body, its own). The integrals run from first touch until the force has ended. Throws InputError where an argument
// is not positive (damping and damping exponent: negative).
Linearization linearize(const PowerLaw& law, double mass, double speed);

}  // namespace quern
