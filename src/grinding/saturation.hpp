// y = P (1 − exp(−((x − x_0)/x_s)^m)) above a threshold x_0, 0 below: what begins, rises and comes to a plateau, such as damage against energy.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
#include "src/grinding/kinetics.hpp"

namespace quern {

// Repeats at one abscissa.
struct Level {
  double x = 0;
  double mean = 0;
  double scatter = 0;  // standard deviation of one; 0 where there is only one
  int count = 1;
};

// Gathers points by their abscissa, ascending; those that differ by rounding are one.
std::vector<Level> levels_of(const std::vector<double>& x, const std::vector<double>& y);

struct SaturationLaw {
  double plateau = 0, threshold = 0, scale = 1, shape = 1;  // P, x_0, x_s, m
  double at(double x) const;
  double half() const;           // where it is half of the plateau
  double initial_slope() const;  // P/x_s: the slope at the threshold where m = 1
};

struct SaturationForm {
  bool free_threshold = false, free_shape = false;  // otherwise 0 and 1
  double largest_plateau = 1;                       // 1 for fractions
  double largest_threshold = std::numeric_limits<double>::infinity();  // such as the first x with any damage
  int parameters() const { return 2 + free_threshold + free_shape; }
};

struct SaturationFit {
  SaturationLaw law;
  SaturationForm form;
  double residual = 0;                 // root mean square of the means about the law, per degree of freedom
  std::optional<double> p_of_law;      // of so large residuals if the law misses nothing (F test against the scatter of repeats)
  std::vector<SaturationLaw> redrawn;  // fits to means drawn anew; none where neither repeats nor degrees of freedom tell the scatter

  // 95 % intervals, none without redrawn fits.
  template <class Of>
  std::optional<Interval95> interval(Of of) const {
    std::vector<double> values;
    for (const SaturationLaw& law_of_set : redrawn) values.push_back(of(law_of_set));
    return middle95(std::move(values));
  }

  static std::optional<Interval95> middle95(std::vector<double> values);
};

// Least squares over the means, each with the number of its repeats for a weight; 0 ≤ P ≤ largest_plateau, 0.5 ≤ m ≤ 5, 0 ≤ x_0 ≤ largest_threshold and the last x but one.
// Intervals by a parametric bootstrap (Davison & Hinkley 1997, Bootstrap Methods and their Application, ch. 2 and 5): each mean is drawn from
// Student's t about the law, with its own standard error from four repeats on and with that pooled over all otherwise; without any repeats
// the residuals stand for it. The draws depend on the seed alone. Needs as many different x as parameters.
SaturationFit fit_saturation(const std::vector<Level>& levels, const SaturationForm& form, std::uint64_t seed = 1, int draws = 399);

}  // namespace quern
