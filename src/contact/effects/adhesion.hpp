// Adhesion after Johnson, Kendall & Roberts (1971), for laws with Hertz's curve: what it adds to that curve. With L = (2π w R²/E*)^(1/3)
// and the contact radius a = L z²:  δ = (L²/R)(z⁴ − z),  F = 2π w R (4/3 z⁶ − 2 z³),  U = 2π w L² (8/15 z¹⁰ − 4/3 z⁷ + ½ z⁴).
// Bodies snap together where they touch (z = 1) and stick beyond, by a neck that breaks where z⁴ − z is least; pull-off is 3/2 π w R.
// Energy is counted from bodies apart: 0.30 × 2π w L² are lost when they snap together, 0.0315 × 2π w L² when the neck breaks.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Adhesion {
  double work = 0;             // w, of adhesion per area [J/m²]; 0: off
  double effective_young = 0;  // E* of the law [Pa]

  static constexpr double pi = 3.14159265358979323846;
  static constexpr double neck = -0.47247039371057334;  // least z⁴ − z: −3/4 × 4^(−1/3)

  // Length of the neck when it breaks [m]; grows with the radius.
  double reach(double radius) const { return -neck * std::pow(2 * pi * work / effective_young, 2.0 / 3.0) * std::cbrt(radius); }

  template <class T>
  struct Bond {
    T force;      // beyond Hertz's [N]
    T energy;     // beyond Hertz's [J]
    T stiffness;  // beyond Hertz's [N/m], where the whole stays positive
    T radius;     // a [m]
    T stiffening; // square of: contact radius one step earlier over the present one, at most 1 [-]
    T strained;   // z⁴ − z: below `neck` the neck has broken
  };

  // `indentation` is negative where there is a gap; `change` is what it grew by in the last step.
  template <class T>
  QUERN_INLINE Bond<T> operator()(const T& indentation, const T& change, const T& radius) const {
    const T zero(0.0), one(1.0);
    const T scale = each(T(2 * pi * work / effective_young) * radius * radius, [](double cube) { return std::cbrt(cube); });  // L
    const T unit = scale * scale / radius;
    const T strain = indentation / unit, held = greater(strain, T(neck));
    // Newton's steps fall to the root from above.
    T z = one + square_root(square_root(greater(strain, zero)));
    for (int k = 0; k < 14; ++k) {
      const T cube = z * z * z;
      z -= (z * cube - z - held) / greater(T(4.0) * cube - one, T(1e-9));
    }
    const T cube = z * z * z, pressed = greater(indentation, zero);
    const T hertz_radius = square_root(radius * pressed), hertz = T(4.0 / 3.0 * effective_young) * hertz_radius * pressed;
    const T tension = T(2 * pi * work) * radius;
    Bond<T> bond;
    bond.force = tension * (T(4.0 / 3.0) * cube - T(2.0)) * cube - hertz;
    bond.energy = T(2 * pi * work) * scale * scale * z * cube * ((T(8.0 / 15.0) * cube - T(4.0 / 3.0)) * cube + T(0.5)) - T(0.4) * hertz * pressed;
    const T steep = greater(T(4.0) * cube - one, T(0.05));
    bond.stiffness = greater(zero, tension / unit * z * z * (T(8.0) * cube - T(6.0)) / steep) - T(2 * effective_young) * hertz_radius;
    bond.radius = scale * z * z;
    const T before = greater(zero, lesser(one, one - change / (unit * steep * z)));
    bond.stiffening = before * before * before * before;
    bond.strained = strain;
    return bond;
  }
};

}  // namespace quern
