#include "src/particle/size_distribution.hpp"
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include "src/base/error.hpp"

using namespace quern;

namespace {

constexpr int many = 100000;

std::vector<double> samples(const SizeDistribution& sizes) {
  RandomStream random(7);
  std::vector<double> result(many);
  for (double& d : result) d = sizes.sample(random);
  return result;
}

}  // namespace

TEST_CASE("One size gives that size always", "[size_distribution]") {
  const SizeDistribution sizes = SizeDistribution::mono(0.02);
  RandomStream random(1);
  CHECK(sizes.sample(random) == 0.02);
  CHECK(sizes.mean_volume() == Approx(4.18879020478639 * 1e-6).epsilon(1e-14));
  CHECK(sizes.quantile(0.8, Weight::mass) == 0.02);
  CHECK(sizes.quantile(0, Weight::number) == 0.02);
  CHECK(sizes.quantile(1, Weight::number) == 0.02);
}

TEST_CASE("A list of sizes keeps its counts to the ball", "[size_distribution]") {
  const SizeDistribution sizes = SizeDistribution::list({0.054, 0.029, 0.040}, {155, 59, 110}, Weight::number);
  RandomStream random(3);
  const auto counts = [](const std::vector<double>& diameters) {
    std::map<double, int> result;
    for (double d : diameters) ++result[d];
    return result;
  };
  std::vector<double> drawn = sizes.draw(324, random);
  CHECK(counts(drawn) == std::map<double, int>{{0.029, 59}, {0.040, 110}, {0.054, 155}});
  CHECK_FALSE(std::is_sorted(drawn.begin(), drawn.end()));
  // 33 balls: shares 6.009, 11.204, 15.787; the largest remainder gets the ball that is missing.
  CHECK(counts(sizes.draw(33, random)) == std::map<double, int>{{0.029, 6}, {0.040, 11}, {0.054, 16}});
  CHECK(sizes.draw(0, random).empty());
}

TEST_CASE("Masses in a list become numbers by the cube of the diameter", "[size_distribution]") {
  const SizeDistribution sizes = SizeDistribution::list({0.01, 0.02}, {1, 1}, Weight::mass);
  CHECK(sizes.number_fraction_below.front() == Approx(8.0 / 9).epsilon(1e-14));
  CHECK(sizes.mean_power(3) == Approx((8 * 1e-6 + 8e-6) / 9).epsilon(1e-14));
  CHECK(sizes.quantile(0.4, Weight::mass) == 0.01);
  CHECK(sizes.quantile(0.6, Weight::mass) == 0.02);
}

TEST_CASE("A log-normal distribution has the moments of Hatch and Choate", "[size_distribution]") {
  const double median = 0.01, sigma = 0.3;
  const SizeDistribution sizes = SizeDistribution::lognormal(median, sigma, Weight::number, 1e-4, 1);
  // ⟨d^p⟩ = median^p exp(p²σ²/2); 2000 nodes over ln(10⁴) = 9.2 leave some (9.2/2000)² = 2e-5.
  for (int p : {1, 2, 3, 4})
    CHECK(sizes.mean_power(p) == Approx(std::pow(median, p) * std::exp(0.5 * p * p * sigma * sigma)).epsilon(2e-4));
  CHECK(sizes.quantile(0.5, Weight::number) == Approx(median).epsilon(1e-4));
  CHECK(sizes.quantile(0.5, Weight::mass) == Approx(median * std::exp(3 * sigma * sigma)).epsilon(1e-4));
  const SizeDistribution same = SizeDistribution::lognormal(median * std::exp(3 * sigma * sigma), sigma, Weight::mass, 1e-4, 1);
  CHECK(same.mean_volume() == Approx(sizes.mean_volume()).epsilon(1e-12));

  const std::vector<double> drawn = samples(sizes);
  double sum = 0, squares = 0;
  for (double d : drawn) sum += std::log(d / median), squares += std::pow(std::log(d / median), 2);
  // Four standard errors of the mean and of the variance of ln d.
  CHECK(std::abs(sum / many) < 4 * sigma / std::sqrt(many));
  CHECK(std::abs(squares / many - sigma * sigma) < 4 * sigma * sigma * std::sqrt(2.0 / many));
}

