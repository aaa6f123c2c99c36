#include "src/observe/spectrum.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "scene.hpp"
#include "src/base/random.hpp"
#include "tests/results.hpp"

using namespace quern;

namespace {

// Two species thrown onto a floor between four walls.
Simulation shower(int count) {
  Simulation s = scene::free_space(scene::glass(), scene::linear(2e4, 0.6, 0.4), 2e-5);
  s.pair_laws[0].rolling = {RollingModel::elastic_plastic, 0.05, 0.3};
  s.species = {{"coarse", 0}, {"fine", 0}};
  s.gravity = {0, 0, -9.81};
  scene::add_floor(s);
  for (int side = 0; side < 4; ++side) {
    Wall wall;
    wall.name = "side";
    wall.surface = Plane{};
    const double angle = side * 1.5707963267948966;
    wall.rest.axes = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix() * Eigen::AngleAxisd(1.5707963267948966, Vec3::UnitY()).toRotationMatrix();
    wall.rest.origin = -0.05 * wall.rest.axes.col(2);
    wall.pose = wall.rest;
    s.walls.push_back(wall);
  }
  RandomStream random(4);
  for (int k = 0; k < count; ++k) {
    const Triple<double> place = {-0.03 + 0.02 * (k % 4), -0.03 + 0.02 * (k / 4 % 4), 0.012 + 0.021 * (k / 16)};
    scene::add_ball(s, place, k % 3 == 0 ? 0.009 : 0.006, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-2, 0)});
    s.particles.species.back() = k % 3 == 0 ? 0 : 1;
  }
  return s;
}

}  // namespace

TEST_CASE("one head-on collision stands in the spectrum with its energies") {
  const double e = 0.7, speed = 0.5, radius = 0.01;
  Simulation s = scene::free_space(scene::glass(), scene::linear(1e5, e, 0.3), 1e-6);
  scene::add_ball(s, {0, 0, 0}, radius, {speed, 0, 0});
  scene::add_ball(s, {0.021, 0, 0}, radius, {-speed, 0, 0});
  CollisionSpectrum spectrum;
  ObserverSettings settings;
  settings.long_contact = 2e-3;  // it lasts 0.7 ms
  s.start(true);
  spectrum.see(s, settings);
  for (int k = 0; k < 3000; ++k) s.step(), spectrum.see(s, settings);
  spectrum.finish(s);

  const double mass = s.particles.mass(0), impact = 0.5 * (mass / 2) * 4 * speed * speed;
  const auto w = spectrum.window(0);
  CHECK(w.total().count == 1);
  CHECK(w.total().impact == Approx(impact).epsilon(1e-3));
  CHECK(w.total().relative == Approx(0.5 * mass * 4 * speed * speed).epsilon(1e-3));
  CHECK(w.total().normal_loss == Approx((1 - e * e) * impact).epsilon(3e-3));
  CHECK(w.total().tangential_loss == Approx(0).margin(1e-12));

  const Table spectra = table_of(spectrum.tables(0), "spectra");
  int rows = 0;
  for (std::size_t k = 0; k < column(spectra, "count").values.size(); ++k) {
    CHECK(column(spectra, "pair").labels[k] == "ball-ball");
    CHECK(column(spectra, "class").labels[k] == "collision");
    const std::string& measure = column(spectra, "measure").labels[k];
    const double energy = measure == "impact" ? impact : measure == "relative" ? 2 * impact : (1 - e * e) * impact;
    CHECK(column(spectra, "energy_from").values[k] < energy);
    CHECK(column(spectra, "energy_to").values[k] > energy);
    ++rows;
  }
  CHECK(rows == 3);
  CHECK(value(spectrum.headlines(0), "collision_rate") == Approx(1 / 3e-3).epsilon(1e-6));
  CHECK(value(spectrum.headlines(0), "impact_energy_median") == Approx(impact).epsilon(0.26));  // a tenth of a decade
}

TEST_CASE("an elastic collision overlaps by v √(m*/k) and lasts π √(m*/k)") {
  const double stiffness = 1e5, speed = 0.5, radius = 0.01;
  Simulation s = scene::free_space(scene::glass(), scene::linear(stiffness, 1.0, 0.3), 1e-6);
  scene::add_ball(s, {0, 0, 0}, 2 * radius, {speed, 0, 0});
  scene::add_ball(s, {0.031, 0, 0}, radius, {-speed, 0, 0});
  CollisionSpectrum spectrum;
  s.start(true);
  spectrum.see(s, {});
  for (int k = 0; k < 3000; ++k) s.step(), spectrum.see(s, {});
  spectrum.finish(s);
  const double m1 = s.particles.mass(0), m2 = s.particles.mass(1), time = std::sqrt(m1 * m2 / (m1 + m2) / stiffness);
  const std::vector<Headline> lines = spectrum.headlines(0);
  CHECK(value(lines, "overlap_peak") == Approx(2 * speed * time / radius).epsilon(2e-3));
  CHECK(value(lines, "contact_force_peak") == Approx(2 * speed * time * stiffness).epsilon(2e-3));
  CHECK(value(lines, "contact_duration") == Approx(3.14159265 * time).epsilon(5e-3));
}

