// Effects that act beyond touch: adhesion's neck, bridges of liquid, lubrication films; against their published forces and works.
#include <catch2/catch.hpp>
#include <numbers>
#include "src/contact/with_effects.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "tests/effect_scene.hpp"

using namespace quern;
using namespace effect_scene;

namespace {

constexpr double pi = std::numbers::pi;

PairLaw sticky(double work, double restitution = 1) {
  PairLaw pair = scene::hertz(scene::glass(), scene::glass(), restitution, 0);
  pair.extras.adhesion = {work, effective_young(scene::glass(), scene::glass())};
  return pair;
}

PairLaw wet(double volume, double angle) {
  PairLaw pair = scene::hertz(scene::glass(), scene::glass(), 1.0, 0);
  pair.extras.bridge = {volume, 0.0728, angle};
  return pair;
}

// The normal force of a contact drawn apart slowly, by gap.
template <class Visit>
void draw_apart(const PairLaw& pair, double from_overlap, double to_gap, int pieces, Visit&& visit) {
  Remembered<double> memory{};
  for (int k = 0; k <= pieces; ++k) {
    const double overlap = from_overlap - (from_overlap + to_gap) * k / pieces;
    Approach<double> a = head_on(std::max(0.0, overlap), 0, radius, ball_mass());
    a.overlap = overlap;
    TangentialSpring<double> spring{};
    EffectForce<double> force;
    std::visit([&](const auto& law) { act_with_effects(law, pair.extras, a, 0.0, memory, spring, force); }, pair.law);
    visit(-overlap, force.contact.normal, force.contact.elastic_energy);
  }
}


}  // namespace

TEST_CASE("adhesive spheres pull off at three halves π w R and take their neck's work", "[effects]") {
  const double work = 0.5, young = effective_young(scene::glass(), scene::glass());
  double least = 0, sum = 0, last_force = 0, last_gap = 0, end = 0, at_touch = 0;
  const PairLaw pair = sticky(work);
  const double neck = pair.extras.adhesion.reach(radius);
  draw_apart(pair, 5 * neck, 1.5 * neck, 400000, [&](double gap, double force, double) {
    least = std::min(least, force);
    if (gap > 0 && force != 0) sum += 0.5 * (force + last_force) * (gap - last_gap), end = gap;
    if (gap > 0 && at_touch == 0) at_touch = force;
    last_force = force, last_gap = gap;
  });
  CHECK(least == Approx(-1.5 * pi * work * radius).epsilon(1e-5));  // Johnson, Kendall & Roberts 1971
  CHECK(at_touch == Approx(-4.0 / 3.0 * pi * work * radius).epsilon(1e-3));
  CHECK(end == Approx(0.4724704 * std::cbrt(std::pow(2 * pi * work / young, 2) * radius)).epsilon(1e-3));
  // Johnson & Pollock 1994, Thornton & Ning 1998: snapping on and pulling off lose 7.09 (w⁵ R⁴/E*²)^(1/3), 0.30/0.3315 of it by snapping.
  const double scale = std::cbrt(std::pow(work, 5) * std::pow(radius, 4) / (young * young));
  CHECK(-sum == Approx(7.09 * scale).epsilon(2e-3));
}

TEST_CASE("an adhesive sphere sticks below and leaves above the speed that its work sets", "[effects]") {
  const double work = 0.5, young = effective_young(scene::glass(), scene::glass());
  const PairLaw pair = sticky(work);
  const double lost = 7.09 * std::cbrt(std::pow(work, 5) * std::pow(radius, 4) / (young * young));
  const double sticking = std::sqrt(2 * lost / ball_mass());
  for (const double times : {1.2, 3.0}) {
    const Bounce b = bounce(pair, times * sticking, 1000);
    CAPTURE(times, b.restitution, b.closure);
    CHECK(b.restitution == Approx(std::sqrt(1 - 1 / (times * times))).margin(3e-3));
    CHECK(std::abs(b.closure) < 1e-3);
  }
  Simulation s = above_floor(pair, 0.9 * sticking, collide_head_on(pair, radius, ball_mass(), sticking).duration / 1000);
  s.start(false);
  for (int k = 0; k < 20000; ++k) s.step();
  CHECK(s.contacts.sums.wall_contacts == 1);
  const double neck = pair.extras.adhesion.reach(radius);
  CHECK(s.particles.position[0].z - radius < neck);
}

