#include "src/case/case.hpp"
#include <catch2/catch.hpp>
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/build.hpp"
#include "src/case/grid.hpp"
#include "src/case/keys.hpp"
#include "src/case/reference.hpp"
#include "src/case/values.hpp"
#include "src/contact/restitution.hpp"
#include "tests/places.hpp"

using namespace quern;
using Catch::Contains;

namespace {

const std::string mill_case = std::string(quern::source_directory) + "/cases/mill_545mm/case.toml";

// A case in a file of its own, removed at the end.
struct TemporaryCase {
  std::filesystem::path path;
  explicit TemporaryCase(const std::string& text) {
    static int count = 0;
    path = std::filesystem::temp_directory_path() / ("quern_case_" + std::to_string(getpid()) + "_" + std::to_string(count++) + ".toml");
    std::ofstream(path) << text;
  }
  ~TemporaryCase() { std::filesystem::remove(path); }
  std::string file() const { return path.string(); }
};

// The echo marks what the user did not give.
std::string without_marks(std::string text) {
  const std::string mark = " (default)";
  for (std::size_t at = 0; (at = text.find(mark, at)) != text.npos;) text.erase(at, mark.size());
  return text;
}

const char* drop = R"(
duration = "10 ms"
[material.steel]
density = "7.8 g/cm3"
young = "206 GPa"
[material.glass]
density = 2500
young = 7e10
poisson = 0.2
[pair.steel.glass]
restitution = "60 %"
friction = 0.3
[species.ball]
material = "steel"
diameter = "10 mm"
[wall.floor]
type = "plane"
material = "glass"
[insert.one]
species = "ball"
positions = [["1 cm", 0, "2 cm"]]
velocity = [0, 0, "-50 cm/s"]
spin = ["60 rpm", 0, 0]
)" "[pair.steel.steel]\nlaw = \"linear\"\nnormal_stiffness = 1e6\nrestitution = 1\n";

}  // namespace

TEST_CASE("A case is read into SI units, whatever units it is written in", "[case]") {
  const TemporaryCase file(drop);
  const Case c = read_case(file.file());
  CHECK(c.duration == Approx(0.01));
  CHECK(c.materials[1].name == "steel");
  CHECK(c.materials[1].density == Approx(7800));
  CHECK(c.materials[1].young == Approx(206e9));
  CHECK(c.materials[1].poisson == 0.3);
  CHECK(*c.pairs[0].restitution == Approx(0.6));
  CHECK(c.inserts[0].balls[0].position == Vec3(0.01, 0, 0.02));
  CHECK(c.inserts[0].balls[0].velocity.z() == Approx(-0.5));
  CHECK(c.inserts[0].balls[0].spin.x() == Approx(2 * 3.14159265358979));
  CHECK(c.gravity == Vec3(0, 0, -9.81));
}

TEST_CASE("An override is laid over the case before it is checked, and is named where it is wrong", "[case]") {
  const TemporaryCase file(drop);
  CHECK(read_case(file.file(), {"species.ball.diameter=2 cm"}).species[0].sizes.largest() == Approx(0.02));
  CHECK(read_case(file.file(), {"pair.steel.glass.friction=0.9"}).pairs[0].friction == 0.9);
  CHECK(read_case(file.file(), {"pair.glass.steel.friction=0.9"}).pairs[0].friction == 0.9);
  CHECK(read_case(file.file(), {"gravity=[0, 0, 0]"}).gravity.norm() == 0);
  CHECK_THROWS_WITH(read_case(file.file(), {"pair.steel.glass.frction=0.9"}), Contains("--set pair.steel.glass.frction=0.9") && Contains("pair.glass.steel.friction"));
  CHECK_THROWS_WITH(read_case(file.file(), {"duration=-1"}), Contains("--set duration=-1") && Contains("more than 0 s"));
  CHECK_THROWS_AS(read_case(file.file(), {"duration"}), InputError);
}

TEST_CASE("The echo of a complete case reads back as the same case", "[case]") {
  const TemporaryCase drop_file(drop);
  for (const std::string& source : {mill_case, drop_file.file()}) {
    const Case first = read_case(source);
    const TemporaryCase echo(first.text);
    const Case second = read_case(echo.file());
    CHECK(without_marks(second.text) == without_marks(first.text));
    CHECK(second.name == first.name);
    CHECK_THAT(first.text, Contains("(default)"));
  }
}

TEST_CASE("Every key of the table has a meaning, a default of its own kind and a unit that is known", "[case]") {
  for (const Key& key : all_keys()) {
    INFO(key.path);
    CHECK(std::string(key.meaning).size() > 3);
    CHECK(find_key(split_path(key.path)) == &key);
    CHECK((key.kind != KeyKind::word || !words_of(key).empty()));
    if (key.kind == KeyKind::number && std::string(key.unit) != "1") CHECK_NOTHROW(Units().read(std::string("1 ") + key.unit, key.unit));
    if (key.kind == KeyKind::number || key.kind == KeyKind::vector) CHECK(std::string(key.unit) != "");
    CHECK(allowed_by(key) != "");
  }
}

