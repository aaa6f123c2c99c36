// K = a x^b over operating points, as K_p = a E_i^b (Khanal & Jayasundara, fig. 9).
#pragma once
#include <optional>
#include <vector>
#include "src/grinding/kinetics.hpp"

namespace quern {

struct OperatingPoint {
  double x = 0;                  // more than 0
  double rate = 0;               // more than 0
  // Of ln K, by the errors of its measurement, towards smaller and larger K; ∞ where it may be none or any; 0 at every point: not known, all alike.
  std::array<double, 2> log_rate_variance{};
  double log_x_variance = 0;     // of ln x
};

struct PowerLawFit {
  double factor = 0, exponent = 0;  // a, b
  std::optional<Interval95> factor_ci95, exponent_ci95;  // none with two points
  double lack = 0;                  // standard deviation of ln K beyond the errors of measurement: what the law misses
  std::optional<double> p_of_law;   // of so much scatter if the law misses nothing, by chi-square; none where the errors are not known
  std::optional<double> held_out;   // root mean square of ln K at points left out, each predicted from the others; none with two points
  std::optional<double> held_out_mean;  // the same with the mean ln K of the others for a law
  std::vector<OperatingPoint> points;

  double at(double x) const;
  // The 95 % interval of the law at x.
  std::optional<Interval95> band_at(double x) const;
};

// Weighted least squares in logarithms, each point with its own variance and one more, common to all, for what the law misses (Paule & Mandel 1982,
// J. Res. NBS 87:377). The intervals are those of the profile of the sum of squares, with the scale that the residuals show and Student's t (Knapp & Hartung
// 2003, Statist. Med. 22:2693), so that they hold for few points and for variances known up to a factor. Needs two different x.
PowerLawFit fit_power_law(const std::vector<OperatingPoint>& points);

}  // namespace quern
