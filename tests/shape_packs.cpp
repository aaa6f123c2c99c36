// What shapes do by eights: the same bits for every instruction set, and the same as one by one.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include "shapes/jacket.hpp"
#include "shapes/superquadric.hpp"
#include "src/base/instruction_set.hpp"
#include "src/base/pack_power.hpp"
#include "src/base/random.hpp"
#include "src/particle/turn_rows.hpp"
#include "src/particle/turning.hpp"

using namespace quern;

TEST_CASE("powers of packs are those of the library of C", "[shape_packs]") {
  RandomStream random(41);
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    double a[portable::lanes], p[portable::lanes], r[portable::lanes];
    for (int lane = 0; lane < portable::lanes; ++lane) a[lane] = std::pow(10.0, random.uniform(-12, 0.4)), p[lane] = random.uniform(0.05, 20);
    portable::store(r, portable::power(portable::load(a), portable::load(p)));
    for (int lane = 0; lane < portable::lanes; ++lane) {
      const double exact = std::pow(a[lane], p[lane]);
      worst = std::max(worst, std::abs(r[lane] / exact - 1) / (2 + std::abs(std::log2(exact))));
    }
  }
  CHECK(worst < 4e-16);  // the product of exponent and logarithm is rounded, and the logarithm off by an ulp or two
}

TEST_CASE("a body in a jacket is farthest from the axis in the same places, to the bit, by every instruction set", "[shape_packs]") {
  RandomStream random(42);
  int found = 0;
  for (int k = 0; k < 1000; ++k) {
    const Rotation turn = Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    const auto own = [&](const Vec3& n) { return triple(Vec3(turn.conjugate() * n)); };
    const double n1 = k % 3 == 0 ? 2 : random.uniform(2, 20), n2 = k % 3 == 0 ? 2 : random.uniform(2, 20);
    const BodyInJacket body{{6e-3, 5e-3, 4e-3}, n1 / (n1 - 1), n2 / (n2 - 1), own(Vec3::UnitX()), own(Vec3::UnitY()), own(Vec3::UnitZ()), 1, 0.025 - random.uniform(3e-3, 8e-3), 8.8e-3, 5e-3};
    FarPlaces expected{}, here{};
    portable::find_far_places(body, 0.025, 0.5, expected);
    found += expected.count;
#if defined(__x86_64__)
    if (supports(InstructionSet::avx2)) {
      here = {};
      avx2::find_far_places(body, 0.025, 0.5, here);
      REQUIRE(std::memcmp(&here, &expected, sizeof here) == 0);
    }
    if (supports(InstructionSet::avx512)) {
      here = {};
      avx512::find_far_places(body, 0.025, 0.5, here);
      REQUIRE(std::memcmp(&here, &expected, sizeof here) == 0);
    }
#endif
  }
  CHECK(found > 500);
}

TEST_CASE("bodies turn by eights as they do alone, to the bit by every instruction set", "[shape_packs]") {
  constexpr double time_step = 1e-4;
  RandomStream random(43);
  Particles start;
  const Superquadric form = make_superquadric({6e-3, 5e-3, 4e-3}, 2, 2);
  for (int k = 0; k < 21; ++k) {
    if (k % 5 == 4)
      start.add_sphere({0, 0, 0}, 5e-3, 2000, 0, 0);
    else
      start.add_shape({0, 0, 0}, form, 1, 1, 2000, 0, 0);
  }
  const auto random_vector = [&](double size) { return Vec3(size * Vec3(random.normal(), random.normal(), random.normal())); };
  for (std::size_t k = 0; k < 21; ++k) {
    const Rotation q = Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    start.orientation[k] = {q.x(), q.y(), q.z(), q.w()};
    set(start.momentum[k], random_vector(k == 3 ? 1e-3 : 1e-6));  // one turns by more than the series of the sine are for
    set(start.angular_acceleration[k], random_vector(1e-5));
    set(start.velocity[k], random_vector(1));
  }
  const std::vector<Quad> before = start.orientation;
  Particles expected = start;
  portable::turn_shapes(expected, 0, 21, before.data(), time_step);
  for (std::size_t k = 0; k < 21; ++k) {
    if (start.shape[k] == 0) {
      CHECK(std::memcmp(&expected.orientation[k], &before[k], sizeof(Quad)) == 0);
      continue;
    }
    const Rotation q = turned_freely(rotation_of(before[k]), vec(start.momentum[k]) + 0.5 * time_step * vec(start.angular_acceleration[k]), vec(start.inertia[k]), time_step);
    CHECK((q.coeffs() - rotation_of(expected.orientation[k]).coeffs()).norm() < 1e-15);
    CHECK((spin_of(q, vec(expected.momentum[k]), vec(start.inertia[k])) - vec(expected.spin[k])).norm() <= 1e-13 * vec(expected.spin[k]).norm());
    CHECK(expected.momentum[k].w > 0);
  }
  const auto same = [&](auto turn) {
    Particles here = start;
    turn(here, 0, 21, before.data(), time_step);
    for (const auto rows : {&Particles::orientation, &Particles::momentum, &Particles::spin}) REQUIRE(std::memcmp((here.*rows).data(), (expected.*rows).data(), 21 * sizeof(Quad)) == 0);
  };
#if defined(__x86_64__)
  if (supports(InstructionSet::avx2)) same(avx2::turn_shapes);
  if (supports(InstructionSet::avx512)) same(avx512::turn_shapes);
#endif
}
