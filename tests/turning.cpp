// Free asymmetric bodies: what stays, and when they flip.
#include <catch2/catch.hpp>
#include <cmath>
#include "src/particle/turning.hpp"

using namespace quern;

TEST_CASE("a free asymmetric top keeps energy and angular momentum over 1e5 steps", "[turning]") {
  const Vec3 moments(1.0, 2.3, 3.1), start(0.4, 3.0, 0.7);
  Rotation q = Rotation(0.3, -0.5, 0.7, 0.2).normalized();
  const Vec3 momentum = q * start.cwiseProduct(moments);
  const auto energy = [&] { return 0.5 * momentum.dot(spin_of(q, momentum, moments)); };
  const double before = energy(), step = 5e-4;
  double worst = 0, length = 0;
  for (int k = 0; k < 100000; ++k) {
    q = turned_freely(q, momentum, moments, step);
    worst = std::max(worst, std::abs(energy() - before));
    length = std::max(length, std::abs(q.norm() - 1));
  }
  CHECK(worst < 1e-6 * before);
  CHECK(length < 1e-12);
  // The angular momentum is an input, untouched; that the spins of the axes give it back is what the orientation keeps.
  const Vec3 own = q.conjugate() * momentum;
  CHECK((q * own - momentum).norm() < 1e-12 * momentum.norm());
}

TEST_CASE("a body spun about its middle axis flips after half the period of the elliptic functions", "[turning]") {
  // Landau & Lifshitz, Mechanics, § 37; M² > 2 E I₂.
  const Vec3 moments(1.0, 2.0, 3.0), start(1e-4, 5.0, 0.05);
  const Vec3 own = start.cwiseProduct(moments);
  const double square = own.squaredNorm(), twice_energy = own.dot(start);
  REQUIRE(square > twice_energy * moments[1]);
  const double k2 = (moments[1] - moments[0]) * (twice_energy * moments[2] - square) / ((moments[2] - moments[1]) * (square - twice_energy * moments[0]));
  const double rate = std::sqrt((moments[2] - moments[1]) * (square - twice_energy * moments[0]) / (moments[0] * moments[1] * moments[2]));
  const double half_period = 2 * std::comp_ellint_1(std::sqrt(k2)) / rate;

  const double step = 1e-4;
  Rotation q = Rotation::Identity();
  double previous = start[1], last_crossing = -1;
  int crossings = 0;
  for (int k = 1; crossings < 4; ++k) {
    REQUIRE(k < 1000000);
    q = turned_freely(q, own, moments, step);
    const double middle = (q.conjugate() * own)[1] / moments[1];
    if ((middle > 0) != (previous > 0)) {
      const double time = step * (k - middle / (middle - previous));
      if (last_crossing >= 0) CHECK(time - last_crossing == Approx(half_period).epsilon(1e-5));
      last_crossing = time;
      ++crossings;
    }
    previous = middle;
  }
}

TEST_CASE("halving the step cuts the error of a turning body by four", "[turning]") {
  const Vec3 moments(1.0, 2.3, 3.1);
  const Rotation start = Rotation(0.3, -0.5, 0.7, 0.2).normalized();
  const Vec3 momentum(1.2, -3.4, 2.2);
  const auto after = [&](int steps) {
    Rotation q = start;
    for (int k = 0; k < steps; ++k) q = turned_freely(q, momentum, moments, 1.0 / steps);
    return q;
  };
  const Rotation exact = after(20000);
  const double coarse = after(200).angularDistance(exact), fine = after(400).angularDistance(exact);
  CHECK(coarse / fine == Approx(4).epsilon(0.05));
}