TEST_CASE("The page of keys is the one that the program makes", "[case]") {
  std::ifstream stream(std::string(quern::source_directory) + "/docs/case-reference.md");
  const std::string page(std::istreambuf_iterator<char>(stream), {});
  CHECK(page == case_reference());  // quern list keys --markdown > docs/case-reference.md
}

TEST_CASE("A misspelt key is answered with the nearest one, in the user's own names", "[case]") {
  CHECK(nearest_key({"material", "steel", "yuong"}) == "material.steel.young");
  CHECK(nearest_key({"materials", "steel", "density"}) == "material.steel.density");
  CHECK(nearest_key({"pair", "default", "restitutoin"}) == "pair.default.restitution");
  CHECK(nearest_key({"mill", "speed_fracton"}) == "mill.speed_fraction");
  CHECK(nearest_key({"lifters", "count"}) == "mill.lifters.count");
  CHECK(nearest_word("hertzmindlin", {"linear", "hertz_mindlin"}) == "hertz_mindlin");
  CHECK(nearest_word("xyz", {"linear", "hertz_mindlin"}) == "");
}

TEST_CASE("A grid is all combinations, from lists and from evenly spread ranges", "[case]") {
  CHECK(read_swept_key("mill.speed_fraction=0.5:1.0:6").values == std::vector<std::string>{"0.5", "0.6", "0.7", "0.8", "0.9", "1"});
  CHECK(read_swept_key("pair.default.law=linear,hertz_mindlin").values.size() == 2);
  CHECK(read_swept_key("gravity=[0, 0, -9.81],[0, 0, -1.62]").values.size() == 2);
  CHECK(grid_of({read_swept_key("seed=1,2,3"), read_swept_key("pair.default.friction=0.1,0.2")}).size() == 6);
  CHECK_THROWS_WITH(read_swept_key("mill.sped=1,2"), Contains("mill.speed"));
  CHECK_THROWS_AS(read_swept_key("mill.speed=1:2:1"), InputError);
}

TEST_CASE("Laws of a case measure the restitution that it asks for", "[case]") {
  const TemporaryCase file(drop);
  const Simulation s = build(read_case(file.file()));
  const PairLaw& law = s.pair_laws[s.pair_kind[0 * 2 + 1]];
  REQUIRE(std::holds_alternative<HertzMindlin>(law.law));
  for (const double speed : {0.05, 0.5, 5.0}) CHECK(collide_head_on(law.law, 0.005, 0.004, speed).restitution == Approx(0.6).margin(1e-3));
  CHECK(law.rolling.model == RollingModel::none);
}

TEST_CASE("A penetration factor gives the stiffness f² m v²/d²", "[case]") {
  PairCase pair;
  pair.law = LawKind::linear;
  pair.restitution = 0.5, pair.penetration_factor = 20, pair.max_speed = 3, pair.tangential_ratio = 0.5;
  const Material steel{"steel", 7800, 0, 0.3};
  const Linear law = std::get<Linear>(law_of(pair, steel, steel, 0.2, 0.04, "case.toml").law);
  CHECK(law.normal_stiffness == Approx(400 * 0.2 * 9 / 0.0016));
  CHECK(law.tangential_stiffness == Approx(0.5 * law.normal_stiffness));
  // The ball then penetrates d/f when it hits a fixed body at that speed without damping.
  CHECK(collide_head_on(Linear{law.normal_stiffness, 0, 0, 0}, 0.02, 0.2, 3).peak_overlap == Approx(0.04 / 20).epsilon(1e-4));
}

TEST_CASE("The 54.5 cm mill has 324 balls of 140 kg and fills to 42 %", "[case]") {
  const Case c = read_case(mill_case);
  const Built built = build_case(c);
  const Particles& p = built.simulation.particles;
  double mass = 0;
  for (Index i = 0; i < p.owned; ++i) mass += p.mass(i);
  CHECK(p.owned == 324);
  CHECK(mass == Approx(140).margin(0.01));
  CHECK(built.filling == Approx(0.423).margin(0.001));
  CHECK(c.mill->speed == Approx(0.75 * std::sqrt(2 * 9.81 / (0.545 - 0.054))));
  CHECK(built.simulation.clock.time_step > 0);
  CHECK(built.simulation.clock.time_step <= built.limit.limit);
}

TEST_CASE("A time step above its limit is refused with the limit's reason, unless the case calls it unsafe", "[case]") {
  const TemporaryCase file(drop);
  CHECK_THROWS_WITH(build(read_case(file.file(), {"time_step.value=1e-3"})), Contains("time_step.value") && Contains("limit"));
  const Built built = build_case(read_case(file.file(), {"time_step.value=1e-3", "time_step.unsafe=true"}));
  CHECK(built.simulation.clock.time_step == 1e-3);
  CHECK(built.warnings.size() == 1);
}
