// From measured moduli and strength back to the bonds.
#include <catch2/catch.hpp>
#include "src/base/error.hpp"
#include "src/calibrate/bonds.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

Case stone(const Folder& folder, const std::string& bond) {
  return read_case(folder.write("case.toml", R"(
duration = "1 ms"
[material.stone]
density = 2600
young = "20 GPa"
poisson = 0.2
[pair.default]
restitution = 0.5
friction = 0.5
[species.grain]
material = "stone"
diameter = "2 mm"
[agglomerate.stone]
shape = "sphere"
radius = "10 mm"
grains = ["grain"]
[insert.stone]
agglomerate = "stone"
positions = [[0, 0, 0]]
[bond.default]
damping = 0.1
)" + bond));
}

}  // namespace

TEST_CASE("Calibration finds the bonds of a specimen from what was measured on it") {
  const Folder folder("calibration");
  // Measured on bonds of 8 GPa, ratio 3, 6 and 18 MPa …
  const Case made = stone(folder, "young = \"8 GPa\"\nstiffness_ratio = 3\ntensile_strength = \"6 MPa\"\nshear_strength = \"18 MPa\"\n");
  const Specimen specimen = make_specimen(made, 0, 150, made.seed);
  const Elasticity elasticity = measure_elasticity(specimen, {});
  const Strength strength = measure_strength(specimen, {}, Pull::tension);
  CHECK(strength.failed);
  CHECK(elasticity.poisson > 0.05);
  // … and found again from others: one specimen from the same seed, so that nothing but the search errs.
  BondRequest request;
  request.targets = {elasticity.young, elasticity.poisson, strength.stress, std::nullopt};
  request.grains = 150, request.specimens = 1, request.sizes = false;
  const Case other = stone(folder, "young = \"20 GPa\"\ntensile_strength = \"1 MPa\"\nshear_strength = \"3 MPa\"\n");
  const BondCalibration found = calibrate_bonds(other, request);
  const BondMaterial& bond = found.bonds.front().material;
  CHECK(bond.young == Approx(8e9).epsilon(0.02));
  CHECK(bond.young / bond.shear_modulus == Approx(3).epsilon(0.05));
  CHECK(bond.strength.tensile == Approx(6e6).epsilon(0.03));
  CHECK(bond.strength.shear == Approx(18e6).epsilon(0.03));
  CHECK(found.reached.young.mean == Approx(elasticity.young).epsilon(0.003));
  CHECK(found.remarks.empty());
}

TEST_CASE("A Poisson's ratio beyond what the packing can have is told with what it can") {
  const Folder folder("range");
  BondRequest request;
  request.targets = {5e9, -0.2, std::nullopt, std::nullopt};  // wider when pulled: no parallel bonds do that
  request.grains = 120, request.specimens = 1, request.sizes = false;
  const BondCalibration found = calibrate_bonds(stone(folder, "young = \"8 GPa\"\n"), request);
  REQUIRE(found.remarks.size() == 1);
  CHECK_THAT(found.remarks[0], Catch::Contains("cannot be reached"));
  CHECK(found.reached.young.mean == Approx(5e9).epsilon(0.003));
}

TEST_CASE("Specimens are measured alike by any number of threads") {
  const Folder folder("threads");
  BondRequest request;
  request.targets.young = 5e9;
  request.grains = 120, request.specimens = 3, request.sizes = false;
  const Case c = stone(folder, "young = \"8 GPa\"\n");
  const BondCalibration alone = calibrate_bonds(c, request);
  request.threads = 3;
  const BondCalibration together = calibrate_bonds(c, request);
  CHECK(alone.scale.young == together.scale.young);
  CHECK(alone.reached.poisson.mean == together.reached.poisson.mean);
  CHECK(alone.reached.young.deviation > 0);
}

TEST_CASE("quern calibrate bonds refuses what it cannot do in one sentence") {
  const Folder folder("refused");
  stone(folder, "young = \"8 GPa\"\n");
  const std::string file = (folder.path / "case.toml").string();
  const auto refused = [&](const std::string& arguments, const std::string& expected) {
    CHECK(run_quern("calibrate bonds " + arguments, folder.path / "log") == 2);
    CHECK_THAT(folder.read("log"), Catch::Contains(expected));
  };
  refused(file + " --young '-1 GPa'", "--young");
  refused(file + " --young '1 GPa' --poisson 0.6", "less than 0.5");
  refused(file + " --young '1 GPa' --agglomerate sand", "one of stone");
  refused(file + " --young '1 GPa' --grains 10", "100 to 100000");
  refused((folder.path / "none.toml").string() + " --young '1 GPa'", "none.toml");
}
