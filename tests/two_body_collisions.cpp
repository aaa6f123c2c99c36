// Two bodies measure the restitution that was asked for, whatever their sizes, speed and law.
#include <catch2/catch.hpp>
#include "tests/scene.hpp"

using namespace quern;

namespace {

constexpr double restitutions[] = {0.1, 0.3, 0.5, 0.7, 0.9, 1.0};
constexpr double speeds[] = {0.01, 0.1, 1, 10};

double step_for(const PairLaw& law, double radius, double mass, double speed) {
  return collide_head_on(law.law, radius, mass, speed).duration / 200;
}

double measured_pair(const PairLaw& law, double radius_a, double radius_b, double speed) {
  const Material glass = scene::glass();
  const double mass_a = glass.density * radius_a * radius_a * radius_a, mass_b = glass.density * radius_b * radius_b * radius_b;
  const double mass = 4.18879020478639 * mass_a * mass_b / (mass_a + mass_b);
  Simulation s = scene::free_space(glass, law, step_for(law, radius_a * radius_b / (radius_a + radius_b), mass, speed));
  const double gap = speed * s.clock.time_step * 3.3;
  scene::add_ball(s, {0, 0, 0}, radius_a, {0, 0, 0});
  scene::add_ball(s, {0.6 * (radius_a + radius_b + gap), 0, 0.8 * (radius_a + radius_b + gap)}, radius_b, {-0.6 * speed, 0, -0.8 * speed});
  s.start(false);
  scene::run_collision(s);
  const Quad &a = s.particles.velocity[scene::row_of(s, 0)], &b = s.particles.velocity[scene::row_of(s, 1)];
  return (0.6 * (b.x - a.x) + 0.8 * (b.z - a.z)) / speed;
}

double measured_wall(const PairLaw& law, double radius, double speed) {
  const Material glass = scene::glass();
  const double mass = 4.18879020478639 * glass.density * radius * radius * radius;
  Simulation s = scene::free_space(glass, law, step_for(law, radius, mass, speed));
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + speed * s.clock.time_step * 2.7}, radius, {0, 0, -speed});
  s.start(false);
  scene::run_collision(s);
  return s.particles.velocity[0].z / speed;
}

}  // namespace

// Tolerance: asked for by the specification; the step is a two-hundredth of the collision, whose error is below 1e-4.
TEST_CASE("a head-on collision measures the restitution asked for") {
  const Material glass = scene::glass();
  for (const double e : restitutions)
    for (const double speed : speeds) {
      CAPTURE(e, speed);
      const PairLaw hertz = scene::hertz(glass, glass, e, 0.3), linear = scene::linear(1e6, e, 0.3);
      CHECK(measured_pair(hertz, 0.005, 0.005, speed) == Approx(e).margin(1e-3));
      CHECK(measured_pair(hertz, 0.005, 0.02, speed) == Approx(e).margin(1e-3));
      CHECK(measured_wall(hertz, 0.005, speed) == Approx(e).margin(1e-3));
      CHECK(measured_pair(linear, 0.005, 0.005, speed) == Approx(e).margin(1e-3));
      CHECK(measured_pair(linear, 0.005, 0.02, speed) == Approx(e).margin(1e-3));
      CHECK(measured_wall(linear, 0.005, speed) == Approx(e).margin(1e-3));
    }
}

TEST_CASE("an elastic Hertz collision has the closed peak force, overlap and duration") {
  const Material glass = scene::glass();
  const double radius = 0.005, mass = 1e-3, speed = 2;
  const HeadOnCollision c = collide_head_on(scene::hertz(glass, glass, 1.0, 0).law, radius, mass, speed);
  const double stiffness = 4.0 / 3.0 * effective_young(glass, glass) * std::sqrt(radius);
  const double overlap = std::pow(1.25 * mass * speed * speed / stiffness, 0.4);  // Johnson 1985
  CHECK(c.peak_overlap == Approx(overlap).epsilon(1e-5));
  CHECK(c.peak_force == Approx(stiffness * std::pow(overlap, 1.5)).epsilon(1e-5));
  CHECK(c.duration == Approx(2.943275 * overlap / speed).epsilon(2e-3));  // ends within one of a thousand steps
}

TEST_CASE("a collision is second-order accurate in the time step") {
  // A collision that sticks (the onset of sliding is not smooth), seen before it parts, against a step far finer. The linear law
  // in all components; Hertz–Mindlin along the normal: its shear stiffness follows the overlap of the step before, which is known to
  // first order only (error below 0.1 % of the velocity at a fortieth of the collision).
  const Material glass = scene::glass();
  const auto at_end = [&](const PairLaw& law, int divisions) {
    Simulation s = scene::free_space(glass, law, 4e-6 / divisions);
    scene::add_ball(s, {0, 0, 0}, 0.005, {0, 0, 0}, {0, 30, 0});
    scene::add_ball(s, {0.00999, 0, 0}, 0.005, {-1, 0.2, 0}, {0, 0, 20});
    s.start(false);
    for (int k = 0; k < 3 * divisions; ++k) s.step();
    const Quad v = s.particles.velocity[scene::row_of(s, 1)], w = s.particles.spin[scene::row_of(s, 1)];
    return std::array<double, 3>{v.x, v.y, 0.005 * w.z};
  };
  for (const bool hertz : {false, true}) {
    const PairLaw law = hertz ? scene::hertz(glass, glass, 0.5, 10) : scene::linear(5e6, 0.5, 10);
    const auto exact = at_end(law, 1024), coarse = at_end(law, 16), fine = at_end(law, 32);
    for (std::size_t k = 0; k < (hertz ? 1 : 3); ++k) {
      CAPTURE(hertz, k, exact[k], coarse[k] - exact[k], fine[k] - exact[k]);
      CHECK(std::abs(coarse[k] - exact[k]) / std::abs(fine[k] - exact[k]) == Approx(4).epsilon(0.1));
    }
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(at_end(law, 8)[k] - exact[k]) < 1e-3);
  }
}
