#include "src/observe/captures.hpp"
#include <catch2/catch.hpp>
#include "tests/scene.hpp"

using namespace quern;

namespace {

// A grain at rest and two balls that come from either side, the second from farther away by `later` [m].
struct Outcome {
  std::vector<Headline> lines;
  std::vector<Table> tables;
  double dissipated, seconds;
};

// Until so many contacts have ended.
Outcome squeeze(double later, std::size_t contacts) {
  const Material steel{"steel", 7800, 1e9, 0.3};
  Simulation s = scene::free_space(steel, scene::hertz(steel, steel, 0.5, 0.3), 2e-7);
  s.species = {{"ball", 0}, {"grain", 0}};
  scene::add_ball(s, {0, 0, 0}, 0.001, {0, 0, 0});
  s.particles.species[0] = 1;
  scene::add_ball(s, {-0.00602, 0, 0}, 0.005, {1, 0, 0});
  scene::add_ball(s, {0.00602 + later, 0, 0}, 0.005, {-1, 0, 0});
  s.start(true);
  ObserverSettings settings;
  settings.start_time = 0;
  Captures captures;
  captures.see(s, settings);
  std::size_t ended = 0;
  for (int k = 0; k < 20000 && ended < contacts; ++k) {
    s.step();
    captures.see(s, settings);
    ended += s.ended_collisions().size();
  }
  CHECK(ended >= contacts);
  return {captures.headlines(0), captures.tables(0), s.ledger.dissipated(), s.clock.time()};
}

}  // namespace

TEST_CASE("A grain squeezed between two balls at once is one capture with the energy of both contacts") {
  const Outcome outcome = squeeze(0, 2);
  REQUIRE(outcome.lines.size() == 3);
  REQUIRE(outcome.tables.size() == 1);
  const Table& table = outcome.tables[0];
  double count = 0, loss = 0;
  for (std::size_t row = 0; row < table.columns[3].values.size(); ++row) {
    CHECK(table.columns[0].labels[row] == "ball-grain-ball");
    count += table.columns[3].values[row];
    loss += table.columns[7].values[row];
  }
  CHECK(count == 1);
  CHECK(loss * outcome.seconds == Approx(outcome.dissipated).epsilon(1e-9));
}

TEST_CASE("A grain struck by one ball is no capture, and neither are two strokes one after the other") {
  CHECK(squeeze(1, 1).lines.empty());
  // The first ball knocks the grain over to the second.
  CHECK(squeeze(0.004, 2).lines.empty());
  CHECK(squeeze(0.004, 2).tables.empty());
  // Between strokes the balls come nearer and hold it in the end.
  CHECK(!squeeze(0.004, 5).lines.empty());
}
