// Bodies of bonded grains: carried and spun they store nothing, they keep momentum, their ledger closes through breakage, and they
// break alike with any number of threads and across a checkpoint.
#include <catch2/catch.hpp>
#include <cstring>
#include "src/base/random.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/engine/time_step.hpp"
#include "tests/bond_scene.hpp"

using namespace quern;

namespace {

// A sphere's worth of a close packing of touching grains.
Simulation cluster(const BondMaterial& material, double across, double time_step) {
  Simulation s = scene::bonded_space(material, time_step);
  const Vec3 a(1, 0, 0), b(0.5, std::sqrt(0.75), 0), c(0.5, std::sqrt(1.0 / 12), std::sqrt(2.0 / 3));
  const int n = static_cast<int>(2 * across);
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k)
        if (const Vec3 x = i * a + j * b + k * c; x.norm() < across) scene::add_grain(s, scene::spacing * x);
  bond_particles_nearer_than(s.bonds, s.particles, s.domain, 0.2 * scene::spacing, 0, 1);
  return s;
}

void set_motion(Simulation& s, const Vec3& velocity, const Vec3& spin) {
  for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
    set(s.particles.velocity[k], velocity + spin.cross(vec(s.particles.position[k])));
    set(s.particles.spin[k], spin);
  }
}

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double linear_scale = 0, angular_scale = 0;
};

Momenta momenta(const Simulation& s) {
  Momenta m;
  const Particles& p = s.particles;
  for (std::size_t k = 0; k < p.id.size(); ++k) {
    const Vec3 momentum = p.velocity[k].w * vec(p.velocity[k]), orbit = vec(p.position[k]).cross(momentum),
               own = p.spin[k].w * vec(p.spin[k]);
    m.linear += momentum;
    m.angular += orbit + own;
    m.linear_scale += momentum.norm();
    m.angular_scale += orbit.norm() + own.norm();
  }
  return m;
}

double stable_step(const Simulation& s) { return time_step_limit(s, 1).recommended; }

}  // namespace

TEST_CASE("a cluster carried and spun rigidly through a million steps stores nothing and breaks no bond") {
  BondMaterial material = scene::cement(1e9, 3e8, 0.05);
  material.strength.tensile = material.strength.shear = 1e7;  // a strain of a hundredth
  Simulation s = cluster(material, 1.1, 4e-6);
  REQUIRE(s.bonds.list.size() == 36);
  set_motion(s, Vec3(0.3, -0.7, 0.2), Vec3(2, 3, -4));
  s.start(false);
  const double failure = scene::failure_energy(s.bonds.list[0]);
  double most = 0;
  for (int k = 0; k < 1000000; ++k) {
    s.step();
    most = std::max(most, s.ledger.bond_energy);
  }
  s.measure_energy();
  CHECK(most < 1e-10 * failure);  // with what the centrifugal force rightly stores
  CHECK(std::abs(s.ledger.gap()) < 1e-10 * failure);
  CHECK(s.bonds.damage() == 0);
  double worst = 0;
  for (const Quad& q : s.particles.orientation)
    worst = std::max(worst, std::abs(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) - 1));
  CHECK(worst < 1e-12);
}

TEST_CASE("any rigid placing of a body leaves its bonds without load") {
  Simulation s = cluster(scene::cement(), 1.1, 1e-6);
  RandomStream random(3);
  const auto one = [&] { return random.uniform(-1, 1); };
  for (int trial = 0; trial < 20; ++trial) {
    const Rotation turn = Rotation(one(), one(), one(), one()).normalized();
    const Vec3 shift(one(), one(), one());
    Simulation placed = s;
    for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
      set(placed.particles.position[k], turn * (vec(s.particles.position[k]) - shift));
      placed.particles.orientation[k] = {turn.x(), turn.y(), turn.z(), turn.w()};
    }
    placed.start(false);
    // Places are known to 1e-16 m, so strains to 1e-14; k_bn A L_0 is 6e4 N, its energy 640 J.
    CHECK(placed.ledger.bond_energy < 1e-26 * 640 * 36);
    for (const Load& load : placed.contacts.blocks[0].load) CHECK(length(xyz(load.force)) < 1e-12 * 6e4);
  }
}

