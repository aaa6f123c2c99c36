// Platens, gauges and what they record.
#include "src/observe/loading.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "mills/frame.hpp"
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/observe/observers.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

constexpr double spacing = 0.004;  // [m]

// A block of nx × nx columns of nz grains that just touch, bonded along the three directions of the lattice, between two platens.
std::string lattice_case(const Folder& folder, int nx, int nz, const std::string& more) {
  std::string grains = "x [m],y [m],z [m],diameter [m]\n";
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < nx; ++j)
      for (int k = 0; k < nz; ++k)
        grains += std::to_string(i * spacing) + "," + std::to_string(j * spacing) + "," + std::to_string((k + 0.5) * spacing) + ",0.004\n";
  folder.write("grains.csv", grains);
  const std::string top = std::to_string(nz * spacing);
  return folder.write("case.toml", R"(
duration = "1.2 ms"
gravity = [0, 0, 0]
[material.stone]
density = 2500
young = "10 GPa"
poisson = 0.2
[material.plate]
density = 7800
[pair.stone.stone]
law = "linear"
restitution = 0.5
normal_stiffness = 1      # next to nothing: bonds alone carry
[pair.stone.plate]
law = "linear"
restitution = 0.2
normal_stiffness = 1e8
[species.grain]
material = "stone"
diameter = "4 mm"
[bond.default]
young = "1 GPa"
damping = 0.3
[agglomerate.block]
assembly = "grains.csv"
grains = ["grain"]
gap = "0.1 mm"
[insert.block]
agglomerate = "block"
positions = [[0, 0, 0]]
[frame.press]
motion = "translation"
velocity = [0, 0, -0.02]
ramp = "0.4 ms"
[wall.bottom]
type = "plane"
material = "plate"
[wall.top]
type = "plane"
material = "plate"
frame = "press"
axis = [0, 0, -1]
point = [0, 0, )" + top + R"(]
[observe]
loading = ["top"]
strain = true
power = false
shell_force = false
spectrum = false
charge = false
)" + more);
}

struct Pressed {
  Simulation simulation;
  Observers observers;
  double direct_force = 0, direct_way = 0;  // of the wall, averaged by this test over the last interval
};

Pressed press(const std::string& file, double duration) {
  Built built = build_case(read_case(file));
  Pressed run{std::move(built.simulation), Observers(built.observe)};
  Simulation& s = run.simulation;
  s.start(false);
  run.observers.see(s);
  std::size_t rows = 0;
  double force = 0, seconds = 0;
  while (s.clock.time() < duration) {
    s.step();
    force -= s.clock.time_step * vec(s.walls[1].force).dot(Vec3(0, 0, -1)), seconds += s.clock.time_step;
    run.observers.see(s);
    if (run.observers.loading.time.size() == rows) continue;
    rows = run.observers.loading.time.size();
    run.direct_force = force / seconds;
    force = seconds = 0;
  }
  return run;
}

double headline(const Observers& observers, const std::string& key) {
  for (const Headline& line : observers.headlines())
    if (line.key == key) return line.value;
  FAIL("no headline " << key);
  return 0;
}

}  // namespace

TEST_CASE("A lattice of bonded grains between platens is as stiff as its bonds in rows") {
  const Folder folder("lattice");
  const int columns = 3, height = 12;
  const Pressed run = press(lattice_case(folder, columns, height, "loading_interval = \"6 us\"\n"), 1.2e-3);
  // Each column is a chain of bonds k_n A = E_b π r²/L_0; nothing is strained across, so columns carry alone.
  const double bond = 1e9 * std::numbers::pi * 0.002 * 0.002 / spacing;
  const double axial = columns * columns * bond * spacing;  // force over strain
  CHECK(headline(run.observers, "axial_stiffness") == Approx(axial).epsilon(0.01));
  CHECK(headline(run.observers, "specimen_poisson") == Approx(0).margin(0.01));
  // Over the platens the two contacts give way too: 1/K = (n − 1)/k_b + 2/k_w.
  const double chain = 1 / ((height - 1) / bond + 2 / 1e8);
  CHECK(headline(run.observers, "loading_stiffness") == Approx(columns * columns * chain).epsilon(0.03));
  // The table is the wall's own force, and the way that the ramp gives: v (t − ramp/2), at the middle of the interval.
  const Loading& loading = run.observers.loading;
  CHECK(loading.walls[0].force.back() == Approx(run.direct_force).epsilon(1e-12));
  const double interval = loading.time.back() - loading.time[loading.time.size() - 2];
  CHECK(loading.walls[0].displacement.back() == Approx(0.02 * (loading.time.back() - 0.5 * interval - 2e-4)).epsilon(1e-3));
  CHECK(loading.bond_energy.back() > 0);
  CHECK(headline(run.observers, "kinetic_over_bond_energy") < 0.05);
}

