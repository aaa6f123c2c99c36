// What emulators tell of a stochastic simulation lies where the simulation lies, by as much as they say.
#include "src/diagnose/machine/emulator.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include "src/base/random.hpp"

using namespace quern;

namespace {

constexpr int sites = 6;

double place(int site) { return static_cast<double>(site) / (sites - 1); }

// Smooth in the condition, bent in two parameters that also work together.
double truth(int site, double a, double b) {
  const double s = place(site);
  return 10 + 4 * s - 2 * s * s + a * (1 - 0.5 * s) + 0.2 * a * a + b * (0.3 + s) - 0.15 * b * b + 0.1 * a * b;
}

Emulator taught(std::uint64_t seed, double scatter) {
  Eigen::MatrixXd coordinates(sites, 1);
  for (int s = 0; s < sites; ++s) coordinates(s, 0) = place(s);
  Emulator emulator(coordinates);
  RandomStream random(seed);
  const std::pair<double, double> design[] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}};
  for (const auto& [a, b] : design)
    for (int s = 0; s < sites; ++s) {
      Eigen::VectorXd at(2);
      at << a, b;
      emulator.add(static_cast<std::size_t>(s), at, truth(s, a, b) + scatter * random.normal(), scatter);
    }
  emulator.learn();
  return emulator;
}

}  // namespace

TEST_CASE("an emulator of runs without scatter is the quadratic that they follow", "[diagnose][machine]") {
  const Emulator emulator = taught(1, 1e-6);
  Eigen::VectorXd at(2);
  at << 0.4, -0.6;
  const Emulator::Told told = emulator.tell(at);
  for (int s = 0; s < sites; ++s) CHECK(told.mean[s] == Approx(truth(s, 0.4, -0.6)).margin(2e-3));
}

TEST_CASE("an emulator is off by as much as it says", "[diagnose][machine]") {
  // 95 % intervals of 200 × 6 predictions, those of one emulator alike: within 90 … 99 %.
  int inside = 0, all = 0;
  RandomStream random(5);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Emulator emulator = taught(seed, 0.1);
    for (int k = 0; k < 5; ++k) {
      Eigen::VectorXd at(2);
      at << 2 * random.uniform() - 1, 2 * random.uniform() - 1;
      const Emulator::Told told = emulator.tell(at);
      for (int s = 0; s < sites; ++s, ++all) inside += std::abs(told.mean[s] - truth(s, at[0], at[1])) < 1.96 * std::sqrt(told.covariance(s, s));
    }
  }
  const double share = static_cast<double>(inside) / all;
  CHECK(share > 0.90);
  CHECK(share < 0.995);
}

TEST_CASE("an emulator finds out the scatter of runs that claim none", "[diagnose][machine]") {
  Eigen::MatrixXd coordinates(sites, 1);
  for (int s = 0; s < sites; ++s) coordinates(s, 0) = place(s);
  Emulator emulator(coordinates);
  RandomStream random(3);
  constexpr double scatter = 0.2;
  for (int run = 0; run < 10; ++run)
    for (int s = 0; s < sites; ++s) {
      Eigen::VectorXd at(1);
      at << 0.2 * run - 1;
      emulator.add(static_cast<std::size_t>(s), at, truth(s, 0.2 * run - 1, 0) + scatter * random.normal(), 0);
    }
  emulator.learn();
  CHECK(emulator.scatter() > 0.6 * scatter);
  CHECK(emulator.scatter() < 1.6 * scatter);
}
