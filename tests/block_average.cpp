#include "src/observe/block_average.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "src/base/random.hpp"

using namespace quern;

namespace {

// x ← φ x + noise, begun in its own steady state; the mean is 0 and the variance 1/(1 − φ²).
std::vector<double> autoregressive(double phi, std::size_t count, RandomStream& random) {
  std::vector<double> x(count);
  double value = random.normal() / std::sqrt(1 - phi * phi);
  for (double& at : x) {
    at = value;
    value = phi * value + random.normal();
  }
  return x;
}

}  // namespace

TEST_CASE("the 95 % interval of a correlated series covers the true mean in 93 to 97 % of trials") {
  for (double phi : {0.0, 0.5, 0.9}) {
    constexpr int trials = 2000;
    RandomStream random(7, static_cast<std::uint64_t>(phi * 100));
    int covered = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const BlockAverage average = block_average(autoregressive(phi, 2048, random));
      covered += (*average.ci95)[0] <= 0 && 0 <= (*average.ci95)[1];
    }
    INFO("correlation " << phi << ", covered " << covered << " of " << trials);
    CHECK(covered >= 0.93 * trials);
    CHECK(covered <= 0.97 * trials);
  }
}

TEST_CASE("the standard error of an autoregressive series is 1/((1 − φ)√n)") {
  RandomStream random(11);
  double mean = 0;
  for (int trial = 0; trial < 200; ++trial) {
    mean += block_average(autoregressive(0.9, 8192, random)).standard_error / 200;
  }
  CHECK(mean == Approx(10 / std::sqrt(8192.0)).epsilon(0.1));
}

TEST_CASE("a transient is cut off and does not shift the mean") {
  RandomStream random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> x = autoregressive(0.5, 3000, random);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += 100 - 80 * std::exp(-static_cast<double>(k) / 100);
    const std::size_t start = steady_start(x);
    CHECK(start > 250);   // the transient there is still 6 times the noise
    CHECK(start < 1500);
    CHECK(steady_average(x).mean == Approx(100).margin(0.3));
  }
}

TEST_CASE("a steady series is kept nearly whole") {
  RandomStream random(5);
  std::size_t dropped = 0;
  for (int trial = 0; trial < 100; ++trial) dropped += steady_start(autoregressive(0.3, 2000, random));
  CHECK(dropped < 100 * 300);
}

TEST_CASE("a short or constant series has a mean and makes no claim beyond it") {
  CHECK_FALSE(block_average({1, 2}).ci95.has_value());
  CHECK(block_average({}).mean == 0);
  CHECK(block_average(std::vector<double>(100, 3.0)).standard_error == 0);
  CHECK(steady_start({1, 2, 3}) == 0);
}

TEST_CASE("the Poisson interval is Garwood's") {
  CHECK(poisson_interval(0)[1] == Approx(3.6889).epsilon(1e-4));
  CHECK(poisson_interval(10)[0] == Approx(4.7954).epsilon(1e-4));
  CHECK(poisson_interval(10)[1] == Approx(18.3904).epsilon(1e-4));
  // What is used for very many goes on from what is used below.
  for (const int side : {0, 1}) CHECK(poisson_interval(1e6)[static_cast<std::size_t>(side)] - 1e6 == Approx(poisson_interval(1e6 - 1e-3)[static_cast<std::size_t>(side)] - 1e6).margin(0.01));
  CHECK(poisson_interval(1e-310)[0] == 0);
}
