// What bonds are made of: stiffness, damping and strength of the cement between two grains (a table [bond.<name>] of a case).
#pragma once
#include <cstdint>
#include <string>
#include "src/base/triple.hpp"

namespace quern {

enum class StrengthDistribution { constant, normal, weibull };

// Stresses at which bonds fail. One draw scales both: cement that is weak in tension is as weak in shear.
struct BondStrength {
  StrengthDistribution distribution = StrengthDistribution::constant;
  double tensile = 1e300;  // constant: σ_max; normal: its mean; weibull: its scale (63.2 % of the bonds are weaker) [Pa]
  double shear = 1e300;    // τ_max, likewise [Pa]
  double deviation = 0;    // normal: standard deviation over the mean [-]; negative strengths are drawn again
  double modulus = 0;      // weibull: the shape m of 1 − exp(−(σ/scale)^m) [-]
  double rate_exponent = 0;   // n: a body that is strained faster than the reference is (rate/reference)^n times as strong [-]
  double reference_rate = 1;  // [1/s]
  double size_exponent = 0;   // q: a body is (size/reference)^(−q) times as strong; of weakest links q = 3/m (Weibull 1939) [-]
  double reference_size = 0;  // [m]
};

// By what the strength of all bonds of a body is multiplied, for its size [m] and the nominal rate of strain [1/s]: speed of impact over size.
double body_factor(const BondStrength& strength, double size, double rate);

// Fractions of the critical damping of the two grains on each of the four springs [-].
struct BondDamping {
  double normal = 0, shear = 0, bending = 0, twisting = 0;
};

// A bond is a cylinder of radius λ min(R_i, R_j) between the centres of its grains (Potyondy & Cundall 2004). Its stiffness is given
// either by moduli, k_bn = E_b/L_0 and k_bs = G_b/L_0 with L_0 the initial distance of the centres, or per area.
struct BondMaterial {
  std::string name;
  double radius_ratio = 1;      // λ [-]
  double young = 0;             // E_b [Pa]; 0: stiffness per area instead
  double shear_modulus = 0;     // G_b [Pa]
  double normal_stiffness = 0;  // k_bn [N/m³], where young is 0
  double shear_stiffness = 0;   // k_bs [N/m³]
  BondDamping damping;
  BondStrength strength;
};

// Throws InputError with a clear sentence if a value is out of its range.
void check(const BondMaterial& material);

// What a bond's strength is multiplied by. The draw depends on the seed and on the two particles' ids alone.
double strength_factor(const BondStrength& strength, std::uint64_t seed, Index first_id, Index second_id);

}  // namespace quern
