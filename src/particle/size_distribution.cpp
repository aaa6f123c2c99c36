#include "src/particle/size_distribution.hpp"
#include <algorithm>
#include <numeric>
#include <string>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr int smooth_nodes = 2001;  // the error of a moment is of the order of (ln(largest/smallest)/2000)²

void require(bool holds, const char* message) {
  if (!holds) throw InputError(message);
}

void require_diameter(double d) { require(std::isfinite(d) && d > 0, "A diameter must be a finite number above 0 m."); }

void require_range(double smallest, double largest) {
  require_diameter(smallest), require_diameter(largest);
  require(smallest < largest, "The smallest diameter of a distribution must be below its largest.");
}

// ∫ d^power dd from a to b.
double integral(double a, double b, int power) {
  return power == -1 ? std::log(b / a) : (std::pow(b, power + 1) - std::pow(a, power + 1)) / (power + 1);
}

double total(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// Running sums of the parts, scaled to end in exactly 1.
std::vector<double> cumulative(const std::vector<double>& parts) {
  const double sum = total(parts);
  require(std::isfinite(sum) && sum > 0, "The fractions of a size distribution must be finite and not all zero.");
  std::vector<double> below(parts.size());
  double running = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) below[k] = (running += parts[k]) / sum;
  below.back() = 1;
  return below;
}

std::vector<double> steps(const std::vector<double>& below) {
  std::vector<double> parts(below.size());
  std::adjacent_difference(below.begin(), below.end(), parts.begin());
  return parts;
}

// Row k ≥ 1 of `mass` lies evenly between diameters k − 1 and k.
SizeDistribution from_bins(std::vector<double> diameters, const std::vector<double>& mass) {
  SizeDistribution result;
  result.atoms = false;
  std::vector<double> number(mass.size(), 0.0);
  for (std::size_t k = 1; k < mass.size(); ++k) {
    number[k] = mass[k] * integral(diameters[k - 1], diameters[k], -3) / (diameters[k] - diameters[k - 1]);
  }
  result.mass_fraction_below = cumulative(mass);
  result.number_fraction_below = cumulative(number);
  result.diameter = std::move(diameters);
  return result;
}

// From the uncut mass fraction finer than d, cut to [smallest, largest].
template <class Finer>
SizeDistribution from_curve(double smallest, double largest, Finer&& finer) {
  std::vector<double> diameters(smooth_nodes), mass(smooth_nodes, 0.0);
  double before = 0;
  for (int k = 0; k < smooth_nodes; ++k) {
    const auto row = static_cast<std::size_t>(k);
    diameters[row] = k + 1 == smooth_nodes ? largest : smallest * std::pow(largest / smallest, double(k) / (smooth_nodes - 1));
    const double here = finer(diameters[row]);
    if (k > 0) mass[row] = std::max(0.0, here - before);
    before = here;
  }
  require(total(mass) > 1e-9, "Between the smallest and the largest diameter lies no part of the size distribution.");
  return from_bins(std::move(diameters), mass);
}

}  // namespace

SizeDistribution SizeDistribution::mono(double diameter) { return list({diameter}, {1.0}, Weight::number); }

SizeDistribution SizeDistribution::list(std::vector<double> diameters, std::vector<double> amounts, Weight weight) {
  require(!diameters.empty() && diameters.size() == amounts.size(), "A list of sizes needs one amount for each of its diameters.");
  for (double d : diameters) require_diameter(d);
  for (double amount : amounts)
    require(std::isfinite(amount) && amount >= 0, "An amount in a list of sizes must be a finite number, 0 or more.");
  std::vector<std::size_t> order(diameters.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return diameters[a] < diameters[b]; });
  SizeDistribution result;
  std::vector<double> number, mass;
  for (std::size_t k : order) {
    const double volume = std::pow(diameters[k], 3);
    result.diameter.push_back(diameters[k]);
    number.push_back(weight == Weight::number ? amounts[k] : amounts[k] / volume);
    mass.push_back(weight == Weight::mass ? amounts[k] : amounts[k] * volume);
  }
  result.mass_fraction_below = cumulative(mass);
  result.number_fraction_below = cumulative(number);
  return result;
}

SizeDistribution SizeDistribution::lognormal(double median, double sigma, Weight weight, double smallest, double largest) {
  require_diameter(median), require_range(smallest, largest);
  require(std::isfinite(sigma) && sigma > 0, "The standard deviation sigma of a log-normal distribution must be a finite number above 0.");
  const double mass_median = weight == Weight::mass ? median : median * std::exp(3 * sigma * sigma);
  return from_curve(smallest, largest, [&](double d) { return 0.5 * std::erfc(-std::log(d / mass_median) / (sigma * std::sqrt(2.0))); });
}

