// Bodies of one cement are stronger the faster they are strained and weaker the larger they are, by the powers that the case gives.
#include <catch2/catch.hpp>
#include <cmath>
#include "src/case/build.hpp"
#include "src/case/values.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

const char* granule = R"(
duration = 1e-4
[material.paste]
density = 2000
young = 1e9
[pair.paste.paste]
restitution = 0.5
[species.grain]
material = "paste"
diameter = 0.002
[bond.default]
young = 1e9
tensile_strength = 1e6
shear_strength = 2e6
[agglomerate.granule]
shape = "sphere"
radius = 0.006
grains = ["grain"]
[insert.granule]
agglomerate = "granule"
positions = [[0, 0, 0]]
velocity = [0, 0, -1]
)";

struct Strength {
  double tensile, shear, size;
};

Strength strength_of(const std::vector<std::string>& overrides) {
  const Folder folder("body_strength");
  const Built built = build_case(case_of(read_values(folder.write("case.toml", granule), overrides)));
  const Particles& grains = built.simulation.particles;
  double reach = 0;
  for (Index i = 0; i < grains.owned; ++i) reach = std::max(reach, vec(grains.position[static_cast<std::size_t>(i)]).norm() + grains.position[static_cast<std::size_t>(i)].w);
  const Bond& bond = built.simulation.bonds.list.front();
  return {bond.tensile_strength, bond.shear_strength, 2 * reach};
}

}  // namespace

TEST_CASE("a body that hits eight times as fast is twice as strong where strength goes with the cube root of the rate", "[bonds]") {
  const std::vector<std::string> law = {"bond.default.rate_exponent=0.3333333333333333", "bond.default.reference_rate=10"};
  const auto with = [&](const char* speed) {
    std::vector<std::string> all = law;
    all.push_back(std::string("insert.granule.speed=") + speed);
    return strength_of(all);
  };
  const Strength slow = with("1"), fast = with("8");
  CHECK(fast.tensile == Approx(2 * slow.tensile).epsilon(1e-12));
  CHECK(fast.shear == Approx(2 * slow.shear).epsilon(1e-12));
  CHECK(slow.tensile == Approx(1e6 * std::cbrt(1 / slow.size / 10)).epsilon(1e-12));
  CHECK(with("0.01").tensile == 1e6);  // below the reference it is as given
}

TEST_CASE("of weakest links, a body twice as large is weaker by 2^(−3/m)", "[bonds]") {
  const double modulus = 6, exponent = 3 / modulus;
  const Strength one = strength_of({"bond.default.size_exponent=0.5", "bond.default.reference_size=0.01"});
  CHECK(one.tensile == Approx(1e6 * std::pow(one.size / 0.01, -exponent)).epsilon(1e-12));
  const Strength half = strength_of({"bond.default.size_exponent=0.5", "bond.default.reference_size=0.005"});
  CHECK(half.tensile / one.tensile == Approx(std::pow(2.0, -exponent)).epsilon(1e-12));
}
