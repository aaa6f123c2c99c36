// Checks of cases against their sources: what is measured from results, and what is refused.
#include <unistd.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/case/validation.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("quern_validation_test_" + std::to_string(getpid()));
  Folder() { fs::remove_all(path), fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  void write(const std::string& file, const std::string& text) const {
    fs::create_directories((path / file).parent_path());
    std::ofstream(path / file) << text;
  }
  std::string at(const std::string& file) const { return (path / file).string(); }
};

const std::string head = "source = \"a paper\"\n[[run]]\nname = \"a\"\nsweep = [\"mill.speed_fraction=0.5:0.9:5\"]\n[[run]]\nname = \"b\"\nslow = true\n";

Check check_of(const Folder& folder, const std::string& figure) {
  folder.write("check.toml", head + "[[figure]]\nname = \"f\"\nrun = \"a\"\n" + figure);
  return read_check(folder.path.string());
}

// Power 10 − 100 (x − 0.72)², length 3 x²; a table that falls and rises.
RunResults results(const Folder& folder) {
  RunResults all;
  for (const double x : {0.5, 0.6, 0.7, 0.8, 0.9}) {
    const std::string name = "a/" + std::to_string(x);
    const double power = 10 - 100 * (x - 0.72) * (x - 0.72);
    folder.write(name + "/summary.json", "{\"power\": {\"value\": " + std::to_string(power) + ", \"unit\": \"W\", \"ci95\": [" + std::to_string(power - 1) + ", " + std::to_string(power + 1) +
                                             "]}, \"length\": {\"value\": " + std::to_string(3 * x * x) + "}}");
    folder.write(name + "/t.csv", "t [s],z [m],pair\n0,4,x\n1,2,x\n2,8,\"y\"\n3,,y\n");
    all["a"].push_back({{{"mill.speed_fraction", std::to_string(x)}}, folder.at(name)});
  }
  folder.write("b/summary.json", "{\"power\": {\"value\": 5, \"unit\": \"W\"}}");
  all["b"].push_back({{}, folder.at("b")});
  return all;
}

double measured(const std::string& figure) {
  const Folder folder;
  return measure(check_of(folder, figure).figures[0], results(folder)).value;
}

std::string refusal(const std::string& figure) {
  const Folder folder;
  try {
    measure(check_of(folder, figure).figures[0], results(folder));
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

const std::string band = "band = [0, 1]\n";

}  // namespace

TEST_CASE("a figure is read from the run of a sweep that it names, with its interval and scale") {
  const Folder folder;
  const Check check = check_of(folder, band + "value = \"power\"\nscale = 1000\nat = { \"mill.speed_fraction\" = 0.7 }\n");
  const Measured m = measure(check.figures[0], results(folder));
  CHECK(m.value == Approx(9960));
  REQUIRE(m.ci95);
  CHECK((*m.ci95)[0] == Approx(8960));
  CHECK((*m.ci95)[1] == Approx(10960));
}

TEST_CASE("peaks, exponents and slopes over a sweep are those of the function behind it") {
  CHECK(measured(band + "peak_at = { of = \"power\", over = \"mill.speed_fraction\" }") == Approx(0.72));
  CHECK(measured(band + "exponent = { of = \"length\", over = \"mill.speed_fraction\" }") == Approx(2).epsilon(1e-5));
  CHECK(measured(band + "slope = { of = \"length\", over = \"mill.speed_fraction\" }") == Approx(3 * 1.4));
  CHECK(measured(band + "largest = { of = \"length\" }") == Approx(3 * 0.81));
  CHECK(measured(band + "smallest = { of = \"length\" }") == Approx(0.75));
}

TEST_CASE("two runs are set in ratio or difference") {
  const std::string at = band + "at = { \"mill.speed_fraction\" = \"70 %\" }\n";
  CHECK(measured(at + "ratio = { of = \"power\", run = \"b\", at = {} }") == Approx(9.96 / 5));
  CHECK(measured(at + "difference = { of = \"power\", run = \"b\", at = {} }") == Approx(4.96));
}

TEST_CASE("a number of a table is picked, interpolated, divided and filtered") {
  const std::string at = band + "at = { \"mill.speed_fraction\" = 0.5 }\n";
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"z\", x = \"t\", at = 0.25 }") == Approx(3.5));
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"t\", x = \"z\", at = 3 }") == Approx(0.5));
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"z\", pick = \"last\" }") == 8);
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"z\", pick = \"min\" }") == 2);
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"z\", pick = \"first\", where = { pair = \"y\" } }") == 8);
  CHECK(measured(at + "table = { file = \"t.csv\", column = \"z\", over = \"t\", pick = \"last\" }") == 4);
}

