// The probability that a body breaks against the specific energy of its impact, from how many of how many broke.
//
// Vogel & Peukert (2003, Powder Technol. 129:101): S = 1 − exp(−f_mat x k (W_m − W_min)), k impacts; here k = 1 and the rate is f_mat x.
// Weibull (1951, J. Appl. Mech. 18:293): S = 1 − exp(−(W_m/W_s)^m).
#pragma once
#include <cstdint>
#include <optional>
#include <vector>
#include "src/grinding/kinetics.hpp"

namespace quern {

// Bodies that met one specific energy.
struct BreakageCount {
  double energy = 0;  // more than 0 [J/kg]
  int broken = 0, tested = 0;
};

enum class BreakageLaw { vogel_peukert, weibull };

struct BreakageFit {
  BreakageLaw law = BreakageLaw::vogel_peukert;
  double first = 0;   // f_mat x [kg/J]; m
  double second = 0;  // W_min [J/kg]; W_s [J/kg]
  // 95 % intervals; [0, …] where it may be none, […, ∞] where it may be any.
  Interval95 first_ci95{}, second_ci95{};
  double log_likelihood = 0;  // without the binomial coefficients
  double deviance = 0;        // twice what the counts themselves have more
  std::optional<double> p_of_law;  // of so large a deviance if the law holds; none with two levels
  std::vector<std::array<double, 2>> redrawn;  // first and second, fitted to counts drawn from the law

  double at(double energy) const { return at(energy, first, second); }
  double at(double energy, double first_parameter, double second_parameter) const;
  Interval95 band_at(double energy) const;  // 95 %, by the redrawn
};

// What the counts can say at all.
enum class BreakageEvidence {
  enough,     // broken and whole ones at overlapping energies
  none_broke,
  all_broke,
  step,       // all whole below some energy and all broken above it: any steepness will do
  one_level,  // a probability at one energy, no law
};
BreakageEvidence evidence_of(const std::vector<BreakageCount>& counts);

// Maximum likelihood of the binomial counts, which are taken to be independent. Both likelihoods have one maximum (they are concave, in (f, f W_min) and in
// (m, m ln W_s)). Intervals are those of the profile likelihood (Venzon & Moolgavkar 1988, Appl. Statist. 37:87); p_of_law and the band come from
// counts drawn from the fitted law, which depend on the seed alone. Needs evidence_of(counts) == enough. Energies ascend.
BreakageFit fit_breakage(const std::vector<BreakageCount>& counts, BreakageLaw law, std::uint64_t seed = 1, int draws = 399);

// The 95 % interval of a probability (Clopper & Pearson 1934, Biometrika 26:404).
Interval95 proportion_interval(int hits, int trials);

}  // namespace quern
