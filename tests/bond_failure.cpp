// A bond fails at the stress that the theory of beams gives, alone and combined, and not before; its strength is drawn as asked.
#include <catch2/catch.hpp>
#include <algorithm>
#include <cstring>
#include "src/base/error.hpp"
#include "src/engine/time_step.hpp"
#include "tests/bond_scene.hpp"

using namespace quern;

namespace {

constexpr double tensile = 1e5, shear = 6e4;  // strains of about 1e-4

struct Outcome {
  bool broken;
  std::vector<BondFailure> failures;
};

// Two grains, one clamped; the other is loaded ever more slowly up to `force` and `torque` about the middle of the bond.
Outcome loaded(const Vec3& force, const Vec3& torque, const Vec3& along) {
  BondMaterial bond = scene::cement(1e9, 3e8, 0.3);
  bond.strength.tensile = tensile;
  bond.strength.shear = shear;
  Simulation s = scene::bonded_space(bond, 1e-6);
  scene::add_grain(s, Vec3(0.1, 0.2, -0.3));
  scene::add_grain(s, Vec3(0.1, 0.2, -0.3) + scene::spacing * along);
  bond_particles(s.bonds, s.particles, s.domain, 1, 0, 0, 1);
  scene::clamp(s, 0);
  s.start(false);
  const Vec3 about_centre = torque - 0.5 * scene::spacing * along.cross(force);
  constexpr int ramp = 4000, hold = 1000;
  for (int k = 0; k < ramp + hold && s.bonds.failures.empty(); ++k) {
    const double x = std::min(1.0, static_cast<double>(k) / ramp), share = x * x * (3 - 2 * x);
    scene::pull(s, 1, share * force, share * about_centre, k > 0);
    s.step();
  }
  return {s.bonds.damage() > 0, s.bonds.failures};
}

const Vec3 along = Vec3(1, -2, 0.5).normalized(), across = along.cross(Vec3(0.3, 0.2, 1)).normalized();
constexpr double radius = 0.45 * scene::spacing, area = std::numbers::pi * radius * radius;
constexpr double bending_modulus = area * radius / 4, twisting_modulus = area * radius / 2;  // I/R_b, J/R_b

// Fails just above a load, by the mode expected, and not just below it.
void fails_at(const Vec3& force, const Vec3& torque, BondFailureMode mode) {
  CHECK_FALSE(loaded(0.999 * force, 0.999 * torque, along).broken);
  const Outcome above = loaded(1.001 * force, 1.001 * torque, along);
  REQUIRE(above.broken);
  CHECK(above.failures[0].mode == mode);
  const Vec3 middle = Vec3(0.1, 0.2, -0.3) + 0.5 * scene::spacing * along;
  CHECK((vec(above.failures[0].place) - middle).norm() < 1e-3 * scene::spacing);
  CHECK(above.failures[0].first == 0);
  CHECK(above.failures[0].second == 1);
}

}  // namespace

TEST_CASE("a bond fails in pure tension, shear, bending and twist within a thousandth of the closed load") {
  SECTION("tension") {
    fails_at(tensile * area * along, Vec3::Zero(), BondFailureMode::tension);
    const Outcome above = loaded(1.001 * tensile * area * along, Vec3::Zero(), along);
    CHECK(above.failures[0].energy == Approx(0.5 * tensile * tensile / 1e9 * area * scene::spacing).epsilon(2e-3));
  }
  SECTION("shear") { fails_at(shear * area * across, Vec3::Zero(), BondFailureMode::shear); }
  SECTION("bending") { fails_at(Vec3::Zero(), tensile * bending_modulus * across, BondFailureMode::tension); }
  SECTION("twist") { fails_at(Vec3::Zero(), shear * twisting_modulus * along, BondFailureMode::shear); }
  SECTION("tension with bending: the stresses add") {
    fails_at(0.6 * tensile * area * along, 0.4 * tensile * bending_modulus * across, BondFailureMode::tension);
  }
  SECTION("compression with bending: pressure holds the outer fibre together") {
    fails_at(-0.5 * tensile * area * along, 1.5 * tensile * bending_modulus * across, BondFailureMode::tension);
  }
  SECTION("shear with twist") { fails_at(0.3 * shear * area * across, 0.7 * shear * twisting_modulus * along, BondFailureMode::shear); }
}