TEST_CASE("A gauge reads the way of its grains against the others") {
  const Folder folder("gauge");
  // Between two heights of a column pressed evenly: strain times their distance.
  const Pressed run = press(lattice_case(folder, 3, 16, "gauges = [[0.004, 0.004, 0.048], [0.004, 0.004, 0.016]]\n"), 1.2e-3);
  const Loading& loading = run.observers.loading;
  const auto mean_height = [](const std::vector<RestingGrain>& gauge) {
    double sum = 0;
    for (const RestingGrain& grain : gauge) sum += grain.place.z / static_cast<double>(gauge.size());
    return sum;
  };
  REQUIRE(loading.gauges.size() == 2);
  CHECK(loading.gauges[0].size() == 13);
  const double apart = mean_height(loading.gauges[0]) - mean_height(loading.gauges[1]);
  CHECK(apart == Approx(0.032).margin(0.004));
  CHECK(loading.gauge.back() == Approx(-loading.strain_along.back() * apart).epsilon(0.05));
}

TEST_CASE("A record with a toe, a linear part and a fall gives slope, peak and the way from the corrected foot") {
  Loading loading;
  loading.walls.resize(1);
  for (int k = 0; k <= 100; ++k) {
    const double way = 1e-6 * k;  // the line 2e6 N/m · (way − 20 µm), a toe below 4 N, a peak at 80 µm
    const double line = 2e6 * (way - 20e-6), toe = 4 * way / 22e-6;
    loading.time.push_back(1e-6 * k);
    loading.walls[0].displacement.push_back(way);
    loading.walls[0].force.push_back(k > 80 ? 10 : std::max(line, std::min(toe, 4.0)));
    loading.bond_energy.push_back(1 + k), loading.kinetic.push_back(0.01 * (1 + k)), loading.broken.push_back(k > 80 ? 5 : 0);
  }
  Observers observers;
  observers.settings.power = observers.settings.shell_force = observers.settings.charge = observers.settings.spectrum = false;
  observers.settings.loading = {LoadedWall{}};
  observers.loading = loading;
  CHECK(headline(observers, "peak_force") == Approx(120));
  CHECK(headline(observers, "loading_stiffness") == Approx(2e6));
  CHECK(headline(observers, "displacement_at_peak") == Approx(60e-6));
  CHECK(headline(observers, "kinetic_over_bond_energy") == Approx(0.01));
}

TEST_CASE("A ramped translation starts from rest and goes on at its velocity") {
  const std::vector<Frame> frames = {{"press", -1, Translating{Vec3(0, 0, 2), 0.5}}};
  CHECK(poses_at(frames, 0)[0].velocity.norm() == 0);
  CHECK(poses_at(frames, 0.25)[0].velocity.z() == Approx(1));
  CHECK(poses_at(frames, 0.25)[0].origin.z() == Approx(0.125));
  CHECK(poses_at(frames, 0.5)[0].origin.z() == Approx(0.5));
  CHECK(poses_at(frames, 2)[0].origin.z() == Approx(3.5));
  CHECK(poses_at(frames, 2)[0].velocity.z() == Approx(2));
}

TEST_CASE("A slope by least squares has the interval of its scatter") {
  const double x[] = {0, 1, 2, 3, 4, 5}, y[] = {-1, 1.1, 2.9, 5.1, 6.9, 9};
  const Slope slope = slope_of(x, y, 6);
  CHECK(slope.value == Approx(1.98857).epsilon(1e-5));
  CHECK(slope.zero == Approx(2.5 - 4 / 1.98857).epsilon(1e-4));
  CHECK(slope.ci95[0] < slope.value);
  CHECK(slope.ci95[1] > slope.value);
  CHECK(slope.ci95[1] - slope.ci95[0] < 0.2);
}
