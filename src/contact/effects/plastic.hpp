// Contacts that yield: below the greatest overlap δ_m so far the force follows another curve than on the way in. Both forms are the
// law's own curve F_l at another overlap: F = f F_l(δ*), δ* = g (δ − δ_0), which meets the way in at δ_m; what comes back is f/g of the
// energy at δ*, the rest is lost.
//
// unloading_ratio K (Walton & Braun 1986): f = 1, g = K^(1/r), r the law's exponent. With the linear law F = K k (δ − δ_0), e = √(1/K).
// yield_pressure p_y (Thornton 1997; Thornton & Ning 1998), with Hertz's curve: from δ_y = R (π p_y/2E*)² on the way in is straight,
// F = F_y + π p_y R (δ − δ_y), and back is Hertz's of the flattened radius R_p = R F_hertz(δ_m)/F(δ_m): f = 1/g = R/R_p.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Plastic {
  double unloading_slope = 1;  // K^(1/r) [-]; 1: off
  double yield_pressure = 0;   // p_y [Pa]; 0: off
  double effective_young = 0;  // E* of the law [Pa], with yield_pressure

  bool on() const { return unloading_slope != 1 || yield_pressure > 0; }

  // Where the law's curve is read, and how its force is scaled.
  template <class T>
  struct Reading {
    T overlap;  // δ*
    T slope;    // g
    T scale;    // f
  };

  template <class T>
  QUERN_INLINE Reading<T> operator()(const T& overlap, const T& greatest, const T& radius) const {
    const T one(1.0), zero(0.0);
    T slope(unloading_slope), scale = one;
    if (yield_pressure > 0) {
      // In units of the overlap at yield: Hertz's force is d^1.5 and the straight way in 1 + 1.5 (d − 1), both over F_y.
      const double strain = 3.14159265358979323846 * yield_pressure / (2 * effective_young);
      const T d = greater(one, greatest / (T(strain * strain) * radius));
      scale = (one + T(1.5) * (d - one)) / (d * square_root(d));
      slope = one / scale;
    }
    return {greater(zero, greatest - slope * (greatest - overlap)), slope, scale};
  }
};

}  // namespace quern