TEST_CASE("a bridge of liquid pulls as Willett's closed form says and ruptures where it says", "[effects]") {
  for (const double angle : {0.0, 0.6}) {
    const double volume = 1e-12, twice = 2 * radius, touch = 2 * pi * twice * 0.0728 * std::cos(angle);
    const double rupture = (1 + 0.5 * angle) * (std::cbrt(volume) + std::pow(volume, 2.0 / 3) / (10 * twice));
    double broken = 0, worst = 0, sum = 0, last_force = 0, last_gap = 0, last_energy = 0;
    draw_apart(wet(volume, angle), 1e-12, 1.2 * rupture, 100000, [&](double gap, double force, double energy) {
      if (gap <= 0) return;
      const double s = gap * std::sqrt(twice / volume), closed = gap < rupture ? -touch / (1 + 1.05 * s + 2.5 * s * s) : 0;
      if (std::abs(gap / rupture - 1) > 1e-4) worst = std::max(worst, std::abs(force - closed) / touch);
      if (force == 0 && broken == 0) broken = gap;
      if (force != 0 && last_gap > 0) sum += 0.5 * (force + last_force) * (gap - last_gap), last_energy = energy;
      last_force = force, last_gap = gap;
    });
    CHECK(worst < 1e-9);
    CHECK(broken == Approx(rupture).epsilon(1e-4));
    CHECK(last_energy == Approx(-sum).epsilon(1e-3));
    // Two like spheres of radius R pull with 2π R σ cos θ where they touch.
    const LiquidBridge bridge{volume, 0.0728, angle};
    CHECK(bridge(0.0, 0.5 * radius).force == Approx(-2 * pi * radius * 0.0728 * std::cos(angle)));
  }
}

TEST_CASE("a bridge is not there before touch and takes its work from the ball that leaves", "[effects]") {
  const PairLaw pair = wet(1e-12, 0);
  // The work to draw it to rupture, by the closed form.
  const double rupture = pair.extras.bridge.reach(radius), drawn = LiquidBridge{1e-12, 0.0728, 0}(rupture, radius).energy;
  const double speed = 4 * std::sqrt(2 * drawn / ball_mass());
  Simulation s = above_floor(pair, speed, 2e-7);
  s.start(false);
  const double before = scene::kinetic_energy(s);
  for (int k = 0; k < 2000000 && !(s.particles.velocity[0].z > 0 && s.contacts.sums.wall_contacts == 0); ++k) {
    s.step();
    if (s.particles.velocity[0].z == -speed) CHECK(s.walls[0].force.z == 0);
  }
  const double after = scene::kinetic_energy(s);
  CHECK((before - after) / drawn == Approx(1).epsilon(2e-3));
  CHECK(std::abs(before - after - s.ledger.dissipated()) < 1e-3 * before);
  CHECK(s.ledger.elastic == 0);
}

TEST_CASE("a film stops a ball by the logarithm of its gap", "[effects]") {
  PairLaw pair = scene::hertz(scene::glass(), scene::glass(), 1.0, 0);
  const double viscosity = 0.1, thickness = 2e-4, cutoff = 1e-6, speed = 0.05;
  pair.extras.lubrication = {viscosity, thickness, cutoff};
  Simulation s = scene::free_space(scene::glass(), pair, 2e-6);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + 1.1 * thickness}, radius, {0, 0, -speed});
  s.start(false);
  const double before = scene::kinetic_energy(s), drag = 6 * pi * viscosity * radius * radius / ball_mass();
  double worst = 0;
  for (int k = 0; k < 6000; ++k) {
    s.step();
    const double gap = s.particles.position[0].z - radius;
    if (gap < thickness) worst = std::max(worst, std::abs(-s.particles.velocity[0].z - std::max(0.0, speed - drag * std::log(thickness / gap))) / speed);
  }
  // m v = m v₀ − 6π η R² ln(thickness/h): it comes to rest at this gap.
  const double rest = thickness * std::exp(-speed / drag);
  REQUIRE(rest > 2 * cutoff);
  CHECK(s.particles.position[0].z - radius == Approx(rest).epsilon(0.02));
  CHECK(worst < 0.01);
  CHECK(std::abs(before - scene::kinetic_energy(s) - s.ledger.dissipated()) < 1e-3 * before);
}

TEST_CASE("every surface of a wall is felt beyond touch", "[effects]") {
  // A ball that flies past at 60 µm from the surface, within a film of 100 µm: all surfaces slow it alike.
  PairLaw pair = scene::hertz(scene::glass(), scene::glass(), 1.0, 0);
  pair.extras.lubrication = {0.05, 1e-4, 1e-6};
  const auto approach = [&](const Surface& surface, const Vec3& towards, double at) {
    Simulation s = scene::free_space(scene::glass(), pair, 2e-6);
    Wall wall;
    wall.surface = surface;
    s.walls.push_back(wall);
    const Vec3 start = (at - radius - 1.503e-4) * towards, velocity = 0.02 * towards;
    scene::add_ball(s, triple(start), radius, triple(velocity));
    s.start(false);
    for (int k = 0; k < 4000; ++k) s.step();
    return vec(s.particles.velocity[0]).dot(towards);
  };
  const double plane = approach(Plane{}, -Vec3::UnitZ(), 0);
  CHECK(plane < 0.019);
  CHECK(plane > 0);
  CHECK(approach(Revolved{0.1, -0.1, 0.1, 0.1, Revolved::Side::inside}, Vec3::UnitX(), 0.1) == Approx(plane).epsilon(1e-9));
  CHECK(approach(Revolved{0, 0, 0.1, 0, Revolved::Side::both}, -Vec3::UnitZ(), 0) == Approx(plane).epsilon(1e-9));
  const Mesh sheet = make_mesh({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  CHECK(approach(sheet, -Vec3::UnitZ(), 0) == Approx(plane).epsilon(1e-9));
}