TEST_CASE("orientations turn with second order") {
  const auto error_after_turning = [](int steps) {
    Simulation s = scene::free_space(scene::glass(), scene::linear(1e5, 0.7, 0), 1.0 / steps);
    scene::add_ball(s, {0, 0, 0}, 0.01, {0, 0, 0}, {0, 0, 0});
    s.particles.keep_orientations();
    s.start(false);
    // Spun up about z at a growing rate, ω = t²: in the end it has turned by a third.
    for (int k = 0; k < steps; ++k) {
      const double t = s.clock.time(), next = t + s.clock.time_step;
      s.particles.spin[0].z = t * t;
      s.particles.angular_acceleration[0].z = (next * next - t * t) / s.clock.time_step;
      s.step();
    }
    const Quad& q = s.particles.orientation[0];
    return std::abs(2 * std::atan2(q.z, q.w) - 1.0 / 3);
  };
  const double coarse = error_after_turning(20), fine = error_after_turning(40);
  CHECK(fine < 2e-4);
  CHECK(coarse / fine == Approx(4).epsilon(0.05));
}

TEST_CASE("a free body that shakes itself to pieces keeps its momentum and its angular momentum") {
  BondMaterial material = scene::cement(1e9, 3e8, 0.1);
  material.strength.tensile = material.strength.shear = 6e5;
  Simulation s = cluster(material, 3, 0);
  s.clock.time_step = stable_step(s);
  RandomStream random(5);
  for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
    const auto one = [&] { return random.normal(); };
    set(s.particles.velocity[k], 1.0 * Vec3(one(), one(), one()) + Vec3(1, 2, 3));
    set(s.particles.spin[k], 50.0 * Vec3(one(), one(), one()));
  }
  s.start(false);
  const Momenta before = momenta(s);
  for (int k = 0; k < 1000; ++k) s.step();
  const Momenta after = momenta(s);
  CHECK(s.bonds.damage() > 0.05);
  CHECK(s.bonds.damage() < 1);
  CHECK((after.linear - before.linear).norm() < 1e-12 * before.linear_scale);
  CHECK((after.angular - before.angular).norm() < 1e-12 * before.angular_scale);
  s.measure_energy();
  CAPTURE(s.ledger.gap(), s.ledger.bond_failure, s.ledger.bond_loss, s.ledger.stored_at_start);
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
}

TEST_CASE("grains bonded while they overlap lie at rest, and after the bond has failed they still do") {
  Simulation s = scene::free_space(scene::glass(), scene::linear(1e6, 0.7, 0.3), 1e-6);
  s.bonds.materials = {scene::cement()};
  s.bonds.materials[0].strength.tensile = s.bonds.materials[0].strength.shear = 1e5;
  const double r = 0.005;
  scene::add_ball(s, {0, 0, 0}, r, {0, 0, 0});
  scene::add_ball(s, {1.9 * r, 0, 0}, r, {0, 0, 0});
  scene::add_ball(s, {3.95 * r, 0, 0}, r, {0, 0, 0});
  CHECK(bond_particles_nearer_than(s.bonds, s.particles, s.domain, 0.1 * r, 0, 1) == 2);
  CHECK(bond_particles_nearer_than(s.bonds, s.particles, s.domain, 0.1 * r, 0, 1) == 0);
  s.start(false);
  for (int k = 0; k < 100; ++k) s.step();
  CHECK(scene::kinetic_energy(s) < 1e-20);
  CHECK(s.contacts.sums.pair_contacts == 0);
  // Pulled apart until it fails, then pushed together: the contact takes the push from where they were bonded.
  s.particles.velocity[scene::row_of(s, 0)].x = -1;
  for (int k = 0; k < 20; ++k) s.step();
  REQUIRE(s.bonds.list[0].state == BondState::broken);
  CHECK(s.particles.position[scene::row_of(s, 1)].x - s.particles.position[scene::row_of(s, 0)].x < 2 * r);
  for (const Index id : {0, 1}) s.particles.velocity[scene::row_of(s, id)].x = id == 0 ? 0.1 : 0;
  bool met = false;
  for (int k = 0; k < 2000; ++k) {
    s.step();
    const double distance = s.particles.position[scene::row_of(s, 1)].x - s.particles.position[scene::row_of(s, 0)].x;
    if (s.contacts.sums.pair_contacts == 0) continue;
    met = true;
    REQUIRE(distance < 1.9 * r + 1e-12);
  }
  CHECK(met);
  s.measure_energy();
  CHECK(s.bonds.list[0].state != BondState::intact);
}

