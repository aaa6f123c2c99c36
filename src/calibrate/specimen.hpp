// src/calibrate — small built-in experiments by which what was measured on a specimen becomes the parameters of a case.
//
// A cylinder of a case's grains and bonds, twice as long as wide, held at its ends and pulled or pressed.
#pragma once
#include <cstdint>
#include <optional>
#include "src/case/case.hpp"

namespace quern {

struct Specimen {
  Case c;                            // nothing but the specimen, its axis along z
  double length = 0, area = 0;       // of the cylinder [m], [m²]
  std::int64_t grains = 0;
  double solid_fraction = 0;         // that was packed
};

// About `grains` grains of the agglomerate of that number, packed from `seed` to the agglomerate's solid fraction, or as densely as so few
// grains go. Throws InputError where they cannot be packed.
Specimen make_specimen(const Case& c, std::size_t agglomerate, std::int64_t grains, std::uint64_t seed);

// What the bonds of a specimen are made of, against those of its case.
struct BondScale {
  double young = 1;                   // factor of young or normal_stiffness of all bonds
  std::optional<double> stiffness_ratio;  // of all bonds; none: as in the case
  double tensile = 1, shear = 1;      // factors of the strengths
};
BondMaterial scaled(const BondMaterial& material, const BondScale& scale);

struct Elasticity {
  double young = 0, poisson = 0;  // [Pa], [-]
};
// Pressed by a strain of 1e-4 and held until it is at rest: Young's modulus and Poisson's ratio of the middle half, by the cross-section of the
// cylinder. Bonds do not fail.
Elasticity measure_elasticity(const Specimen& specimen, const BondScale& scale);

struct Strength {
  double stress = 0;             // greatest [Pa]
  double strain = 0;             // of the whole specimen at that stress [-]
  double kinetic_share = 0;      // greatest ratio of kinetic energy to that in bonds, from a fifth of that stress up to it
  bool failed = false;           // the stress fell to 70 % of its peak
};
enum class Pull { tension, compression };
// At a steady rate until it fails.
Strength measure_strength(const Specimen& specimen, const BondScale& scale, Pull pull);

}  // namespace quern