TEST_CASE("compression alone never fails a bond") { CHECK_FALSE(loaded(-100 * tensile * area * along, Vec3::Zero(), along).broken); }

TEST_CASE("strengths are drawn by pair and seed alone, with the mean and scatter asked for") {
  BondStrength weibull;
  weibull.distribution = StrengthDistribution::weibull;
  weibull.modulus = 5;
  BondStrength normal;
  normal.distribution = StrengthDistribution::normal;
  normal.deviation = 0.2;
  int weaker = 0;
  double sum = 0, squares = 0;
  constexpr int count = 20000;
  for (Index k = 0; k < count; ++k) {
    const double w = strength_factor(weibull, 7, k, 3 * k + 1), n = strength_factor(normal, 7, k, 3 * k + 1);
    weaker += w < 1;
    sum += n, squares += n * n;
    REQUIRE(n > 0);
    REQUIRE(w == strength_factor(weibull, 7, 3 * k + 1, k));
  }
  CHECK(weaker / static_cast<double>(count) == Approx(1 - std::exp(-1.0)).margin(0.012));  // 3.5 standard errors
  CHECK(sum / count == Approx(1).margin(0.005));
  CHECK(std::sqrt(squares / count - sum * sum / count / count) == Approx(0.2).margin(0.004));
  CHECK(strength_factor(weibull, 7, 1, 2) != strength_factor(weibull, 8, 1, 2));
  CHECK(strength_factor({}, 7, 1, 2) == 1);
}

TEST_CASE("a bond that cannot be is refused with a sentence") {
  Simulation s = scene::bonded_space(scene::cement(), 1e-6);
  scene::add_grain(s, Vec3::Zero());
  scene::add_grain(s, Vec3::Zero());
  scene::add_grain(s, Vec3(scene::spacing, 0, 0));
  const auto bond = [&](Index i, Index j) { bond_particles(s.bonds, s.particles, s.domain, i, j, 0, 1); };
  CHECK_THROWS_WITH(bond(1, 1), Catch::Contains("itself"));
  CHECK_THROWS_WITH(bond(0, 1), Catch::Contains("same centre"));
  s.bonds.materials[0].strength.tensile = -1;
  CHECK_THROWS_WITH(bond(0, 2), Catch::Contains("tensile strength is -1; it must be greater than 0"));
  s.bonds.materials[0] = scene::cement();
  s.bonds.materials[0].damping.shear = 2;
  CHECK_THROWS_WITH(bond(0, 2), Catch::Contains("shear damping"));
  s.bonds.materials[0] = scene::cement();
  s.domain.period[0] = 0.02;
  CHECK_THROWS_WITH(bond(0, 2), Catch::Contains("half a period"));
  CHECK_THROWS_AS(bond_particles_nearer_than(s.bonds, s.particles, s.domain, -1e-3, 0, 1), InputError);
  CHECK(s.bonds.empty());
}

TEST_CASE("the time step of bonded grains is limited by the grain that bonds hold most stiffly, and says so") {
  // A contact law too soft to matter.
  Simulation s = scene::free_space({"lead", 11000, 0, 0.3}, scene::linear(1e2, 0.7, 0), 0);
  s.bonds.materials = {scene::cement()};
  for (int k = 0; k < 3; ++k) scene::add_grain(s, Vec3(k * scene::spacing, 0, 0));
  CHECK(time_step_limit(s, 0.01).reason.find("bonds") == std::string::npos);
  for (Index k = 0; k < 2; ++k) bond_particles(s.bonds, s.particles, s.domain, k, k + 1, 0, 1);
  const TimeStepLimit found = time_step_limit(s, 0.01);
  const double stretching = 1e9 / scene::spacing * area, shearing = 0.3 * stretching;
  const double turning = stretching * radius * radius / 4 + shearing * scene::spacing * scene::spacing / 4;
  const double mass = s.particles.velocity[1].w, inertia = s.particles.spin[1].w;
  CHECK(found.limit == Approx(0.4 * std::sqrt(std::min(mass / (2 * stretching), inertia / (2 * turning)))));
  CHECK(found.recommended == Approx(0.5 * found.limit));
  CHECK(found.reason.find("of grain 1") != std::string::npos);
  CHECK(found.reason.find("its bonds") != std::string::npos);
}
