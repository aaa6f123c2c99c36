// Chains of bonded grains are Timoshenko beams: stretched, bent, swinging.
//
// Grains of mass m at spacing L_0, joined by bonds whose springs sit in the middle between centres, have as limit a beam of bending
// stiffness E_b I, shear stiffness G_b A (k_bs A L_0), mass m/L_0 and rotary inertia I_grain/L_0 per length. With the centre of the first
// grain held, sums over springs are midpoint rules: errors fall with the square of L_0. The last grain reaches half a spacing beyond its
// centre: a beam of N grains that swings is (N + ½) L_0 long.
#include <catch2/catch.hpp>
#include <array>
#include "src/engine/time_step.hpp"
#include "tests/bond_scene.hpp"

using namespace quern;

namespace {

constexpr double young = 1e9, stiffness_in_shear = 3e8, radius = 0.45 * scene::spacing, dt = 3.5e-6;
constexpr double area = std::numbers::pi * radius * radius, second_moment = area * radius * radius / 4;
constexpr double bending = young * second_moment, shearing = stiffness_in_shear * area;

// A clamped grain and `grains` free ones along x.
Simulation chain(int grains) {
  Simulation s = scene::bonded_space(scene::cement(young, stiffness_in_shear), dt);
  for (int k = 0; k <= grains; ++k) scene::add_grain(s, Vec3(k * scene::spacing, 0, 0));
  for (Index k = 0; k < grains; ++k) bond_particles(s.bonds, s.particles, s.domain, k, k + 1, 0, 1);
  scene::clamp(s, 0);
  s.start(false);
  return s;
}

double line_mass(const Simulation& s) { return s.particles.velocity[scene::row_of(s, 1)].w / scene::spacing; }
double line_inertia(const Simulation& s) { return s.particles.spin[scene::row_of(s, 1)].w / scene::spacing; }

double bernoulli_frequency(double length, double mass) { return 3.5160153 / (length * length) * std::sqrt(bending / mass); }

// det of the free end's moment and shear force for a swing at ω: zero at the natural frequencies.
double end_determinant(double omega, double length, double mass, double inertia) {
  using State = std::array<double, 4>;  // y, φ, M, V
  const auto slope = [&](const State& s) {
    return State{s[1] + s[3] / shearing, s[2] / bending, -s[3] - inertia * omega * omega * s[1], -mass * omega * omega * s[0]};
  };
  const auto shoot = [&](State s) {
    constexpr int steps = 400;
    const double h = length / steps;
    const auto moved = [](const State& a, double by, const State& b) {
      return State{a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2], a[3] + by * b[3]};
    };
    for (int k = 0; k < steps; ++k) {
      const State a = slope(s), b = slope(moved(s, h / 2, a)), c = slope(moved(s, h / 2, b)), d = slope(moved(s, h, c));
      for (std::size_t i = 0; i < 4; ++i) s[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    }
    return s;
  };
  const State p = shoot({0, 0, 1, 0}), q = shoot({0, 0, 0, 1});
  return p[2] * q[3] - q[2] * p[3];
}

double timoshenko_frequency(double length, double mass, double inertia) {
  double low = 0.7 * bernoulli_frequency(length, mass), high = 1.02 * bernoulli_frequency(length, mass);
  const bool sign = end_determinant(low, length, mass, inertia) > 0;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (end_determinant(middle, length, mass, inertia) > 0 == sign ? low : high) = middle;
  }
  return low;
}

double tip_height(const Simulation& s, int grains) { return s.particles.position[scene::row_of(s, grains)].y; }

// Rotation of a particle about z.
double tip_angle(const Simulation& s, int grains) {
  const Quad& q = s.particles.orientation[scene::row_of(s, grains)];
  return 2 * std::atan2(q.z, q.w);
}

struct Errors {
  double force_deflection, end_moment, moment_deflection, moment_angle, frequency;
};

