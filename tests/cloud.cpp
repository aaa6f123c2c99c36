// Clouds of balls: conservation, neighbour search, and the same bits however they are computed.
#include <catch2/catch.hpp>
#include <cstring>
#include <set>
#include "src/base/random.hpp"
#include "src/contact/cell_grid.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

// Balls flying into each other from everywhere; sizes spread by `ratio`.
Simulation cloud(int count, double ratio, bool periodic, int threads = 1) {
  const Material soft{"soft", 2500, 5e7, 0.3};
  PairLaw law = scene::hertz(soft, soft, 0.7, 0.5);
  law.rolling = {RollingModel::elastic_plastic, 0.05, 0.3};
  Simulation s = scene::free_space(soft, law, 2e-6);
  RandomStream random(11);
  const double side = 0.0022 * std::cbrt(count) * (1 + 0.2 * (ratio - 1));
  while (s.particles.size() < count) {
    const double radius = 0.001 * std::pow(ratio, random.uniform());
    const Triple<double> x{random.uniform(0, side), random.uniform(0, side), random.uniform(0, side)};
    scene::add_ball(s, x, radius, {(0.5 * side - x.x) * 300, (0.5 * side - x.y) * 300, random.uniform(-1, 1)},
                    {random.uniform(-99, 99), random.uniform(-99, 99), random.uniform(-99, 99)});
    // No deep overlaps at the start.
    const Quad here = s.particles.position.back();
    for (std::size_t k = 0; k + 1 < s.particles.position.size(); ++k) {
      const Triple<double> d = xyz(here) - xyz(s.particles.position[k]);
      if (length(d) < 0.99 * (here.w + s.particles.position[k].w)) {
        s.particles.position.back().z += side;
        break;
      }
    }
  }
  if (periodic)
    for (double& period : s.domain.period) period = 2.5 * side;
  s.team = std::make_shared<ThreadTeam>(threads);
  return s;
}

struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double scale_linear = 0, scale_angular = 0;
};

Momentum momentum(const Simulation& s) {
  Momentum m;
  for (std::size_t k = 0; k < s.particles.position.size(); ++k) {
    const Vec3 p = s.particles.velocity[k].w * vec(s.particles.velocity[k]);
    const Vec3 l = vec(s.particles.position[k]).cross(p) + s.particles.spin[k].w * vec(s.particles.spin[k]);
    m.linear += p, m.angular += l;
    m.scale_linear += p.norm(), m.scale_angular += l.norm();
  }
  return m;
}

// Positions, velocities and spins by id, as bytes.
std::vector<double> state(const Simulation& s) {
  std::vector<double> all(s.particles.id.size() * 9);
  for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
    double* to = &all[static_cast<std::size_t>(s.particles.id[k]) * 9];
    for (const Quad& q : {s.particles.position[k], s.particles.velocity[k], s.particles.spin[k]}) *to++ = q.x, *to++ = q.y, *to++ = q.z;
  }
  return all;
}

}  // namespace

TEST_CASE("an isolated cloud keeps its linear and angular momentum to rounding") {
  Simulation s = cloud(400, 3, false);
  s.start(false);
  const Momentum before = momentum(s);
  for (int k = 0; k < 2000; ++k) s.step();
  const Momentum after = momentum(s);
  CHECK((after.linear - before.linear).norm() / before.scale_linear < 1e-12);
  CHECK((after.angular - before.angular).norm() / before.scale_angular < 1e-12);
  CHECK(s.ledger.dissipated() > 0);  // it did collide
}

TEST_CASE("the ledger of a colliding cloud closes") {
  Simulation s = cloud(400, 3, true);
  s.start(true);
  double event_loss = 0;
  const auto count = [&](const std::vector<Collision>& list) {
    for (const Collision& c : list) event_loss += c.record.normal_loss + c.record.tangential_loss;
  };
  for (int k = 0; k < 3000; ++k) {
    s.step();
    count(s.ended_collisions());
  }
  s.measure_energy();
  CHECK(s.ledger.dissipated() > 0.1 * s.ledger.stored_at_start);
  CHECK(std::abs(s.ledger.closure()) < 1e-3);
  // Every loss belongs to a collision.
  count(s.lasting_collisions());
  CHECK(event_loss == Approx(s.ledger.dissipated()).epsilon(1e-9));
}

TEST_CASE("the neighbour search finds every pair, for sizes 1:10, open and periodic") {
  for (const bool periodic : {false, true})
    for (const double ratio : {1.0, 10.0}) {
      CAPTURE(periodic, ratio);
      Simulation s = cloud(600, ratio, periodic);
      if (periodic)
        for (double& period : s.domain.period) period *= 0.45;
      s.start(false);
      for (int k = 0; k < 50; ++k) s.step();
      std::set<std::pair<Index, Index>> listed;
      for (const ContactBlock& block : s.contacts.blocks)
        for (const CandidateList& list : block.candidates)
          for (std::size_t k = 0; k < static_cast<std::size_t>(list.count); ++k) listed.insert({block.row_of(list.first[k]), block.row_of(list.second[k])});
      std::size_t missed = 0, touching = 0;
      for (Index i = 0; i < s.particles.size(); ++i)
        for (Index j = i + 1; j < s.particles.size(); ++j) {
          const Quad &a = s.particles.position[static_cast<std::size_t>(i)], &b = s.particles.position[static_cast<std::size_t>(j)];
          const bool touches = length(s.domain.nearest(xyz(a) - xyz(b))) < a.w + b.w;
          touching += touches;
          missed += touches && !listed.contains({i, j});
        }
      CHECK(touching > 20);
      CHECK(missed == 0);
    }
}

TEST_CASE("the same bits for 1, 2, 3 and 4 threads and for every instruction set") {
  std::vector<double> first;
  Ledger ledger;
  const auto run = [&](int threads, const Kernels* kernels) {
    Simulation s = cloud(3000, 2, true, threads);
    s.kernels = kernels;
    s.start(true);
    for (int k = 0; k < 150; ++k) s.step();
    s.measure_energy();
    ledger = s.ledger;
    return state(s);
  };
  first = run(1, &portable::kernels);
  const Ledger first_ledger = ledger;
  const auto same = [&](const std::vector<double>& other) {
    return std::memcmp(first.data(), other.data(), first.size() * sizeof(double)) == 0 && std::memcmp(&ledger, &first_ledger, sizeof ledger) == 0;
  };
  for (const int threads : {2, 3, 4}) CHECK(same(run(threads, &portable::kernels)));
  for (const char* name : {"avx2", "avx512"})
    if (const Kernels* kernels = find_kernels(name)) {
      CAPTURE(name);
      CHECK(same(run(1, kernels)));
    }
}