SizeDistribution SizeDistribution::rosin_rammler(double size, double modulus, double smallest, double largest) {
  require_diameter(size), require_range(smallest, largest);
  require(std::isfinite(modulus) && modulus > 0, "The modulus of a Rosin-Rammler distribution must be a finite number above 0.");
  return from_curve(smallest, largest, [&](double d) { return -std::expm1(-std::pow(d / size, modulus)); });
}

SizeDistribution SizeDistribution::table(std::vector<double> diameters, std::vector<double> mass_finer) {
  require(diameters.size() >= 2 && diameters.size() == mass_finer.size(),
          "A table of sizes needs at least two rows: diameter, mass fraction finer.");
  for (std::size_t k = 0; k < diameters.size(); ++k) {
    require_diameter(diameters[k]);
    require(std::isfinite(mass_finer[k]) && mass_finer[k] >= 0, "A mass fraction must be a finite number, 0 or more.");
    if (k == 0) continue;
    require(diameters[k] > diameters[k - 1], "The diameters of a table of sizes must ascend.");
    require(mass_finer[k] >= mass_finer[k - 1], "The mass fractions finer in a table of sizes must not descend.");
  }
  std::vector<double> mass = steps(mass_finer);
  mass.front() = 0;
  return from_bins(std::move(diameters), mass);
}

double SizeDistribution::quantile(double fraction, Weight weight) const {
  const std::vector<double>& below = weight == Weight::number ? number_fraction_below : mass_fraction_below;
  const auto at = std::lower_bound(below.begin(), below.end(), std::min(fraction, 1.0));
  const auto k = static_cast<std::size_t>(at - below.begin());
  if (atoms) return diameter[k];
  if (k == 0) {
    // The finest bin that holds anything begins where the fraction leaves 0.
    const auto first = std::upper_bound(below.begin(), below.end(), 0.0);
    return diameter[static_cast<std::size_t>(first - below.begin()) - 1];
  }
  const double a = diameter[k - 1], b = diameter[k], u = (fraction - below[k - 1]) / (below[k] - below[k - 1]);
  if (weight == Weight::mass) return a + u * (b - a);
  const double fine = 1 / (a * a), coarse = 1 / (b * b);
  return std::clamp(1 / std::sqrt(fine - u * (fine - coarse)), a, b);
}

double SizeDistribution::mean_power(int power) const {
  const std::vector<double> number = steps(number_fraction_below);
  double mean = 0;
  for (std::size_t k = 0; k < diameter.size(); ++k) {
    if (atoms) {
      mean += number[k] * std::pow(diameter[k], power);
    } else if (k > 0) {
      mean += number[k] * integral(diameter[k - 1], diameter[k], power - 3) / integral(diameter[k - 1], diameter[k], -3);
    }
  }
  return mean;
}

double SizeDistribution::mean_volume() const { return 0.5235987755982988 * mean_power(3); }

double SizeDistribution::sample(RandomStream& random) const { return quantile(1 - random.uniform(), Weight::number); }

std::vector<double> SizeDistribution::draw(std::int64_t count, RandomStream& random) const {
  std::vector<double> result;
  if (count <= 0) return result;
  result.reserve(static_cast<std::size_t>(count));
  if (atoms) {
    const std::vector<double> number = steps(number_fraction_below);
    std::vector<std::int64_t> whole(number.size());
    std::vector<std::size_t> order(number.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // Shares such as 3 · (1/3) that rounding left a hair below a whole number count as whole.
    const auto share = [&](std::size_t k) { return number[k] * double(count) + 1e-9; };
    for (std::size_t k : order) whole[k] = static_cast<std::int64_t>(share(k));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return share(a) - double(whole[a]) > share(b) - double(whole[b]); });
    std::int64_t missing = count - std::accumulate(whole.begin(), whole.end(), std::int64_t{0});
    for (std::size_t k = 0; missing > 0; k = (k + 1) % order.size(), --missing) ++whole[order[k]];
    for (std::size_t k = 0; k < whole.size(); ++k) result.insert(result.end(), static_cast<std::size_t>(whole[k]), diameter[k]);
  } else {
    for (std::int64_t k = 0; k < count; ++k) result.push_back(quantile((double(k) + 1 - random.uniform()) / double(count), Weight::number));
  }
  for (std::size_t k = result.size() - 1; k > 0; --k) std::swap(result[k], result[static_cast<std::size_t>(random.next() % (k + 1))]);
  return result;
}

}  // namespace quern
