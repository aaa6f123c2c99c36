#include "src/contact/linearize.hpp"
#include <catch2/catch.hpp>
#include "src/base/error.hpp"

using namespace quern;

TEST_CASE("The linearization of a law that is linear gives back its stiffness and damping", "[linearize]") {
  const Linearization undamped = linearize(PowerLaw{1e6, 1.0, 0, 0.0, 0, 0}, 0.3, 1.7);
  CHECK(undamped.stiffness == Approx(1e6).epsilon(1e-9));
  CHECK(undamped.damping == Approx(0).margin(1e-3));
  CHECK(undamped.restitution == Approx(1).epsilon(1e-7));
  // The collision ends with the force, q v/k before the overlap does: q' errs by q/(π√(mk)) = 6e-4.
  const Linearization damped = linearize(PowerLaw{1e6, 1.0, 1, 0.0, 0, 0}, 0.3, 1.7);
  CHECK(damped.stiffness == Approx(1e6).epsilon(1e-5));
  CHECK(damped.damping == Approx(1).epsilon(1e-3));
  CHECK(damped.linear_loss == Approx(damped.loss).epsilon(1e-3));
}

TEST_CASE("S0's three balls dropped from 0.3 m: losses and linearized stiffness from its own k and q", "[linearize]") {
  // S0 table 1 gives k and q; losses and k' follow from its eqs. 13 and 23 (the printed ones, 0.187, 0.454, 0.985 J and 1.17e8, 1.13e8, 1.72e8 N/m, do not).
  struct Ball {
    double mass, k, q, loss, stiffness;
  };
  for (const Ball& b : {Ball{0.096, 4.8e10, 4.5e6, 0.170, 1.25e8}, Ball{0.252, 5.0e10, 4.8e6, 0.384, 1.64e8}, Ball{0.647, 5.2e10, 4.9e6, 0.810, 2.14e8}}) {
    const Linearization l = linearize(PowerLaw{b.k, 1.6, b.q, 0.8, 0, 0}, b.mass, std::sqrt(2 * 9.81 * 0.3));
    CHECK(l.loss == Approx(b.loss).margin(0.0006));
    CHECK(l.stiffness == Approx(b.stiffness).margin(0.006e8));
    CHECK(l.restitution == Approx(std::sqrt(1 - l.loss / (b.mass * 9.81 * 0.3))).epsilon(1e-9));
  }
}

TEST_CASE("Linearizing nonsense is refused", "[linearize]") {
  CHECK_THROWS_AS(linearize(PowerLaw{1e10, 1.6, 1e6, 0.8, 0, 0}, 0, 1), InputError);
  CHECK_THROWS_AS(linearize(PowerLaw{1e10, 1.6, 1e6, 0.8, 0, 0}, 1, -1), InputError);
  CHECK_THROWS_AS(linearize(PowerLaw{-1, 1.6, 1e6, 0.8, 0, 0}, 1, 1), InputError);
}
