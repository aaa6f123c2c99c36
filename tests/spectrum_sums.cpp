// Collision spectra of whole mills: they add up to the ledger, and tell kinds of pairs, normal and shear, and captures apart.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include "src/case/build.hpp"
#include "src/observe/observers.hpp"
#include "tests/places.hpp"
#include "tests/results.hpp"

using namespace quern;

namespace {

struct Outcome {
  std::vector<Headline> lines;
  std::vector<Table> tables;
  double dissipated = 0, seconds = 0;  // by the ledger since collisions are counted [J]; [s]

  double value(const std::string& key) const { return quern::value(lines, key); }
  const Table& table(const std::string& name) const { return table_of(tables, name); }
};

// Counts collisions from `start` [s] on.
Outcome watch(const Case& c, double start) {
  Built built = build_case(c);
  Simulation& s = built.simulation;
  Observers observers(built.observe);
  s.start(true);
  observers.see(s);
  double before = 0, from = 0;
  while (s.clock.time() < c.duration) {
    s.step();
    observers.see(s);
    if (from == 0 && observers.spectrum.began) from = s.clock.time(), before = s.ledger.dissipated();
  }
  CHECK(from == Approx(start).margin(1e-4));
  observers.finish(s);
  return {observers.headlines(), observers.tables(), s.ledger.dissipated() - before, s.clock.time() - from};
}

// The losses of ended, enduring and lasting contacts, what they had lost before taken off; each class must have its part.
void check_sums(const Outcome& o) {
  const Table& spectra = o.table("spectra");
  const Column &measure = column(spectra, "measure"), &type = column(spectra, "class");
  double loss = 0, normal = 0, shear = 0, specific = 0, collisions = 0;
  std::set<std::string> classes;
  for (std::size_t row = 0; row < measure.labels.size(); ++row) {
    const double count = column(spectra, "count").values[row], rate = column(spectra, "rate").values[row];
    CHECK(column(spectra, "rate_low").values[row] <= rate);
    CHECK(column(spectra, "rate_high").values[row] > rate);
    CHECK(rate * o.seconds == Approx(count).epsilon(1e-6));
    if (measure.labels[row] != "dissipated") continue;
    loss += column(spectra, "dissipated").values[row];
    normal += column(spectra, "normal").values[row];
    shear += column(spectra, "shear").values[row];
    specific += column(spectra, "specific").values[row];
    classes.insert(type.labels[row]);
    if (type.labels[row] == "collision" || type.labels[row] == "enduring") collisions += rate;
  }
  CHECK(classes == std::set<std::string>{"collision", "enduring", "lasting"});
  CHECK(loss * o.seconds == Approx(o.dissipated).epsilon(1e-6));  // the sum of a million terms; asked for is 0.5 %
  CHECK(normal > 0);
  CHECK(shear > 0);
  CHECK(normal + shear == Approx(loss).epsilon(1e-9));
  CHECK(specific == Approx(o.value("specific_power")).epsilon(1e-9));
  CHECK(collisions == Approx(o.value("collision_rate")).epsilon(1e-9));
}

}  // namespace

TEST_CASE("Spectra of a planetary mill with balls of two sizes and powder add up to the ledger, pair by pair") {
  const Case c = read_case(std::string(quern::source_directory) + "/cases/planetary_250rpm/case.toml",
                           {"material.steel.young=2e7", "duration=0.7", "mill.vials=1", "mill.speed=40", "observe.charge=false", "observe.start=0.3", "mill.filling=0.25",
                            "species.large.material=steel", "species.large.diameter=0.018", "insert.large.species=large", "insert.large.count=2",
                            "species.powder.material=steel", "species.powder.diameter=0.004", "insert.powder.species=powder", "insert.powder.count=60"});
  const Outcome o = watch(c, 0.3);
  check_sums(o);
  std::set<std::string> pairs;
  for (const std::string& pair : column(o.table("spectra"), "pair").labels) pairs.insert(pair);
  for (const char* pair : {"ball-ball", "ball-large", "ball-wall", "large-wall", "ball-powder", "large-powder", "powder-powder", "powder-wall"}) {
    INFO(pair);
    CHECK(pairs.count(pair) == 1);
  }
  const Table& captures = o.table("captures");
  double loss = 0, shear = 0;
  std::set<std::string> held;
  for (std::size_t row = 0; row < column(captures, "count").values.size(); ++row) {
    held.insert(column(captures, "bodies").labels[row]);
    loss += column(captures, "dissipated").values[row];
    shear += column(captures, "shear").values[row];
    CHECK(column(captures, "normal").values[row] + column(captures, "shear").values[row] == Approx(column(captures, "dissipated").values[row]));
    CHECK(column(captures, "rate_high").values[row] > column(captures, "rate").values[row]);
  }
  CHECK(held.count("ball-powder-ball") == 1);
  CHECK(held.count("ball-powder-wall") == 1);
  CHECK(loss == Approx(o.value("capture_power")).epsilon(1e-9));
  CHECK(loss < o.value("contact_power"));
  CHECK(shear > 0);
}

TEST_CASE("Spectra of a tumbling mill that is watched from the middle of a run add up to the ledger") {
  const Case c = read_case(std::string(quern::source_directory) + "/cases/mill_545mm/case.toml", {"duration=1.2", "observe.start=0.7", "observe.charge=false", "material.steel.young=2e7"});
  check_sums(watch(c, 0.7));
}