TEST_CASE("what is not there is told in a sentence that names the figure") {
  CHECK_THAT(refusal(band + "value = \"powr\"\nat = { \"mill.speed_fraction\" = 0.5 }"), Catch::Contains("\"f\"") && Catch::Contains("nearest is power"));
  CHECK_THAT(refusal(band + "value = \"power\""), Catch::Contains("5 runs"));
  CHECK_THAT(refusal(band + "value = \"power\"\nat = { \"mill.speed_fraction\" = 0.55 }"), Catch::Contains("no run"));
  CHECK_THAT(refusal(band + "value = \"power\"\nvalu = 1"), Catch::Contains("check.toml:") && Catch::Contains("valu"));
  CHECK_THAT(refusal("value = \"power\""), Catch::Contains("band"));
  CHECK_THAT(refusal(band + "value = \"power\"\nknown_miss = true"), Catch::Contains("note"));
  CHECK_THAT(refusal("band = [1, 0]\nvalue = \"power\""), Catch::Contains("ascending"));
  CHECK_THAT(refusal(band + "largest = { of = \"power\" }\nvalue = \"power\""), Catch::Contains("2 measures"));
}

TEST_CASE("results are remembered, and the page shows misses as plainly as hits") {
  const Folder folder;
  Check check = check_of(folder, "band = [9, 11]\nvalue = \"power\"\nreference = 10\nkind = \"measured\"\n[[figure]]\nname = \"g\"\nrun = \"a\"\nvalue = \"power\"\nband = [20, inf]\n"
                                 "[[figure]]\nname = \"h\"\nrun = \"b\"\nvalue = \"power\"\nband = [0, 1]\n[[figure]]\nname = \"k\"\nrun = \"a\"\nvalue = \"power\"\nband = [0, 1]\nknown_miss = true\nnote = \"why\"\n");
  CHECK(check.slow(check.figures[2]));
  Memory memory;
  for (const char* name : {"f", "g", "k"}) memory[name] = {{10.5, {{10, 11}}}, "2026-01-01", "0.1.0"};
  CHECK(verdict(check.figures[0], memory) == "pass");
  CHECK(verdict(check.figures[1], memory) == "MISS");
  CHECK(verdict(check.figures[2], memory) == "not run");
  CHECK(verdict(check.figures[3], memory) == "MISS (known)");
  folder.write("result.json", memory_text(check, memory));
  const Memory again = read_memory(folder.path.string());
  CHECK(again.at("f").measured.ci95 == memory["f"].measured.ci95);
  CHECK(memory_text(check, again) == memory_text(check, memory));
  const std::string page = validation_page({check});
  CHECK_THAT(page, Catch::Contains("| f | 10.5 (10 … 11) | 10 | – | measured | 9 … 11 | pass |"));
  CHECK_THAT(page, Catch::Contains("| g | 10.5 (10 … 11) | – | – | – | at least 20 | **MISS** |"));
  CHECK_THAT(page, Catch::Contains("| h | – | – | – | – | 0 … 1 | not run |"));
  CHECK_THAT(page, Catch::Contains("**MISS (known)**"));
}

TEST_CASE("every check of a case in this project can be read") {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(quern::source_directory) / "cases")) {
    if (!fs::exists(entry.path() / "check.toml")) continue;
    CAPTURE(entry.path().string());
    CHECK_NOTHROW(read_check(entry.path().string()));
    ++count;
  }
  CHECK(count > 0);
}
