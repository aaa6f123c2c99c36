// The course of single contacts and the track of particles, against what the engine's own sums say.
#include <catch2/catch.hpp>
#include <algorithm>
#include "src/observe/contact_history.hpp"
#include "src/observe/track.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

double integral(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0;
  for (std::size_t k = 1; k < x.size(); ++k) sum += 0.5 * (y[k] + y[k - 1]) * (x[k] - x[k - 1]);
  return sum;
}

}  // namespace

TEST_CASE("the force of a bounce, summed over time, is the change of momentum; its loop over overlap is the loss") {
  const Material glass = scene::glass();
  const double radius = 0.01, speed = 2;
  const PairLaw law = scene::hertz(glass, glass, 0.6, 0);
  const double mass = 4.18879020478639 * glass.density * radius * radius * radius;
  const HeadOnCollision collision = collide_head_on(law.law, radius, mass, speed);
  Simulation s = scene::free_space(glass, law, collision.duration / 1000);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + 1.5 * speed * s.clock.time_step}, radius, {0, 0, -speed});
  s.start(true);
  ContactHistory history;
  for (int k = 0; k < 1500; ++k) s.step(), history.see(s);
  REQUIRE(history.contacts.size() == 1);
  const ContactCourse& c = history.contacts[0];
  CHECK_FALSE(c.lasting);
  CHECK(integral(c.time, c.force) == Approx(mass * (speed + s.particles.velocity[0].z)).epsilon(2e-3));
  CHECK(integral(c.overlap, c.force) == Approx(collision.loss).epsilon(5e-3));
  CHECK(c.normal_loss == Approx(collision.loss).epsilon(2e-3));
  CHECK(c.peak_force == Approx(collision.peak_force).epsilon(2e-3));
  CHECK(*std::max_element(c.force.begin(), c.force.end()) == Approx(c.peak_force).epsilon(2e-3));
  // The law's force ends before the overlap does; the contact ends with the overlap.
  std::size_t last = 0;
  for (std::size_t k = 0; k < c.force.size(); ++k)
    if (c.force[k] > 0) last = k;
  CHECK(c.time[last] - c.start == Approx(collision.duration).epsilon(5e-3));
  CHECK(c.end > c.time[last]);
  const std::vector<Table> tables = history.tables();
  CHECK(tables[0].columns[2].labels == std::vector<std::string>{"floor"});
  CHECK(tables[1].columns[0].values.size() == c.time.size());
}

TEST_CASE("a ball that bounces twice leaves two contacts") {
  const Material glass = scene::glass();
  const PairLaw law = scene::hertz(glass, glass, 0.9, 0);
  Simulation s = scene::free_space(glass, law, 1e-7);
  s.gravity = Vec3(0, 0, -1e4);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, 0.0101}, 0.01, {0, 0, 0});
  s.start(true);
  ContactHistory history;
  for (int k = 0; k < 6000; ++k) s.step(), history.see(s);
  REQUIRE(history.contacts.size() >= 2);
  CHECK_FALSE(history.contacts[0].lasting);
  CHECK(history.contacts[1].start > history.contacts[0].end);
  CHECK(history.contacts[1].normal_speed < history.contacts[0].normal_speed);
}

TEST_CASE("a track follows the chosen particle at its interval and ends with the run") {
  Simulation s = scene::free_space(scene::glass(), scene::linear(1e5, 1, 0), 1e-3);
  for (int k = 0; k < 5; ++k) scene::add_ball(s, {0.1 * k, 0, 0}, 0.01, {0, 0, 1.0 + k}, {0, 2, 0});
  s.start(false);
  ObserverSettings settings;
  settings.track = {3};
  settings.track_interval = 0.01;
  Track track;
  track.see(s, settings);
  for (int k = 0; k < 25; ++k) s.step(), track.see(s, settings);
  track.finish(s, settings);
  REQUIRE(track.points.size() == 4);
  CHECK(track.points[1].time == Approx(0.01));
  CHECK(track.points[2].position.z == Approx(0.02 * 4));
  CHECK(track.points[3].time == Approx(0.025));
  CHECK(track.points[3].position.x == Approx(0.3));
  CHECK(track.points[3].spin.y == 2);
}
