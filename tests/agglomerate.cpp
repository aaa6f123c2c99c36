#include "bonds/agglomerate.hpp"
#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

double solid_of(const std::vector<Grain>& grains, int species = -1) {
  double sum = 0;
  for (const Grain& g : grains)
    if (species < 0 || g.species == species) sum += std::numbers::pi / 6 * std::pow(g.diameter, 3);
  return sum;
}

double deepest_overlap(const std::vector<Grain>& grains) {
  double deepest = 0;
  for (const auto& [i, j] : near_pairs(grains, 0)) {
    const Grain &a = grains[static_cast<std::size_t>(i)], &b = grains[static_cast<std::size_t>(j)];
    deepest = std::max(deepest, 0.5 * (a.diameter + b.diameter) - (a.position - b.position).norm());
  }
  return deepest;
}

BodyRequest request_of(BodyShape shape, double grain, double fraction) {
  BodyRequest request;
  request.shape = std::move(shape);
  request.portions = {{0, SizeDistribution::mono(grain), 1}};
  request.solid_fraction = fraction;
  return request;
}

const char* const body_case = R"(
duration = "1 ms"
gravity = [0, 0, 0]
[material.stone]
density = 2500
young = "1 GPa"
[pair.stone.stone]
restitution = 0.5
friction = 0.3
[species.grain]
material = "stone"
diameter = "4 mm"
[species.ball]
material = "stone"
diameter = "20 mm"
[bond.default]
young = "1 GPa"
tensile_strength = "1 MPa"
shear_strength = "1 MPa"
[agglomerate.body]
shape = "sphere"
radius = "15 mm"
grains = ["grain"]
)";

}  // namespace

TEST_CASE("A body of every shape holds the solid fraction that was asked, without overlaps, and hangs together") {
  const Mesh brick = box_mesh({-0.02, -0.015, -0.01}, {0.02, 0.015, 0.01}, FreeSide::outside);
  const struct {
    BodyShape shape;
    double volume;      // [m³]
    double tolerance;   // of the solid fraction: a grain more or less; a cut-out also loses or wins at its surface
  } bodies[] = {
      {SphereRegion{0.02}, 4.0 / 3 * std::numbers::pi * 8e-6, 0.002},
      {CylinderRegion{0.015, -0.02, 0.02}, std::numbers::pi * 0.015 * 0.015 * 0.04, 0.002},
      {BoxRegion{{-0.02, -0.01, -0.015}, {0.02, 0.01, 0.015}}, 2.4e-5, 0.002},
      {SuperquadricRegion{{0.02, 0.02, 0.02}, 2}, 4.0 / 3 * std::numbers::pi * 8e-6, 0.05},
      {brick, 2.4e-5, 0.05},
  };
  for (const auto& body : bodies) {
    INFO("shape " << body.shape.index());
    CHECK(volume(body.shape) == Approx(body.volume).epsilon(1e-9));
    const std::vector<Grain> grains = pack_body(request_of(body.shape, 0.003, 0.56));
    CHECK(solid_of(grains) / body.volume == Approx(0.56).margin(body.tolerance));
    CHECK(deepest_overlap(grains) < 1e-9);
    for (const Grain& g : grains) CHECK(g.position.norm() <= reach(body.shape));
    const GrainPairs near = near_pairs(grains, 0.0004), delaunay = triangulated_pairs(grains, 0.0004);
    CHECK(std::includes(near.begin(), near.end(), delaunay.begin(), delaunay.end()));
    const BodyReport report = describe(grains, near, body.volume);
    CHECK(report.pieces == 1);
    // Dense random packings of spheres have about six near neighbours at a sphere; grains at the surface have fewer.
    CHECK(report.coordination > 4.5);
    CHECK(report.coordination < 8);
    CHECK(describe(grains, delaunay, body.volume).pieces == 1);
  }
}

TEST_CASE("A composite has its grains in the shares that were asked") {
  BodyRequest request = request_of(SphereRegion{0.03}, 0.003, 0.58);
  request.portions.push_back({1, SizeDistribution::mono(0.009), 0.5});
  const std::vector<Grain> grains = pack_body(request);
  CHECK(solid_of(grains, 1) / solid_of(grains) == Approx(1.0 / 3).margin(0.01));  // half a coarse grain
  CHECK(deepest_overlap(grains) < 1e-9);
}

