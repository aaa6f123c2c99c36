// src/material — what bodies are made of and what two materials do to each other. One formula, one place.
#pragma once
#include <string>

namespace quern {

struct Material {
  std::string name;
  double density = 0;  // [kg/m³]
  double young = 0;    // [Pa]; 0 where only linear laws are used
  double poisson = 0;  // [-]
};

// E* of two elastic bodies: 1/E* = Σ (1−ν²)/E [Pa] (physics: Hertz; Johnson 1985).
inline double effective_young(const Material& a, const Material& b) {
  return 1.0 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
}

// G* of two elastic bodies: 1/G* = Σ 2(2−ν)(1+ν)/E [Pa] (Mindlin 1949).
inline double effective_shear(const Material& a, const Material& b) {
  const auto compliance = [](const Material& m) { return 2 * (2 - m.poisson) * (1 + m.poisson) / m.young; };
  return 1.0 / (compliance(a) + compliance(b));
}

inline double shear_modulus(const Material& m) { return m.young / (2 * (1 + m.poisson)); }

}  // namespace quern
