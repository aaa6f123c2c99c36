// Fragments of bonded bodies: which there are, that their masses are the whole mass, their sieve sizes, and what a run writes of them.
#include "bonds/fragments.hpp"
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <numbers>
#include <nlohmann/json.hpp>
#include "src/base/random.hpp"
#include "src/grinding/schuhmann.hpp"
#include "src/observe/fragment_tables.hpp"
#include "src/observe/observers.hpp"
#include "src/output/run.hpp"
#include "src/output/vtk_frames.hpp"
#include "tests/bond_scene.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

using scene::spacing;

// A block of grains on a simple cubic lattice, bonded to their nearest neighbours.
void add_block(Simulation& s, const Vec3& corner, int nx, int ny, int nz, std::uint64_t seed = 1) {
  const Index first = s.particles.size();
  const auto row = [&](int x, int y, int z) { return first + (x * ny + y) * nz + z; };
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) scene::add_grain(s, corner + spacing * Vec3(x, y, z));
  const auto bond = [&](Index a, Index b) { bond_particles(s.bonds, s.particles, s.domain, a, b, 0, seed); };
  for (int x = 0; x < nx; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) {
        if (x + 1 < nx) bond(row(x, y, z), row(x + 1, y, z));
        if (y + 1 < ny) bond(row(x, y, z), row(x, y + 1, z));
        if (z + 1 < nz) bond(row(x, y, z), row(x, y, z + 1));
      }
}

void break_by_hand(Simulation& s, Index first, Index second) {
  for (std::size_t k = 0; k < s.bonds.list.size(); ++k) {
    Bond& b = s.bonds.list[k];
    if (b.first != first || b.second != second) continue;
    b.state = BondState::released;
    s.bonds.failures.push_back({0, 0, {0, 0, 0}, {0, 0, 1}, static_cast<Index>(k), first, second, BondFailureMode::tension});
  }
}

// A brick of weak cement that flies onto the floor, a ball beside it that was never bonded.
Simulation falling_brick() {
  BondMaterial weak = scene::cement(1e8, 4e7, 0.05);
  weak.strength = {StrengthDistribution::weibull, 3e5, 3e5, 0, 3};
  Simulation s = scene::bonded_space(weak, 4e-6);
  scene::add_ball(s, {0.2, 0, 0.1}, 0.01, {0, 0, 0});
  add_block(s, {0, 0, 0.5 * spacing}, 5, 4, 6);
  for (std::size_t k = 1; k < s.particles.velocity.size(); ++k) s.particles.velocity[k].x = 0.5, s.particles.velocity[k].z = -4;
  scene::add_floor(s);
  return s;
}

ObserverSettings only_fragments() {
  ObserverSettings settings;
  settings.power = settings.shell_force = settings.spectrum = settings.charge = false;
  settings.fragment_interval = 2e-4;
  return settings;
}

double value(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line.value;
  return std::nan("");
}

