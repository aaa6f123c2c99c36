// A pendular bridge of liquid (Willett, Adams, Johnson & Seville 2000, their closed approximation), of R' = 2R*, Derjaguin's radius:
//   F = −2π R' σ cos θ / (1 + 1.05 s + 2.5 s²), s = S √(R'/V), S the gap;  ruptures at S = (1 + θ/2)(V^(1/3) + V^(2/3)/(10 R'))
// It forms where the bodies touch and lasts to rupture, where the energy that it took to draw it out is lost.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct LiquidBridge {
  double volume = 0;         // V [m³]; 0: off
  double tension = 0.0728;   // σ [N/m]
  double wetting_angle = 0;  // θ [rad]

  double reach(double radius) const {
    return (1 + 0.5 * wetting_angle) * (std::cbrt(volume) + std::cbrt(volume * volume) / (20 * radius));
  }

  template <class T>
  struct Pull {
    T force;   // along n, at most 0 [N]
    T energy;  // that drew it out [J]
    T rupture; // gap at which it breaks [m]
  };

  template <class T>
  QUERN_INLINE Pull<T> operator()(const T& gap, const T& radius) const {
    const T one(1.0), twice = T(2.0) * radius, root = square_root(twice * T(1 / volume));
    const T s = gap * root, most = T(2 * 3.14159265358979323846 * tension * std::cos(wetting_angle)) * twice;
    Pull<T> pull;
    pull.force = -(most / (one + s * (T(1.05) + T(2.5) * s)));
    const double width = std::sqrt(10 - 1.05 * 1.05);
    const T angle = each((T(5.0) * s + T(1.05)) * T(1 / width), [](double x) { return std::atan(x); });
    pull.energy = most / root * T(2 / width) * (angle - T(std::atan(1.05 / width)));
    pull.rupture = T(1 + 0.5 * wetting_angle) * (T(std::cbrt(volume)) + T(std::cbrt(volume * volume)) / (T(10.0) * twice));
    return pull;
  }
};

}  // namespace quern
