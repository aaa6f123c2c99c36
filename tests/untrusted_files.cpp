// Files from others: a case reads nothing outside its folder unless asked, and no size or index in a file is believed.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include "src/base/archive.hpp"
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/case/case.hpp"
#include "src/case/csv.hpp"
#include "src/case/values.hpp"
#include "src/convert/converted.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/observe/soundness.hpp"
#include "src/wall/stl.hpp"
#include "tests/folder.hpp"
#include "tests/scene.hpp"

using namespace quern;
using Catch::Matchers::Contains;

namespace {

constexpr const char* sieved = R"(
duration = 1
[material.steel]
density = 7800
young = 1e8
[pair.default]
restitution = 0.5
[species.ball]
material = "steel"
table = "sizes.csv"
[mill]
diameter = 0.3
length = 0.1
speed = 5
[insert.charge]
species = "ball"
count = 10
)";
constexpr const char* watched = R"(
name = "watched"
duration = "1 s"
[material.steel]
density = 7800
young = "10 MPa"
[pair.default]
restitution = 0.6
friction = 0.5
[species.ball]
material = "steel"
diameter = "25 mm"
[mill]
type = "tumbling"
diameter = "0.1 m"
length = "0.05 m"
speed_fraction = 0.7
[insert.charge]
species = "ball"
count = 6
[observe]
charge = true
spectrum = true
contact_history = true
track = [0, 3]
signal = true
)";
constexpr const char* sizes = "diameter [mm],finer\n5,0\n10,1\n";

std::string with(const std::string& name) {
  std::string text = sieved;
  text.replace(text.find("sizes.csv"), 9, name);
  return text;
}