Errors cantilever(int grains) {
  const double length = grains * scene::spacing;
  Simulation s = chain(grains);
  const double mass = line_mass(s), omega = bernoulli_frequency(length, mass);
  const auto settle = [&](const Vec3& force, const Vec3& torque) {
    const int steps = static_cast<int>(16 / (omega * dt));
    for (int k = 0; k < steps; ++k) {
      s.step();
      scene::pull(s, grains, force, torque, true);
      scene::slow_all(s, 2 * omega);
    }
  };
  const double far = 1e-3 * length, force = far * 3 * bending / (length * length * length), moment = far * 2 * bending / (length * length);
  Errors e{};
  settle(Vec3::Zero(), Vec3(0, 0, moment));
  e.moment_deflection = tip_height(s, grains) / (moment * length * length / (2 * bending)) - 1;
  e.moment_angle = tip_angle(s, grains) / (moment * length / bending) - 1;

  settle(Vec3(0, force, 0), Vec3::Zero());
  e.force_deflection = tip_height(s, grains) / (force * length * length * length / (3 * bending) + force * length / shearing) - 1;
  const Load& held = s.contacts.blocks[0].load[scene::row_of(s, 0)];
  e.end_moment = held.torque.z / (force * length) - 1;

  // Let go: the first mode swings; its shape sorts it out from the others.
  std::vector<double> shape;
  for (int k = 0; k <= grains; ++k) {
    const double x = 1.8751041 * k / (grains + 0.5);
    shape.push_back(std::cosh(x) - std::cos(x) - 0.7340955 * (std::sinh(x) - std::sin(x)));
  }
  double before = 0, first = 0, last = 0;
  int crossings = 0;
  while (crossings < 5) {
    s.step();
    double swing = 0;
    for (std::size_t row = 0; row < s.particles.id.size(); ++row)
      swing += shape[static_cast<std::size_t>(s.particles.id[row])] * s.particles.position[row].y;
    if (before != 0 && (swing > 0) != (before > 0)) {
      last = s.clock.time() - dt * swing / (swing - before);
      if (crossings++ == 0) first = last;
    }
    before = swing;
  }
  const double measured = std::numbers::pi * (crossings - 1) / (last - first);
  e.frequency = measured / timoshenko_frequency(length + 0.5 * scene::spacing, mass, line_inertia(s)) - 1;
  return e;
}

}  // namespace

TEST_CASE("a cantilever of 10, 20 and 40 bonded grains is Timoshenko's within a hundredth, and nearer with each halving") {
  std::vector<Errors> errors;
  for (const int grains : {10, 20, 40}) {
    errors.push_back(cantilever(grains));
    const Errors& e = errors.back();
    CAPTURE(grains, e.force_deflection, e.end_moment, e.moment_deflection, e.moment_angle, e.frequency);
    CHECK(std::abs(e.force_deflection) < 0.01);
    CHECK(std::abs(e.end_moment) < 0.01);
    CHECK(std::abs(e.moment_deflection) < 0.01);
    CHECK(std::abs(e.moment_angle) < 0.01);
    CHECK(std::abs(e.frequency) < 0.01);
  }
  // The midpoint rule's error of ∫(L − x)² dx is a quarter of 1/N² of it.
  CHECK(errors[0].force_deflection == Approx(-0.25 / 100).epsilon(0.1));
  for (std::size_t k = 1; k < errors.size(); ++k) {
    CHECK(errors[k].force_deflection == Approx(0.25 * errors[k - 1].force_deflection).epsilon(0.2));
    CHECK(std::abs(errors[k].frequency) < 0.5 * std::abs(errors[k - 1].frequency));
  }
}

TEST_CASE("a pulse runs along a bonded rod at √(E/ρ), through grains that no search finds near each other") {
  // Small grains, far apart, in several blocks.
  constexpr int grains = 700;
  BondMaterial material = scene::cement(young, stiffness_in_shear);
  material.radius_ratio = 3;
  Simulation s = scene::bonded_space(material, 0);
  for (int k = 0; k <= grains; ++k) scene::add_ball(s, {k * scene::spacing, 0, 0}, radius / 3, {0, 0, 0});
  for (Index k = 0; k < grains; ++k) bond_particles(s.bonds, s.particles, s.domain, k, k + 1, 0, 1);
  s.clock.time_step = time_step_limit(s, 0.01).recommended;
  const double density = line_mass(s) / area, speed = std::sqrt(young / density), width = 8 * scene::spacing, start = 300 * scene::spacing;
  for (Index id = 0; id <= grains; ++id) {
    const std::size_t k = scene::row_of(s, id);
    const double x = (id * scene::spacing - start) / width, g = 1e-7 * std::exp(-0.5 * x * x);
    s.particles.position[k].x += g;
    s.particles.velocity[k].x = speed * x / width * g;
  }
  s.start(false);
  REQUIRE(s.contacts.blocks.size() > 1);
  const auto centre = [&] {
    double sum = 0, weighted = 0;
    for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
      const double v = s.particles.velocity[k].x;
      sum += v * v, weighted += v * v * s.particles.id[k] * scene::spacing;
    }
    return weighted / sum;
  };
  const double from = centre();
  while (s.clock.time() < 120 * scene::spacing / speed) s.step();
  CHECK((centre() - from) / s.clock.time() == Approx(speed).epsilon(0.01));
  s.measure_energy();
  CHECK(s.ledger.stored() == Approx(s.ledger.stored_at_start).epsilon(1e-4));
}
