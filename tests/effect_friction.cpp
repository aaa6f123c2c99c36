// Effects across the normal: rigid and compliant friction, torsion; and that effects leave the bits of a run to the case alone.
#include <catch2/catch.hpp>
#include <cstring>
#include "src/engine/checkpoint.hpp"
#include "tests/effect_scene.hpp"

using namespace quern;
using namespace effect_scene;

namespace {

struct Oblique {
  double tangential, spin, closure;
};

Oblique impact(const PairLaw& pair, double sideways, double divisions = 400) {
  const double speed = 1;
  Simulation s = scene::free_space(scene::glass(), pair, collide_head_on(pair, radius, ball_mass(), speed).duration / divisions);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + 2.5 * speed * s.clock.time_step}, radius, {sideways, 0, -speed});
  s.start(false);
  const double before = scene::kinetic_energy(s);
  scene::run_collision(s);
  const double after = scene::kinetic_energy(s);
  return {s.particles.velocity[0].x, s.particles.spin[0].y, (before - after - s.ledger.dissipated()) / before};
}

std::vector<PairLaw> every_law(double friction) {
  const Material glass = scene::glass();
  const double young = effective_young(glass, glass);
  return {scene::linear(1e8, 0.8, friction), scene::hertz(glass, glass, 0.8, friction),
          {Deresiewicz{young, deresiewicz_damping_modulus(young, 0.8, radius, ball_mass(), 1), friction * 1.78 / 1.56, friction}, {}},
          {PowerLaw{1e11, 1.5, 2e4, 0.5, 1e8, friction}, {}}, {Linearized{1e8, 10, 6e7, friction}, {}}};
}

}  // namespace

// Coulomb friction without a spring: gross sliding takes μ(1+e)v_n, and less sliding ends in rolling, at 5/7 of the speed.
TEST_CASE("rigid friction gives the closed rebound of sliding and of sticking, with every law", "[effects]") {
  const double friction = 0.2;
  for (PairLaw pair : every_law(friction)) {
    pair.extras.tangential_compliance = 0;
    const double e = collide_head_on(pair, radius, ball_mass(), 1).restitution;
    CAPTURE(pair.law.index());
    const Oblique sliding = impact(pair, 3);
    CHECK(sliding.tangential == Approx(3 - friction * (1 + e)).epsilon(1e-3));
    CHECK(sliding.spin * radius == Approx(2.5 * friction * (1 + e)).epsilon(2e-3));
    CHECK(std::abs(sliding.closure) < 1e-3);
    const Oblique sticking = impact(pair, 0.4);
    CHECK(sticking.tangential == Approx(0.4 * 5 / 7).epsilon(2e-3));
    CHECK(sticking.spin * radius == Approx(sticking.tangential).epsilon(5e-3));
    CHECK(std::abs(sticking.closure) < 1e-3);
  }
}

TEST_CASE("rigid friction holds a ball without creep on a slope that friction can hold and lets it slide on a steeper one", "[effects]") {
  PairLaw pair = scene::linear(1e5, 0.3, 0.3);
  pair.extras.tangential_compliance = 0;
  for (const double slope : {0.2, 0.6}) {
    // It rolls with a = 5/7 g sin α while it sticks, which takes 2/7 of the pull.
    Simulation s = scene::free_space(scene::glass(), pair, 1e-6);
    scene::add_floor(s);
    s.gravity = 9.81 * Vec3(std::sin(slope), 0, -std::cos(slope));
    scene::add_ball(s, {0, 0, radius}, radius, {0, 0, 0});
    s.start(false);
    for (int k = 0; k < 100000; ++k) s.step();
    const double v = s.particles.velocity[0].x, w = s.particles.spin[0].y;
    const double held = 9.81 * std::sin(slope) * 0.1, friction = 0.3 * 9.81 * std::cos(slope) * 0.1;
    CAPTURE(slope, v, w);
    if (2.0 / 7 * held < friction) {
      CHECK(v == Approx(5.0 / 7 * held).epsilon(1e-3));
      CHECK(v - radius * w == Approx(0).margin(1e-4 * v));
    } else {
      CHECK(v == Approx(held - friction).epsilon(2e-3));
    }
  }
}

// A half swing of the linear tangential spring: a contact that sticks all through reverses the slip of the contact point by what the ratio of
// the two periods says. m_t = 2/7 m: ω_t/ω_n = √(7/2 k_t/(κ k_n)); slip after = slip before × cos(π ω_t/ω_n).
TEST_CASE("tangential compliance sets the swing of a sticking impact", "[effects]") {
  for (const double compliance : {0.5, 1.0, 2.0, 6.0}) {
    PairLaw pair = scene::linear(1e8, 1.0, 1e3);
    pair.extras.tangential_compliance = compliance;
    const double ratio = std::sqrt(3.5 * (2.0 / 7) / compliance);
    const Oblique o = impact(pair, 0.1, 2000);
    CAPTURE(compliance);
    CHECK((o.tangential - radius * o.spin) / 0.1 == Approx(std::cos(3.14159265358979 * ratio)).margin(5e-3));
    CHECK(std::abs(o.closure) < 1e-3);
  }
  // Hertz and Deresiewicz: a spring softer by κ is that of a material of G/κ.
  PairLaw soft = scene::hertz(scene::glass(), scene::glass(), 0.9, 0.4), same = soft;
  soft.extras.tangential_compliance = 3;
  std::get<HertzMindlin>(same.law).effective_shear /= 3;
  const Oblique a = impact(soft, 0.5), b = impact(same, 0.5);
  CHECK(a.tangential == Approx(b.tangential).epsilon(1e-4));
  CHECK(a.spin == Approx(b.spin).epsilon(1e-4));
}

