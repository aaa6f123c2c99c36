#include "bonds/bond_material.hpp"
#include <fmt/format.h>
#include <cmath>
#include "src/base/error.hpp"
#include "src/base/random.hpp"

namespace quern {

void check(const BondMaterial& m) {
  const auto refuse = [&](const char* what, double found, const char* allowed) {
    throw InputError(fmt::format("bond {}: {} is {:g}; it must be {}.", m.name.empty() ? "material" : m.name, what, found, allowed));
  };
  const auto positive = [&](const char* what, double value) {
    if (!(value > 0) || !std::isfinite(value)) refuse(what, value, "greater than 0");
  };
  positive("the ratio of its radius to that of the smaller grain", m.radius_ratio);
  if (m.young != 0) {
    positive("Young's modulus", m.young);
    positive("the shear modulus", m.shear_modulus);
  } else {
    positive("the normal stiffness per area", m.normal_stiffness);
    positive("the shear stiffness per area", m.shear_stiffness);
  }
  for (const auto& [what, value] : {std::pair{"the normal damping", m.damping.normal}, {"the shear damping", m.damping.shear},
                                    {"the bending damping", m.damping.bending}, {"the twisting damping", m.damping.twisting}})
    if (!(value >= 0 && value <= 1)) refuse(what, value, "from 0 to 1, a fraction of critical");
  positive("the tensile strength", m.strength.tensile);
  positive("the shear strength", m.strength.shear);
  if (m.strength.rate_exponent != 0) positive("the rate of strain at which its strength is as given", m.strength.reference_rate);
  if (m.strength.size_exponent != 0) positive("the size of a body at which its strength is as given", m.strength.reference_size);
  if (m.strength.distribution == StrengthDistribution::weibull) positive("the Weibull modulus of its strength", m.strength.modulus);
  if (m.strength.distribution == StrengthDistribution::normal && !(m.strength.deviation >= 0 && m.strength.deviation <= 1))
    refuse("the relative standard deviation of its strength", m.strength.deviation, "from 0 to 1");
}

double body_factor(const BondStrength& strength, double size, double rate) {
  double factor = 1;
  if (strength.rate_exponent != 0 && rate > strength.reference_rate) factor *= std::pow(rate / strength.reference_rate, strength.rate_exponent);
  if (strength.size_exponent != 0) factor *= std::pow(size / strength.reference_size, -strength.size_exponent);
  return factor;
}

double strength_factor(const BondStrength& strength, std::uint64_t seed, Index first_id, Index second_id) {
  const auto low = static_cast<std::uint64_t>(first_id < second_id ? first_id : second_id);
  const auto high = static_cast<std::uint64_t>(first_id < second_id ? second_id : first_id);
  RandomStream random(seed, low << 32 | high);
  if (strength.distribution == StrengthDistribution::weibull) return std::pow(-std::log(1.0 - random.uniform()), 1 / strength.modulus);
  if (strength.distribution == StrengthDistribution::normal)
    for (;;)
      if (const double factor = 1 + strength.deviation * random.normal(); factor > 0) return factor;
  return 1;
}

}  // namespace quern