std::string complaint(const std::string& file, const std::vector<std::string>& overrides = {}) {
  try {
    read_case(file, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a case names files in its own folder and below, others only where the person asks for it") {
  const Folder folder("outside");
  folder.write("sizes.csv", sizes);
  folder.write("case/sizes.csv", sizes);
  folder.write("case/below/sizes.csv", sizes);
  folder.write("case-of-another/sizes.csv", sizes);
  for (const char* inside : {"sizes.csv", "below/sizes.csv", "./below/../sizes.csv"}) CHECK(complaint(folder.write("case/case.toml", with(inside))) == "");
  CHECK(complaint(folder.write("case/case.toml", with((folder.path / "case/sizes.csv").string()))) == "");
  const std::string outside = (folder.path / "sizes.csv").string();
  for (const std::string& name : {std::string("../sizes.csv"), outside, std::string("below/../../sizes.csv"), std::string("../case-of-another/sizes.csv"), std::string("/etc/passwd")}) {
    const std::string file = folder.write("case/case.toml", with(name));
    CHECK_THAT(complaint(file), Contains("case.toml:10: species.ball.table: found \"" + name + "\", which is outside the folder of the case") && Contains("--allow-outside"));
  }
  std::filesystem::create_symlink(outside, folder.path / "case/link.csv");
  CHECK_THAT(complaint(folder.write("case/case.toml", with("link.csv"))), Contains("outside the folder"));
  // Asked for: in the command itself, or for all.
  CHECK(complaint(folder.write("case/case.toml", sieved), {"species.ball.table=" + outside}) == "");
  folder.write("case/case.toml", with("../sizes.csv"));
  const std::string file = (folder.path / "case/case.toml").string();
  CHECK(run_quern("check '" + file + "'", folder.path / "log") == 2);
  CHECK(run_quern("check '" + file + "' --allow-outside", folder.path / "log") == 0);
  CHECK(run_quern("--allow-outside check '" + file + "'", folder.path / "log") == 0);
}

TEST_CASE("the echo of a case is complete: it runs where it is moved, with copies of its files") {
  const Folder folder("echo");
  folder.write("case/below/si zes.csv", sizes);
  const Case first = read_case(folder.write("case/case.toml", with("below/si zes.csv")));
  REQUIRE(first.files.size() == 1);
  CHECK_THAT(first.files[0].name, Contains("files/si_zes_"));
  folder.write("elsewhere/case.toml", first.text);
  copy_files(first.files, (folder.path / "elsewhere").string());
  const Case again = read_case((folder.path / "elsewhere/case.toml").string());
  CHECK(again.species[0].sizes.smallest() == first.species[0].sizes.smallest());
  // A file that holds something else makes another case.
  folder.write("case/below/si zes.csv", "diameter [mm],finer\n5,0\n12,1\n");
  CHECK(read_case((folder.path / "case/case.toml").string()).text != first.text);
}

TEST_CASE("sizes that files announce or have are limited") {
  const Folder folder("sizes");
  std::string announced(80, ' ');
  const std::uint32_t triangles = 4000000000u;
  announced.append(reinterpret_cast<const char*>(&triangles), 4);
  StlReport report;
  CHECK_THROWS_WITH(read_stl(folder.write("mesh.stl", announced + std::string(500, 'x')), 1, report), Contains("announces 4000000000 triangles"));
  CHECK_THROWS_WITH(read_cells(folder.write("wide.csv", std::string(5000, ','))), Contains("5001 cells; allowed are 1000"));
  CHECK_THROWS_WITH(read_cells(folder.write("long.csv", "a\n" + std::string(5000, '1'))), Contains("a cell of 5000 characters"));
  const std::string large = folder.write("large.csv", "a\n1\n");
  std::filesystem::resize_file(large, std::uintmax_t{300} << 20);
  CHECK_THROWS_WITH(read_cells(large), Contains("at most 256 MB"));
  CHECK_THROWS_WITH(read_cells("/dev/zero"), Contains("at most 256 MB"));
  const std::string mesh = folder.write("large.stl", "solid");
  std::filesystem::resize_file(mesh, std::uintmax_t{2} << 30);
  CHECK_THROWS_WITH(read_stl(mesh, 1, report), Contains("at most 1 GB"));
}

TEST_CASE("a state that was tampered with is refused or can be stepped") {
  const Material steel{"steel", 7800, 5e7, 0.3};
  Simulation s = scene::free_space(steel, scene::hertz(steel, steel, 0.6, 0.5), 2e-5);
  Wall floor;
  floor.surface = Plane{};
  s.walls.push_back(floor);
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y) scene::add_ball(s, {0.0099 * x, 0.0099 * y, 0.00499}, 0.005, {0, 0, 0.01 * x});
  s.start(true);
  for (int k = 0; k < 20; ++k) s.step();
  const std::string state = ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
  std::mt19937 random(7);
  int refused = 0;
  constexpr int trials = 3000;
  for (int trial = 0; trial < trials; ++trial) {
    std::string spoilt = state;
    // A number of 4 or 8 bytes somewhere becomes another, or the end is missing.
    const std::size_t at = random() % (spoilt.size() - 8) / 4 * 4;
    constexpr std::int64_t others[] = {-1, -2, 1000000000, 0x7fffffffffffffff, 17, 1 << 20};
    if (trial % 10 == 0) spoilt.resize(at);
    else std::memcpy(spoilt.data() + at, &others[random() % 6], trial % 2 ? 4 : 8);
    Simulation again = s;
    try {
      ArchiveReader reader(spoilt);
      archive_state(reader, again);
    } catch (const InputError&) {
      ++refused;
      continue;
    }
    again.step();
  }
  CHECK(refused > trials / 10);
  CHECK(refused < trials);
}

TEST_CASE("what observers have from a state that was tampered with is refused or goes on to tables") {
  const Case read = named_case_of(read_values_in(watched, "/nowhere/case.toml", {}));
  Built built = build_case(read);
  Simulation& s = built.simulation;
  Observers observers(built.observe);
  s.start(observers.needs_collisions());
  observers.see(s);
  for (int k = 0; k < 400; ++k) s.step(), observers.see(s);
  CHECK(sound(observers, s));
  const std::string state = ArchiveWriter::written_by([&](ArchiveWriter& a) { a(observers); });
  std::mt19937 random(11);
  int refused = 0;
  constexpr int trials = 2000;
  for (int trial = 0; trial < trials; ++trial) {
    std::string spoilt = state;
    const std::size_t at = random() % (spoilt.size() - 8);
    constexpr std::int64_t others[] = {-1, 0, 1, 1000000000, 0x7fffffffffffffff, 0x7ff8000000000000};
    std::memcpy(spoilt.data() + at, &others[random() % 6], trial % 3 ? 8 : 4);
    Observers again(built.observe);
    Simulation later = s;
    try {
      ArchiveReader reader(spoilt);
      reader(again);
    } catch (const InputError&) {
      ++refused;
      continue;
    }
    if (!sound(again, later)) {
      ++refused;
      continue;
    }
    later.step();
    again.see(later), again.finish(later);
    again.headlines(), again.tables();
  }
  // Most of it are numbers of series, which may be any.
  CHECK(refused > 0);
  CHECK(refused < trials);
  // A list that is shorter than the others.
  Observers shorter = observers;
  shorter.torque_power.torque.pop_back();
  CHECK_FALSE(sound(shorter, s));
  shorter = observers, shorter.captures.mass.pop_back();
  CHECK_FALSE(sound(shorter, s));
  shorter = observers, shorter.charge.blocks.blocks.back().sums.layer.pop_back();
  CHECK_FALSE(sound(shorter, s));
  shorter = observers, shorter.signal.wall = 99;
  CHECK_FALSE(sound(shorter, s));
}

TEST_CASE("an input script of LIGGGHTS becomes the case that it means, and what is left out is said") {
  const Folder folder("convert");
  const std::string script = std::string(source_directory) + "/fuzz/corpus/script/drum";
  const Converted made = convert_liggghts(script);
  REQUIRE(made.meshes == std::vector<std::string>{"drum.stl"});
  folder.write("drum.stl", "");
  const Case c = read_case(folder.write("case.toml", made.text));
  CHECK(c.duration == Approx(20001 * 1e-5));
  CHECK(c.gravity.isApprox(Vec3(0, 0, -9.81)));
  REQUIRE(c.materials.size() == 2);
  CHECK(c.materials[0].density == 2500);
  REQUIRE(c.species.size() == 2);
  CHECK(c.species[0].sizes.smallest() == 0.02);
  REQUIRE(c.frames.size() == 1);
  CHECK(c.walls.size() == 2);
  // 100 particles of which the templates have 0.3 and 0.7 of the mass, radii 10 and 20 mm: 77 and 23 by number.
  REQUIRE(c.inserts.size() == 2);
  CHECK(c.inserts[0].count + c.inserts[1].count == 100);
  CHECK(std::max(c.inserts[0].count, c.inserts[1].count) == 77);
  CHECK(c.pairs.size() == 3);
  for (const PairCase& pair : c.pairs) CHECK((pair.restitution == 0.9 && pair.friction == 0.5));
  const Converted spoilt = convert_liggghts(folder.write("in.script", "units si\nfix a all property/global youngsModulus peratomtype 5e6\nfix b all viscous 3\npair_style gran model hooke tangential history\n"));
  REQUIRE(spoilt.left_out.size() == 2);
  CHECK_THAT(spoilt.left_out[0], Contains("in.script:3: fix b all viscous 3"));
  CHECK_THROWS_WITH(convert_liggghts(folder.write("lj.script", "units lj\n")), Contains("lj.script:1") && Contains("units si"));
}

TEST_CASE("a script cannot make the case that it becomes another: values of variables, names and types are held in bounds") {
  const Folder folder("convert_bounds");
  // Eight letters, doubled in each line: a megabyte at the seventeenth time, in line 18.
  std::string doubled = "variable a0 string xxxxxxxx\n";
  for (int k = 1; k < 30; ++k) doubled += "variable a" + std::to_string(k) + " string ${a" + std::to_string(k - 1) + "}${a" + std::to_string(k - 1) + "}\n";
  CHECK_THROWS_WITH(convert_liggghts(folder.write("doubled", doubled)), Contains("doubled:18") && Contains("longer than 1 MB"));
  const Converted made = convert_liggghts(folder.write("in.script",
      "fix t all particletemplate/sphere 1 atom_type 1e300 density constant 2500 radius constant 0.01\n"
      "fix a.b all mesh/surface file x\"y\\z.stl type 1e10\n"
      "fix a.b all mesh/surface file x\"y\\z.stl type 2\nfix a_b all mesh/surface file other.stl\nfix a_b all mesh/surface file last.stl\n"
      "fix w all wall/gran model hertz mesh n_meshes 2 meshes a.b a_b\n"
      "fix s all particletemplate/sphere 1 density constant 2500 radius constant 0.01\nfix s all particletemplate/sphere 1 density constant 2600 radius constant 0.01\n"
      "fix d all particledistribution/discrete 1 2 s 0.5 s 0.5\nfix i all insert/pack distributiontemplate d particles_in_region 10\nfix i all insert/pack distributiontemplate d particles_in_region 20\n"));
  REQUIRE(made.left_out.size() == 4);  // two types, and the region of each insertion
  CHECK_THAT(made.left_out[0], Contains("in.script:1") && Contains("its type is out of range"));
  CHECK_THAT(made.left_out[1], Contains("in.script:2") && Contains("its type is out of range"));
  // Five values for pairs are none: found by fuzz/script.
  const Converted odd = convert_liggghts(folder.write("odd", "fix a all property/global youngsModulus peratomtype 1e6 1e6 1e6\nfix b all property/global coefficientFriction peratomtype 1 1 1 1 1\n"));
  REQUIRE(odd.left_out.size() == 1);
  CHECK_THAT(odd.left_out[0], Contains("odd:2") && Contains("peratomtypepair"));
  const Values values = read_values_in(made.text, "text", {});
  CHECK(values.text("wall.a_b.file") == "x\"y\\z.stl");
  CHECK(values.names("wall").size() == 2);
  CHECK(values.number("species.s.density") == 2600);
  CHECK(values.names("insert") == std::vector<std::string>{"i_s"});
  CHECK(values.whole("insert.i_s.count") == 20);
}

TEST_CASE("tables of materials become those of a case: Young's modulus from the shear modulus") {
  const Folder folder("materials");
  const std::string materials = folder.write("materials.csv", "material,density [g/cm3],poisson,shear_modulus [GPa]\nsteel,7.8,0.25,80\n");
  const std::string pairs = folder.write("interactions.csv", "a,b,restitution,static_friction,rolling_friction\nsteel,steel,0.5,0.4,0.01\n");
  const std::string text = convert_materials({materials, pairs}).text;
  const Values values = read_values_in("duration = 1\n" + text, "text", {});
  CHECK(values.number("material.steel.young") == Approx(2 * 80e9 * 1.25));
  CHECK(values.number("material.steel.density") == Approx(7800));
  CHECK(values.number("pair.steel.steel.rolling_friction") == 0.01);
}