TEST_CASE("a spinning ball on a floor comes to rest by torsion in the closed time and stays so", "[effects]") {
  const double coefficient = 0.1, spin = 30;
  PairLaw pair = scene::linear(1e5, 0.3, 0.3);
  pair.extras.torsion.coefficient = coefficient;
  Simulation s = scene::free_space(scene::glass(), pair, 2e-6);
  scene::add_floor(s);
  s.gravity = {0, 0, -9.81};
  scene::add_ball(s, {0, 0, radius - ball_mass() * 9.81 / 1e5}, radius, {0, 0, 0}, {0, 0, spin});
  s.start(false);
  const double before = scene::kinetic_energy(s);
  // I dω/dt = −μ_t R m g, I = 2/5 m R²
  const double time = 0.4 * radius * spin / (coefficient * 9.81);
  const int steps = static_cast<int>(time / s.clock.time_step);
  for (int k = 0; k < steps / 2; ++k) s.step();
  CHECK(s.particles.spin[0].z == Approx(0.5 * spin).epsilon(1e-3));
  for (int k = steps / 2; k < steps + 100; ++k) s.step();
  CHECK(s.particles.spin[0].z == Approx(0).margin(1e-3 * spin));
  CHECK(s.ledger.rolling_loss == Approx(0.2 * ball_mass() * radius * radius * spin * spin).epsilon(1e-3));
  CHECK(std::abs(before - scene::kinetic_energy(s) - s.ledger.dissipated()) < 1e-3 * before);
}

namespace {

// Wet, sticky, yielding balls of two sizes in a turning periodic drum, everything switched on that goes together.
Simulation drum(int threads, const Kernels* kernels) {
  const Material steel{"steel", 7800, 5e7, 0.3};
  PairLaw law = scene::hertz(steel, steel, 0.6, 0.5);
  law.rolling = {RollingModel::elastic_plastic, 0.02, 0.3};
  Extras& x = law.extras;
  x.restitution = {0.2, 0.6, 0.5, SpeedRestitution::Mapping::hertz};
  x.viscoelastic_time = 1e-6;
  x.stiffening.hardening = 100;
  x.plastic.unloading_slope = 1.2;
  x.adhesion = {0.05, effective_young(steel, steel)};
  x.wave_admittance = 1e-3;
  x.torsion.coefficient = 0.02;
  x.lubrication = {1e-3, 1e-4, 2e-5};
  x.bridge = {1e-11, 0.07, 0.3};
  x.table.points = 3;
  for (int k = 0; k < 3; ++k) x.table.at[k] = 1e-5 * k, x.table.force[k] = 1e-3 * k * k;
  x.tangential_compliance = 0;
  Simulation s = scene::free_space(steel, law, 2e-5);
  s.gravity = Vec3(0, -9.81, 0);
  s.domain.period[2] = 0.06;
  s.frames = {{"drum", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), 9.0}}};
  Wall shell;
  shell.surface = Revolved{0.05, -1, 0.05, 1, Revolved::Side::inside};
  shell.frame = 0;
  s.walls.push_back(shell);
  for (int x_ = -3; x_ <= 3; ++x_)
    for (int y = -3; y <= 3; ++y)
      for (int z = 0; z < 5; ++z) scene::add_ball(s, {0.0101 * x_ + 1e-4 * z, 0.0101 * y, 0.012 * z}, (x_ + y) % 2 ? 0.005 : 0.0035, {0, 0, 0.1 * x_});
  s.team = std::make_shared<ThreadTeam>(threads);
  if (kernels) s.kernels = kernels;
  return s;
}

std::string state_of(Simulation& s) {
  return ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
}

}  // namespace

TEST_CASE("effects give the same bits on any threads and instruction set, and through a checkpoint amid contacts", "[effects]") {
  Simulation first = drum(1, nullptr);
  first.start(true);
  for (int k = 0; k < 1500; ++k) first.step();
  const std::string middle = state_of(first);
  for (int k = 0; k < 1500; ++k) first.step();
  CHECK(first.contacts.sums.pair_contacts > 20);
  CHECK(first.contacts.sums.wall_contacts > 5);
  first.measure_energy();
  CHECK(std::abs(first.ledger.closure()) < 1e-3);
  const std::string end = state_of(first);
  for (const char* name : {"portable", "avx2", "avx512"}) {
    const Kernels* kernels = find_kernels(name);
    if (!kernels) continue;
    CAPTURE(name);
    Simulation other = drum(2, kernels);
    other.start(true);
    for (int k = 0; k < 3000; ++k) other.step();
    other.measure_energy();
    CHECK((state_of(other) == end));
  }
  Simulation resumed = drum(2, nullptr);
  resumed.start(true);
  ArchiveReader reader(middle);
  archive_state(reader, resumed);
  for (int k = 0; k < 1500; ++k) resumed.step();
  resumed.measure_energy();
  CHECK((state_of(resumed) == end));
}