TEST_CASE("the spectrum holds every joule that the ledger counts as dissipated, from whatever moment it watches") {
  Simulation s = shower(40);
  s.start(true);
  ObserverSettings early, late;
  late.start_time = 0.15;
  CollisionSpectrum from_start, from_late;
  std::map<double, double> dissipated;  // by time
  const auto watch = [&] {
    from_start.see(s, early);
    from_late.see(s, late);
    dissipated[s.clock.time()] = s.ledger.dissipated();
  };
  watch();
  while (s.clock.time() < 0.3) s.step(), watch();
  from_start.finish(s);
  from_late.finish(s);
  REQUIRE(s.ledger.dissipated() > 0);
  const auto since = [&](double time) { return s.ledger.dissipated() - std::prev(dissipated.upper_bound(time + 1e-9))->second; };

  CHECK(from_start.window(0).total().loss() == Approx(since(0)).epsilon(1e-9));
  CHECK(from_start.window(0).total().normal_loss == Approx(s.ledger.normal_loss).epsilon(1e-9));
  CHECK(from_late.window(0).from == Approx(0.15).margin(3e-5));
  CHECK(from_late.window(0).total().loss() == Approx(since(from_late.window(0).from)).epsilon(1e-9));
  for (double start : {0.03, 0.08, 0.12}) {
    const auto w = from_start.window(start);
    CHECK(w.from >= start - 3e-5);
    CHECK(w.total().loss() == Approx(since(w.from)).epsilon(1e-9));
  }
  SECTION("and the table adds up to the same") {
    const auto w = from_start.window(0.12);
    const Table spectra = table_of(from_start.tables(0.12), "spectra");
    double sum = 0;
    for (std::size_t k = 0; k < column(spectra, "dissipated").values.size(); ++k)
      if (column(spectra, "measure").labels[k] == "dissipated") sum += column(spectra, "dissipated").values[k];
    CHECK(sum * w.seconds == Approx(w.total().loss()).epsilon(1e-9));
  }
  SECTION("contacts of balls at rest are counted as lasting") {
    CHECK(value(from_start.headlines(0), "lasting_contacts") == static_cast<double>(s.lasting_collisions().size()));
    CHECK(s.lasting_collisions().size() > 20);
  }
}

TEST_CASE("pair kinds have one name each, whichever body comes first") {
  CollisionSpectrum spectrum;
  spectrum.species = {"ball", "ore", "dust"};
  CHECK(spectrum.kinds() == 9);
  CHECK(spectrum.name_of(spectrum.kind_of(1, 0)) == "ball-ore");
  CHECK(spectrum.kind_of(0, 2) == spectrum.kind_of(2, 0));
  CHECK(spectrum.name_of(spectrum.kind_of(2, 1)) == "ore-dust");
  CHECK(spectrum.name_of(spectrum.kind_of(2, 2)) == "dust-dust");
  CHECK(spectrum.name_of(spectrum.kind_of(1, 255)) == "ore-wall");
  std::vector<int> seen(9);
  for (std::uint8_t a = 0; a < 3; ++a) {
    ++seen[spectrum.kind_of(a, 255)];
    for (std::uint8_t b = 0; b <= a; ++b) ++seen[spectrum.kind_of(a, b)];
  }
  CHECK(seen == std::vector<int>(9, 1));
}

TEST_CASE("bins are ten to the decade and hold what lies beyond them at the ends") {
  CollisionSpectrum spectrum;
  CHECK(spectrum.edge(spectrum.bin_of(1.1e-3)) <= 1.1e-3);
  CHECK(spectrum.edge(spectrum.bin_of(1.1e-3) + 1) > 1.1e-3);
  CHECK(spectrum.edge(10) / spectrum.edge(0) == Approx(10));
  CHECK(spectrum.bin_of(0) == 0);
  CHECK(spectrum.bin_of(-1) == 0);
  CHECK(spectrum.bin_of(1e30) == spectrum.bins() - 1);
}