TEST_CASE("Pairs by gap are all pairs within it") {
  const std::vector<Grain> grains = pack_body(request_of(BoxRegion{{-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}}, 0.004, 0.5));
  GrainPairs all;
  for (Index i = 0; i < static_cast<Index>(grains.size()); ++i)
    for (Index j = i + 1; j < static_cast<Index>(grains.size()); ++j)
      if ((grains[static_cast<std::size_t>(i)].position - grains[static_cast<std::size_t>(j)].position).norm() < 0.0045) all.emplace_back(i, j);
  CHECK(near_pairs(grains, 0.0005) == all);
}

TEST_CASE("A body starts without stress: left alone it stays at rest, thrown and spun it stays whole") {
  const Folder folder("body");
  const auto made = [&](const std::string& insert) { return build(read_case(folder.write("case.toml", std::string(body_case) + insert))); };
  Simulation still = made("[insert.a]\nagglomerate = \"body\"\npositions = [[0, 0, 0]]\n");
  still.start(false);
  for (int step = 0; step < 500; ++step) still.step();
  still.measure_energy();
  // Rounding alone: a bond fails at some 1e-5 J.
  CHECK(still.ledger.kinetic < 1e-25);
  CHECK(still.ledger.bond_energy < 1e-25);
  CHECK(still.ledger.elastic == 0);

  Simulation thrown = made("[insert.a]\nagglomerate = \"body\"\npositions = [[0, 0, 0]]\nvelocity = [3, 0, 0]\nspin = [0, 5, 0]\nturn = [0.3, 0.2, 1]\n");
  thrown.start(false);
  const double before = thrown.kinetic_and_potential()[0];
  const double mass = [&] {
    double sum = 0;
    for (Index i = 0; i < thrown.particles.owned; ++i) sum += thrown.particles.mass(i);
    return sum;
  }();
  CHECK(before > 0.5 * mass * 9);
  for (int step = 0; step < 500; ++step) thrown.step();
  CHECK(thrown.bonds.failures.empty());
  CHECK(thrown.kinetic_and_potential()[0] == Approx(before).epsilon(1e-6));  // spinning stretches it a little
}

TEST_CASE("Copies of a body are put into a mill among balls, each bonded in itself") {
  const Folder folder("bodies");
  std::string text = body_case;
  text.replace(text.find("[0, 0, 0]"), 9, "[0, 0, -9.81]");
  const std::string file = folder.write("case.toml", text + R"(
[mill]
diameter = "0.2 m"
length = "0.1 m"
speed = "60 rpm"
[insert.balls]
species = "ball"
count = 40
[insert.bodies]
agglomerate = "body"
count = 5
)");
  const Built built = build_case(read_case(file));
  REQUIRE(built.bodies.size() == 1);
  const BodyReport& body = built.bodies[0].second;
  const Simulation& s = built.simulation;
  CHECK(s.particles.owned == 40 + 5 * body.grains);
  CHECK(static_cast<std::int64_t>(s.bonds.list.size()) == 5 * body.bonds);
  // No bond reaches from one copy to another: none is longer than a grain and its gap.
  for (const Bond& bond : s.bonds.list) CHECK(bond.length < 0.0045);
}

TEST_CASE("Grains are read from a file with their kinds") {
  const Folder folder("assembly");
  folder.write("grains.csv", "x [m],y [m],z [m],diameter [m],kind\n0,0,0,0.004,0\n0.0041,0,0,0.004,0\n0,0.0122,0,0.02,1\n");
  std::string text = body_case;
  text.replace(text.find("shape = "), std::string::npos, "assembly = \"grains.csv\"\ngrains = [\"grain\", \"ball\"]\ngap = \"0.3 mm\"\n");
  const Simulation s = build(read_case(folder.write("case.toml", text + "[insert.a]\nagglomerate = \"body\"\npositions = [[0, 0, 0]]\n")));
  REQUIRE(s.particles.owned == 3);
  CHECK(s.particles.radius(2) == 0.01);
  CHECK(s.bonds.list.size() == 2);
}
