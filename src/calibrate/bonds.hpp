// From Young's modulus, Poisson's ratio and strength of a specimen to the stiffness and strength of the bonds in it.
#pragma once
#include <string>
#include <vector>
#include "src/calibrate/specimen.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct BondTargets {
  double young = 0;                  // [Pa]
  std::optional<double> poisson;     // [-]
  std::optional<double> tensile;     // direct tension [Pa]
  std::optional<double> compressive; // uniaxial compression [Pa]
};

struct BondRequest {
  BondTargets targets;
  std::size_t agglomerate = 0;
  std::int64_t grains = 400;
  int specimens = 3;                 // of that many grains, packed from seeds of their own; what counts is their mean
  bool sizes = true;                 // also at half and twice the grains
  int threads = 1;                   // specimens are measured beside each other; the answer does not depend on it
};

// Mean over specimens and their standard deviation.
struct Scatter {
  double mean = 0, deviation = 0;
};

// What a set of specimens has.
struct SpecimenFigures {
  std::int64_t grains = 0;
  double diameter = 0;                       // of the specimens [m]
  double solid_fraction = 0;                 // that they have
  Scatter young, poisson;
  std::optional<Scatter> tensile, compressive;
  double kinetic_share = 0;                  // greatest of all strength runs
  bool all_failed = true;
};

struct BondTrial {
  std::string kind;                          // elasticity, tension, compression
  BondScale scale;
  SpecimenFigures figures;                   // those measured in it
};

struct BondCalibration {
  BondScale scale;
  std::vector<BondCase> bonds;               // the case's, scaled
  SpecimenFigures reached;
  std::vector<BondTrial> trials;
  std::vector<SpecimenFigures> sizes;        // ascending
  std::vector<std::string> remarks;          // plain sentences: what could not be reached, and what can
};

// E is in proportion to the bonds' young at a given stiffness ratio, ν grows with the ratio, and strength is in proportion to the bonds' strengths:
// ratio by false position on its logarithm, the others by their proportion, each checked by another run. With both strengths given, the ratio
// of the bonds' shear to tensile strength is sought as well. Deterministic. Throws InputError where the case has no such agglomerate or
// bonds, or specimens cannot be packed.
BondCalibration calibrate_bonds(const Case& c, const BondRequest& request);

std::vector<Table> calibration_tables(const BondCalibration& calibration);
std::vector<Headline> calibration_headlines(const BondCalibration& calibration, const BondTargets& targets);
// The tables [bond.…] to put into the case, TOML.
std::string bond_tables(const BondCalibration& calibration);
// For the terminal; one line each.
std::vector<std::string> calibration_words(const BondCalibration& calibration, const BondTargets& targets);

}  // namespace quern
