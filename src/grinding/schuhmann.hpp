// The size distribution of Gates, Gaudin and Schuhmann: the mass finer than x is (x/k)^m (Schuhmann 1940, AIME Tech. Pub. 1189).
#pragma once
#include <optional>
#include <vector>
#include "src/grinding/kinetics.hpp"

namespace quern {

struct SchuhmannFit {
  double modulus = 0;             // m, of distribution [-]
  double size = 0;                // k, of size [m]
  Interval95 modulus_ci95{}, size_ci95{};
  std::vector<double> sieves, finer;  // the points of the fit [m], [-]

  double at(double x) const;      // mass finer than x [-], at most 1
};

// Fits the law to fragments by their sieve sizes [m] and masses [any unit]: least squares of ln(finer) on ln(size) over sieves that follow
// each other by √2, from `finest` [m] up (below, single grains tell no more than how the body was made of them), as far as less than 0.8 of the
// mass passes: there the few largest fragments bend the curve. The intervals are those of 400 samples of the fragments, drawn with replacement
// (bootstrap percentiles): of synthetic fragments they hold in 94 %. None with fewer than 20 fragments in that
// range or fewer than 4 sieves, and where k comes out above twice the largest fragment: then the law does not describe them.
std::optional<SchuhmannFit> fit_schuhmann(const std::vector<double>& sizes, const std::vector<double>& masses, double finest);

}  // namespace quern