const Table* find(const std::vector<Table>& tables, const std::string& name) {
  for (const Table& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

const Column& column(const Table& table, const std::string& name) {
  for (const Column& c : table.columns)
    if (c.name == name) return c;
  throw std::runtime_error(name);
}

// Spheres at the corners of a box of these outer extents, and along its edges, turned.
std::vector<Quad> corners(const Vec3& extents, double radius, const Mat3& turn) {
  std::vector<Quad> spheres;
  for (int k = 0; k < 8; ++k) {
    const Vec3 sign(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    const Vec3 place = turn * (0.5 * (extents.array() - 2 * radius) * sign.array()).matrix();
    spheres.push_back({place.x(), place.y(), place.z(), radius});
  }
  return spheres;
}

}  // namespace

TEST_CASE("fragments are the components of the intact bonds, the heaviest first; a ball without bonds is none") {
  Simulation s = scene::bonded_space(scene::cement(), 1e-7);
  const Index ball = scene::add_ball(s, {1, 1, 1}, 0.02, {0, 0, 0});
  add_block(s, {0, 0, 0}, 2, 2, 1);                  // ids 1 to 4
  add_block(s, {2 * spacing, 0, 0}, 3, 2, 1);        // ids 5 to 10
  for (int y = 0; y < 2; ++y) bond_particles(s.bonds, s.particles, s.domain, 3 + y, 5 + y, 0, 1);  // what joins them
  for (Index k = 1; k <= 4; ++k) s.particles.velocity[static_cast<std::size_t>(k)].x = -2;
  std::vector<Index> order = {7, 3, 10, 0, 5, 1, 9, 2, 8, 6, 4};
  s.particles.reorder(order);  // rows do not matter

  const Fragments whole = find_fragments(s.bonds, s.particles, s.domain);
  REQUIRE(whole.list.size() == 1);
  CHECK((whole.list[0].id == 1 && whole.list[0].grains == 10));

  break_by_hand(s, 3, 5);
  CHECK(find_fragments(s.bonds, s.particles, s.domain).list.size() == 1);
  break_by_hand(s, 4, 6);
  const Fragments two = find_fragments(s.bonds, s.particles, s.domain);
  REQUIRE(two.list.size() == 2);
  CHECK((two.list[0].id == 5 && two.list[0].grains == 6 && two.list[0].body == 1));
  CHECK((two.list[1].id == 1 && two.list[1].grains == 4 && two.list[1].body == 1));
  CHECK(two.of_row[scene::row_of(s, ball)] == -1);
  CHECK(two.of_row[scene::row_of(s, 2)] == 1);
  CHECK((vec(two.list[1].centre) - Vec3(0.5, 0.5, 0) * spacing).norm() < 1e-15);
  CHECK((vec(two.list[1].velocity) - Vec3(-2, 0, 0)).norm() < 1e-14);
  const double grain = 4.0 / 3.0 * std::numbers::pi * std::pow(0.45 * spacing, 3);
  CHECK(two.list[1].volume == Approx(4 * grain).epsilon(1e-12));
  CHECK(two.list[1].kinetic_energy() == Approx(0.5 * 4 * grain * 2500 * 4).epsilon(1e-12));
  CHECK(find_bodies(s.bonds, s.particles, s.domain).list.size() == 1);
}

TEST_CASE("masses of fragments sum to the whole without a rounding, in any order, however a body breaks") {
  RandomStream random(5);
  Simulation s = scene::bonded_space(scene::cement(), 1e-7);
  double naive = 0;
  for (int k = 0; k < 3000; ++k) {
    const Index row = scene::add_ball(s, {0.02 * k, 0, 0}, 0.002 + 0.007 * random.uniform(), {0, 0, 0});
    naive += s.particles.mass(row);
    if (k > 0) bond_particles(s.bonds, s.particles, s.domain, row - 1, row, 0, 1);
  }
  const Fragments before = find_fragments(s.bonds, s.particles, s.domain);
  CHECK(before.mass == Approx(naive).epsilon(1e-12));
  for (double broken : {0.01, 0.3, 1.0}) {
    for (Bond& bond : s.bonds.list)
      if (random.uniform() < broken) bond.state = BondState::broken;
    const Fragments after = find_fragments(s.bonds, s.particles, s.domain);
    REQUIRE(after.list.size() > 10);
    CHECK(after.mass == before.mass);
    CHECK(after.volume == before.volume);
    double forwards = 0, backwards = 0;
    for (const Fragment& f : after.list) forwards += f.mass;
    for (auto f = after.list.rbegin(); f != after.list.rend(); ++f) backwards += f->mass;
    CHECK(forwards == before.mass);
    CHECK(backwards == before.mass);
  }
}

TEST_CASE("a fragment across a periodic boundary is one piece with its centre beside its first grain") {
  Simulation s = scene::bonded_space(scene::cement(), 1e-7);
  s.domain.period[0] = 20 * spacing;
  for (int k = 0; k < 4; ++k) scene::add_grain(s, {std::fmod(18.5 + k, 20) * spacing, 0, 0});
  for (Index k = 0; k < 3; ++k) bond_particles(s.bonds, s.particles, s.domain, k, k + 1, 0, 1);
  const Fragments all = find_fragments(s.bonds, s.particles, s.domain);
  REQUIRE(all.list.size() == 1);
  CHECK(all.list[0].centre.x == Approx(20 * spacing).epsilon(1e-12));
  CHECK(sieve_size(all, 0, s.particles) == Approx(0.9 * spacing).epsilon(1e-6));
}

TEST_CASE("the sieve size is the side of the smallest square opening") {
  RandomStream random(3);
  for (int k = 0; k < 20; ++k) {
    const Mat3 turn = Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix();
    // Boxes with rounded corners of nearly no radius: a bar passes lengthwise, b × b; a brick with its middle extent; a plate of thickness
    // c < 0.41 b across the corners, (b + c)/√2; a cube with its side.
    const double r = 1e-6;
    CHECK(smallest_square_opening(corners({5, 1, 1}, r, turn)) == Approx(1).epsilon(0.01));
    CHECK(smallest_square_opening(corners({3, 2, 1.2}, r, turn)) == Approx(2).epsilon(0.01));
    CHECK(smallest_square_opening(corners({4, 2, 0.2}, r, turn)) == Approx(2.2 / std::sqrt(2.0)).epsilon(0.01));
    CHECK(smallest_square_opening(corners({1, 1, 1}, r, turn)) == Approx(1).epsilon(0.01));
  }
  CHECK(smallest_square_opening({{0, 0, 0, 0.7}}) == 1.4);
  CHECK(smallest_square_opening({{0, 0, 0, 0.7}, {1.0, 0, 0, 0.3}}) == 1.4);
  // A ball of many grains, of which most are left out of the search.
  std::vector<Quad> ball;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 place(random.normal(), random.normal(), random.normal());
    const Vec3 inside = 0.95 * (k % 2 == 0 ? 1.0 : random.uniform()) * place.normalized();
    ball.push_back({inside.x(), inside.y(), inside.z(), 0.05});
  }
  CHECK(smallest_square_opening(ball) == Approx(2).epsilon(0.01));
}

TEST_CASE("the law of Gates, Gaudin and Schuhmann is found again, with an interval that holds it") {
  // Numbers of fragments in proportion to x^(m−4), up to k: their mass finer than x is (x/k)^m.
  const double m = 0.8, k = 0.05, least = 0.002;
  int held = 0;
  constexpr int samples = 40;
  for (int sample = 0; sample < samples; ++sample) {
    RandomStream random(11, static_cast<std::uint64_t>(sample));
    std::vector<double> sizes, masses;
    for (int n = 0; n < 4000; ++n) {
      const double low = std::pow(least, m - 3), high = std::pow(k, m - 3);
      sizes.push_back(std::pow(low + random.uniform() * (high - low), 1 / (m - 3)));
      masses.push_back(std::pow(sizes.back(), 3));
    }
    // What is finer than the least: as much as the law has on average beside 4000 fragments.
    const double finer = std::pow(least / k, m), mean = (3 - m) / m * (std::pow(k, m) - std::pow(least, m)) / (std::pow(least, m - 3) - std::pow(k, m - 3));
    for (int n = 0; n < 2000; ++n) sizes.push_back(least), masses.push_back(2 * mean * finer / (1 - finer));
    const auto fit = fit_schuhmann(sizes, masses, least);
    REQUIRE(fit);
    CHECK(fit->modulus == Approx(m).epsilon(0.15));
    CHECK(fit->at(fit->size) == 1.0);
    held += fit->modulus_ci95[0] <= m && m <= fit->modulus_ci95[1];
  }
  CHECK(held >= 34);  // of 40 intervals of 95 %, fewer hold with a chance of 1 in 300
  CHECK_FALSE(fit_schuhmann({1, 1, 2, 3}, {1, 1, 8, 27}, 1));
  CHECK_FALSE(fit_schuhmann({}, {}, 1));
}

TEST_CASE("a chain that is pulled apart at its weak bond is two halves that fly apart, and says so") {
  BondMaterial strong = scene::cement(1e8, 4e7), weak = strong;
  weak.name = "weak", weak.strength.tensile = 1e5, weak.strength.shear = 1e5;
  Simulation s = scene::bonded_space(strong, 2e-6);
  s.bonds.materials = {strong, weak};
  constexpr Index grains = 8;
  for (Index k = 0; k < grains; ++k) scene::add_grain(s, {0, 0, spacing * k});
  for (Index k = 0; k + 1 < grains; ++k) bond_particles(s.bonds, s.particles, s.domain, k, k + 1, k == 3 ? 1 : 0, 1);
  for (Index k = 0; k < grains; ++k) s.particles.velocity[static_cast<std::size_t>(k)].z = k < 4 ? -1 : 1;
  s.start(false);
  Observers observers(only_fragments());
  observers.see(s);
  for (int k = 0; k < 2000; ++k) s.step(), observers.see(s);
  observers.finish(s);
  observers.finish(s);  // any number of times

  const auto lines = observers.headlines();
  CHECK(value(lines, "damage_ratio") == 1.0 / 7.0);
  CHECK(value(lines, "fragment_count") == 2);
  CHECK(value(lines, "largest_fragment_fraction") == 0.5);
  CHECK(value(lines, "fines_fraction") == 0);
  CHECK(value(lines, "bond_failures_tension") == 1);
  CHECK(value(lines, "bond_failures_shear") == 0);
  CHECK(value(lines, "body_count") == 1);
  CHECK(std::isnan(value(lines, "t10")));  // a grain is as wide as the chain
  CHECK(std::isnan(value(lines, "schuhmann_modulus")));

  const auto tables = observers.tables();
  const Table& failures = *find(tables, "failures");
  REQUIRE(column(failures, "time").values.size() == 1);
  CHECK(column(failures, "mode").labels[0] == "tension");
  CHECK(column(failures, "bond").labels[0] == "weak");
  CHECK(std::abs(column(failures, "nz").values[0]) == Approx(1).epsilon(1e-12));
  CHECK((column(failures, "first").values[0] == 3 && column(failures, "second").values[0] == 4));
  CHECK(column(failures, "z").values[0] == Approx(3.5 * spacing).epsilon(1e-6));
  CHECK(column(failures, "energy").values[0] == Approx(s.ledger.bond_failure));
  // No momentum at the start, no gravity: against the z axis, across which the crack lies.
  CHECK(column(*find(tables, "crack_directions"), "tension").values == std::vector<double>{1, 0, 0, 0, 0, 0, 0, 0, 0});

  const Table& fragments = *find(tables, "fragments");
  CHECK(column(fragments, "grains").values == std::vector<double>{4, 4});
  const std::vector<double>& away = column(fragments, "vz").values;
  CHECK((away[0] < -0.5 && away[0] == Approx(-away[1]).epsilon(1e-9)));
  CHECK(column(*find(tables, "fragment_sizes"), "finer").values.back() == 1);
  CHECK(column(*find(tables, "fragment_speeds"), "slower").values.back() == 1);
  const Table& damage = *find(tables, "damage");
  CHECK((column(damage, "damage_ratio").values.front() == 0 && column(damage, "damage_ratio").values.back() == 1.0 / 7.0));
  CHECK(column(damage, "time").values.size() == 21);
  CHECK(column(damage, "time").values.back() == s.clock.time());
}

TEST_CASE("t10 is the mass below a tenth of the body's sieve size, and unknown where no grain is as small") {
  const auto t10 = [](double small) {
    Simulation s = scene::bonded_space(scene::cement(), 1e-7);
    add_block(s, {0, 0, 0}, 3, 3, 3);  // about 2.9 spacings wide
    for (int k = 0; k < 4; ++k) {
      const Index row = scene::add_ball(s, {1.5 * spacing, 1.5 * spacing, (3 + 0.1 * k) * spacing}, 0.5 * small, {0, 0, 0});
      bond_particles(s.bonds, s.particles, s.domain, 26, row, 0, 1);
    }
    s.start(false);
    Observers observers(only_fragments());
    observers.see(s);
    for (Index k = 27; k < 30; ++k) break_by_hand(s, 26, k);
    observers.finish(s);
    const double grain = 4.0 / 3.0 * std::numbers::pi * std::pow(0.5 * small, 3), block = 27 * 4.0 / 3.0 * std::numbers::pi * std::pow(0.45 * spacing, 3);
    return std::pair(value(observers.headlines(), "t10"), 3 * grain / (block + 4 * grain));
  };
  const auto [found, expected] = t10(0.1 * spacing);
  CHECK(found == Approx(expected).epsilon(1e-9));
  CHECK(std::isnan(t10(0.4 * spacing).first));
}

TEST_CASE("D80 and D50 are the sieves that so much of the mass passes") {
  Simulation s = scene::bonded_space(scene::cement(), 1e-7);
  add_block(s, {0, 0, 0}, 3, 3, 3);
  for (int k = 1; k <= 4; ++k) add_block(s, {5 * spacing * k, 0, 0}, 2, 2, 2);
  const Index first = s.particles.size();
  for (int k = 0; k < 11; ++k) scene::add_grain(s, {0, 5 * spacing, spacing * k});
  for (Index k = first; k < first + 11; ++k) bond_particles(s.bonds, s.particles, s.domain, k - 1, k, 0, 1);
  for (Index k = first; k < first + 11; ++k) break_by_hand(s, k - 1, k);
  // Of 70 grains, 11 pass their own diameter, 43 the small blocks', all the large one's.
  const ProductSize size = product_size(s);
  CHECK(size.d80 == Approx(2.9 * spacing).epsilon(0.01));
  CHECK(size.d50 == Approx(1.9 * spacing).epsilon(0.01));
}

TEST_CASE("a broken off run that goes on writes the same damage, fragments and failures") {
  const char* files[] = {"damage.csv", "fragments.csv", "failures.csv", "fragment_sizes.csv", "fragment_speeds.csv", "product_sizes.csv", "crack_directions.csv"};
  const auto run = [](const Folder& folder, bool stops, bool resume, int threads) {
    Simulation s = falling_brick();
    Observers observers(only_fragments());
    s.start(false);
    OutputSettings settings;
    settings.name = "brick", settings.case_text = "name = \"brick\"\n", settings.pictures = false, settings.energy_interval = 1e-3;
    RunOptions options;
    options.directory = (folder.path / "out").string(), options.quiet = true, options.resume = resume, options.threads = threads;
    std::atomic<int> stop{0};
    options.stop_signal = &stop;
    if (stops) stop = SIGTERM;
    RunSummary last;
    // Each call takes one step and stops; then to the end.
    last = run_simulation(s, observers, settings, options, 6e-3);
    return last;
  };
  const Folder unbroken("fragments_a"), broken("fragments_b");
  const RunSummary summary = run(unbroken, false, false, 1);
  run(broken, true, false, 2);
  for (int k = 0; k < 3; ++k) run(broken, true, true, 1);
  run(broken, false, true, 2);
  for (const char* file : files) {
    INFO(file);
    CHECK(!unbroken.read(std::string("out/") + file).empty());
    CHECK(unbroken.read(std::string("out/") + file) == broken.read(std::string("out/") + file));
  }
  CHECK(value(summary.headlines, "damage_ratio") > 0.02);
  CHECK(value(summary.headlines, "fragment_count") > 2);
  const auto json = nlohmann::json::parse(unbroken.read("out/summary.json"));
  CHECK(json["largest_fragment_fraction"]["value"].get<double>() == value(summary.headlines, "largest_fragment_fraction"));

  // The masses of the file, read as anyone would, sum to the whole exactly.
  std::istringstream rows(unbroken.read("out/fragments.csv"));
  std::string row;
  std::getline(rows, row);
  CHECK(row.rfind("fragment,body,grains,mass [kg]", 0) == 0);
  double sum = 0;
  while (std::getline(rows, row)) {
    for (int k = 0; k < 3; ++k) row.erase(0, row.find(',') + 1);
    sum += std::stod(row);
  }
  CHECK(sum == json["fragment_mass"]["value"].get<double>());

  const std::string balls = unbroken.read("out/frames/balls_000001.vtp"), bonds = unbroken.read("out/frames/bonds_000001.vtp");
  CHECK((balls.find("\"fragment\"") != std::string::npos && balls.find("\"fragment_id\"") != std::string::npos));
  const auto intact = static_cast<int>(std::lround((1 - value(summary.headlines, "damage_ratio")) * (4 * 4 * 6 + 5 * 3 * 6 + 5 * 4 * 5)));
  CHECK(bonds.find("NumberOfLines=\"" + std::to_string(intact) + "\"") != std::string::npos);
  CHECK(bonds.find("\"stress\"") != std::string::npos);
  CHECK(unbroken.read("out/frames.pvd").find("frames/bonds_000001.vtp") != std::string::npos);
}

TEST_CASE("without bonds nothing of fragments is written, nor looked at") {
  const Folder folder("no_fragments");
  Simulation s = scene::free_space(scene::glass(), scene::linear(1e6, 0.7, 0.3), 1e-6);
  scene::add_ball(s, {0, 0, 0}, 0.01, {0, 0, 0});
  Observers observers(only_fragments());
  s.start(false);
  OutputSettings settings;
  settings.name = "ball", settings.case_text = "name = \"ball\"\n", settings.pictures = false;
  RunOptions options;
  options.directory = (folder.path / "out").string(), options.quiet = true;
  const RunSummary summary = run_simulation(s, observers, settings, options, 1e-3);
  CHECK_FALSE(observers.fragments.began);
  CHECK(observers.tables().empty());
  CHECK(std::isnan(value(summary.headlines, "damage_ratio")));
  for (const char* file : {"damage.csv", "fragments.csv", "failures.csv", "frames/bonds_000000.vtp"}) CHECK_FALSE(std::filesystem::exists(folder.path / "out" / file));
  CHECK(folder.read("out/frames/balls_000000.vtp").find("\"fragment\"") == std::string::npos);
}