namespace {

// A block of some thousand grains, periodic along y, that hits a floor and breaks.
Simulation falling_block(int threads) {
  BondMaterial material = scene::cement(2e9, 8e8, 0.1);
  material.strength.tensile = 1e6;
  material.strength.shear = 1.5e6;
  material.strength.distribution = StrengthDistribution::weibull;
  material.strength.modulus = 4;
  Simulation s = scene::free_space(scene::glass(), scene::linear(2e6, 0.7, 0.4), 0);
  s.bonds.materials = {material};
  s.gravity = Vec3(0, 0, -9.81);
  scene::add_floor(s);
  RandomStream random(11);
  const double a = scene::spacing;
  s.domain.period[1] = 10 * a;
  for (int z = 0; z < 10; ++z)
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 10; ++x) {
        const auto shake = [&] { return 0.03 * a * random.uniform(-1, 1); };
        scene::add_ball(s, {x * a + shake(), (y + 0.5) * a + shake(), (z + 0.55) * a + shake()}, 0.5 * a, {0.5, 0, -6});
      }
  bond_particles_nearer_than(s.bonds, s.particles, s.domain, 0.1 * a, 0, 42);
  s.clock.time_step = stable_step(s);
  s.team = std::make_shared<ThreadTeam>(threads);
  return s;
}

std::string pack_state(Simulation& s) {
  return ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
}

}  // namespace

TEST_CASE("a block that breaks on a floor: the ledger closes, and threads, instruction sets and a checkpoint change no bit") {
  constexpr int steps = 700;
  const auto run = [](Simulation& s, int count) {
    for (int k = 0; k < count; ++k) s.step();
  };
  Simulation alone = falling_block(1);
  REQUIRE(alone.bonds.list.size() > 2700);
  alone.start(false);
  run(alone, steps / 2);
  const std::string halfway = pack_state(alone);
  run(alone, steps / 2);
  const std::string end = pack_state(alone);
  alone.measure_energy();
  CAPTURE(alone.bonds.damage(), alone.ledger.closure(), alone.contacts.searches, alone.contacts.blocks.size());
  CHECK(alone.bonds.damage() > 0.1);
  CHECK(alone.bonds.damage() < 0.9);
  CHECK(std::abs(alone.ledger.closure()) < 1e-3);
  CHECK(alone.contacts.blocks.size() > 2);
  for (const int threads : {2, 4}) {
    Simulation s = falling_block(threads);
    s.start(false);
    run(s, steps);
    CHECK((pack_state(s) == end));
  }
  for (const char* isa : {"portable", "avx2"})
    if (const Kernels* kernels = find_kernels(isa)) {
      Simulation s = falling_block(1);
      s.kernels = kernels;
      s.start(false);
      run(s, 150);
      Simulation best = falling_block(1);
      best.start(false);
      run(best, 150);
      CHECK((pack_state(s) == pack_state(best)));
    }
  Simulation resumed = falling_block(2);
  resumed.start(false);
  ArchiveReader reader(halfway);
  archive_state(reader, resumed);
  run(resumed, steps / 2);
  CHECK((pack_state(resumed) == end));
}
