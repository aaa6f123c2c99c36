// src/grinding — how fast particles get finer, and how that follows the energy of the impacts: fits to measured sizes, no simulation.
//
// First-order kinetics (Khanal & Jayasundara, eq. 2.1; Jayasundara et al. 2010): (D_t − D_∞)/(D_0 − D_∞) = exp(−(K t)^m) with m = 1.
#pragma once
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace quern {

using Interval95 = std::array<double, 2>;

// A size that shrinks with time, such as D80 of a sample. Units are the caller's; rates come out in their inverse time.
struct SizeSeries {
  std::vector<double> times;    // ascending, from 0; equal ones are repeats
  std::vector<double> sizes;    // more than 0
  std::vector<double> weights;  // 1/standard deviation², or on any scale; empty: all alike
};

struct KineticsFit {
  double rate = 0;                     // K
  std::optional<Interval95> rate_ci95; // [0, …] where K may be none, […, ∞] where it may be any; none with as many parameters as points
  double start = 0, limit = 0;         // D_0, D_∞
  double shape = 1;                    // m
  double squares = 0;                  // weighted sum of squared residuals, least
  int points = 0, parameters = 0;
  // Of ln K, for errors of unit variance at unit weight: towards smaller and towards larger K, as the interval is seldom symmetric.
  std::array<double, 2> log_rate_variance{};
  bool determined = true;              // false: the least squares lie at K = 0 or K = ∞

  int freedom() const { return points - parameters; }
  double scatter() const;              // standard deviation of an error at unit weight; 0 without degrees of freedom
  double at(double time) const;
};

// Least squares in K, D_0 and, unless it is given, D_∞ ≥ 0. For a given K the sizes are linear in the other two, which leaves one dimension
// to search (variable projection, Golub & Pereyra 1973, SIAM J. Numer. Anal. 10:413). The interval is where the profile of the sum of
// squares rises by no more than t² times the scatter's square, with Student's t (Bates & Watts 1988, Nonlinear Regression Analysis, ch. 6); errors are
// taken to be independent and normal, of unknown size. Needs as many different times as parameters: 2 with a given limit, 3 without.
KineticsFit fit_kinetics(const SizeSeries& series, std::optional<double> limit, double shape = 1);

// Whether the decline is first-order at all: the same with m free, from 0.1 to 4.
struct ShapeFit {
  KineticsFit fit;
  std::optional<Interval95> shape_ci95;
  double p_first_order = 1;  // of the F test of m = 1
};
// None without a degree of freedom beyond it.
std::optional<ShapeFit> fit_shape(const SizeSeries& series, std::optional<double> limit);

// Root mean square of the errors at times left out, each predicted from the others. None where the others are too few.
std::optional<double> held_out_error(const SizeSeries& series, std::optional<double> limit, bool free_shape = false);

}  // namespace quern
