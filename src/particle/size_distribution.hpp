// How the diameters of a species are spread, and drawing from it.
#pragma once
#include <cstdint>
#include <vector>
#include "src/base/random.hpp"

namespace quern {

// What the fractions of a distribution count.
enum class Weight { number, mass };

// Every distribution is reduced to one form: the mass fraction finer than each of some diameters. Between two of them the
// mass is spread evenly over the diameter, so that the number density there goes as d⁻³ and all integrals are exact.
// A list of sizes has atoms instead: row k holds all of size k and mass_fraction_below[k] includes it.
struct SizeDistribution {
  std::vector<double> diameter;               // ascending [m]
  std::vector<double> mass_fraction_below;    // ascending, ends in 1
  std::vector<double> number_fraction_below;  // the same by number
  bool atoms = true;

  // All factories throw InputError on sizes ≤ 0, not finite, min ≥ max, or fractions that are negative or all zero.
  static SizeDistribution mono(double diameter);
  // Amounts need not be normalized: counts or number fractions (Weight::number), masses or mass fractions (Weight::mass).
  static SizeDistribution list(std::vector<double> diameters, std::vector<double> amounts, Weight weight);
  // ln d is normal with standard deviation sigma about ln(median), cut to [smallest, largest]. The median is of the uncut
  // distribution, by number or by mass as told; median by mass = median by number · exp(3σ²) (Hatch & Choate 1929).
  static SizeDistribution lognormal(double median, double sigma, Weight weight, double smallest, double largest);
  // Mass fraction finer than d: 1 − exp(−(d/size)^modulus) (Rosin & Rammler 1933), cut to [smallest, largest].
  static SizeDistribution rosin_rammler(double size, double modulus, double smallest, double largest);
  // Points (diameter, mass fraction finer), ascending in both; scaled to start at 0 and to end in 1.
  static SizeDistribution table(std::vector<double> diameters, std::vector<double> mass_finer);

  double smallest() const { return diameter.front(); }
  double largest() const { return diameter.back(); }
  // The diameter below which the given fraction lies, 0 to 1, by number or by mass [m].
  double quantile(double fraction, Weight weight) const;
  // Mean of d^power over the number of particles [m^power].
  double mean_power(int power) const;
  double mean_volume() const;  // of one particle [m³]

  // One diameter, by number [m].
  double sample(RandomStream& random) const;
  // `count` diameters in random order that keep to the distribution more closely than independent ones: a list of sizes gets
  // each size's exact share (largest remainder), the others one diameter at random from each 1/count of the number.
  std::vector<double> draw(std::int64_t count, RandomStream& random) const;
};

}  // namespace quern