TEST_CASE("A Rosin-Rammler distribution has its D50 and D80 by mass, also when sampled by number", "[size_distribution]") {
  const double size = 0.01, modulus = 2.5, smallest = 0.003, largest = 0.03;
  const SizeDistribution sizes = SizeDistribution::rosin_rammler(size, modulus, smallest, largest);
  const auto finer = [&](double d) { return 1 - std::exp(-std::pow(d / size, modulus)); };
  const auto expected = [&](double fraction) {
    const double uncut = finer(smallest) + fraction * (finer(largest) - finer(smallest));
    return size * std::pow(-std::log(1 - uncut), 1 / modulus);
  };
  CHECK(sizes.quantile(0.5, Weight::mass) == Approx(expected(0.5)).epsilon(1e-5));
  CHECK(sizes.quantile(0.8, Weight::mass) == Approx(expected(0.8)).epsilon(1e-5));
  CHECK(sizes.quantile(0, Weight::mass) == smallest);
  CHECK(sizes.quantile(1, Weight::mass) == largest);
  // Mean volume from an independent integral: 1/⟨d³⟩ = ∫ d⁻³ dM.
  double inverse = 0;
  constexpr int steps = 20000;
  for (int k = 0; k < steps; ++k) inverse += std::pow(expected((k + 0.5) / steps), -3) / steps;
  CHECK(sizes.mean_power(3) == Approx(1 / inverse).epsilon(1e-4));

  std::vector<double> drawn = samples(sizes);
  double mass_finer = 0, mass = 0, square = 0;
  for (double d : drawn) {
    const double m = d * d * d;
    mass += m, square += m * m;
    if (d < expected(0.8)) mass_finer += m;
  }
  // The weighted count behaves like (Σm)²/Σm² independent balls.
  CHECK(std::abs(mass_finer / mass - 0.8) < 4 * 0.4 * std::sqrt(square) / mass);
}

TEST_CASE("A table of sizes is followed between its rows", "[size_distribution]") {
  const SizeDistribution sizes = SizeDistribution::table({0.001, 0.002, 0.004}, {0, 30, 100});
  CHECK(sizes.quantile(0.3, Weight::mass) == Approx(0.002).epsilon(1e-14));
  CHECK(sizes.quantile(0.65, Weight::mass) == Approx(0.003).epsilon(1e-14));
  // Number in a bin ∝ mass/(b − a) · (a⁻² − b⁻²)/2: 0.3/0.001·(1e6 − 0.25e6)/2 against 0.7/0.002·(0.25e6 − 0.0625e6)/2.
  const double fine = 0.3 / 0.001 * 0.75e6 / 2, coarse = 0.7 / 0.002 * 0.1875e6 / 2;
  CHECK(sizes.number_fraction_below[1] == Approx(fine / (fine + coarse)).epsilon(1e-14));
  CHECK(sizes.quantile(fine / (fine + coarse), Weight::number) == Approx(0.002).epsilon(1e-12));
}

TEST_CASE("Drawing keeps closer to the distribution than chance does", "[size_distribution]") {
  const SizeDistribution sizes = SizeDistribution::rosin_rammler(0.01, 2, 0.004, 0.02);
  RandomStream random(5);
  std::vector<double> drawn = sizes.draw(1000, random);
  std::sort(drawn.begin(), drawn.end());
  for (std::size_t k = 0; k < 1000; ++k) {
    REQUIRE(drawn[k] >= sizes.quantile(double(k) / 1000, Weight::number) * (1 - 1e-12));
    REQUIRE(drawn[k] <= sizes.quantile((double(k) + 1) / 1000, Weight::number) * (1 + 1e-12));
  }
}

TEST_CASE("Size distributions refuse what cannot be", "[size_distribution]") {
  CHECK_THROWS_AS(SizeDistribution::mono(0), InputError);
  CHECK_THROWS_AS(SizeDistribution::mono(std::nan("")), InputError);
  CHECK_THROWS_AS(SizeDistribution::list({0.01}, {1, 2}, Weight::number), InputError);
  CHECK_THROWS_AS(SizeDistribution::list({0.01, 0.02}, {0, 0}, Weight::number), InputError);
  CHECK_THROWS_AS(SizeDistribution::list({0.01, 0.02}, {1, -1}, Weight::number), InputError);
  CHECK_THROWS_AS(SizeDistribution::lognormal(0.01, 0, Weight::number, 0.001, 0.1), InputError);
  CHECK_THROWS_AS(SizeDistribution::lognormal(0.01, 0.1, Weight::number, 0.1, 0.001), InputError);
  CHECK_THROWS_AS(SizeDistribution::lognormal(0.01, 0.01, Weight::number, 0.1, 1), InputError);
  CHECK_THROWS_AS(SizeDistribution::rosin_rammler(0.01, -1, 0.001, 0.1), InputError);
  CHECK_THROWS_AS(SizeDistribution::table({0.01, 0.01}, {0, 1}), InputError);
  CHECK_THROWS_AS(SizeDistribution::table({0.01, 0.02}, {1, 0.5}), InputError);
}
