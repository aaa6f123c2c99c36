// Softer contacts: what two runs say about each other, and `quern check --soften`.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include "src/base/random.hpp"
#include "src/case/build.hpp"
#include "src/case/softening.hpp"
#include "src/contact/restitution.hpp"
#include "src/observe/difference.hpp"
#include "tests/folder.hpp"

using namespace quern;
namespace fs = std::filesystem;

namespace {

Estimate within(double value, double half) { return {value, {{value - half, value + half}}}; }

const SoftRow& row_of(const SoftReport& report, const std::string& key) {
  for (const SoftRow& row : report.rows)
    if (row.key == key) return row;
  FAIL("no row " << key);
  return report.rows.front();
}

int run_check(const std::string& arguments, const fs::path& log) { return run_quern("check " + arguments, log); }

const std::string drop = R"(name = "drop"
duration = "40 ms"
[material.glass]
density = 2500
young = "100 GPa"
poisson = 0.25
[pair.glass.glass]
law = "hertz_mindlin"
restitution = 0.8
friction = 0.3
[species.ball]
material = "glass"
diameter = "10 mm"
[wall.floor]
type = "plane"
material = "glass"
[insert.ball]
species = "ball"
positions = [[0, 0, 0.0051]]
velocity = [0.4, 0, -1]
)";

}  // namespace

TEST_CASE("the interval of a difference is that of two independent means") {
  const Estimate d = difference(within(10, 3), within(12, 4));
  CHECK(d.value == Approx(2));
  CHECK((*d.ci95)[0] == Approx(2 - 5));
  CHECK((*d.ci95)[1] == Approx(2 + 5));
  // Each side takes its own errors: down 1 of the second with up 2 of the first, up 3 of the second with down 4 of the first.
  const Estimate skew = difference({0, {{-4, 2}}}, {0, {{-1, 3}}});
  CHECK((*skew.ci95)[0] == Approx(-std::sqrt(5)));
  CHECK((*skew.ci95)[1] == Approx(5));
  CHECK(!difference({1, {}}, within(2, 1)).ci95);
}

TEST_CASE("a difference moves, does not, or cannot be told") {
  CHECK(judge(within(7, 2), 5) == Verdict::moves);
  CHECK(judge(within(1, 2), 5) == Verdict::same);
  CHECK(judge(within(3, 1), 5) == Verdict::moves_little);
  CHECK(judge(within(4, 6), 5) == Verdict::unknown);
  CHECK(judge(within(4, 5), 5) == Verdict::unknown);  // up to 9
  // Judged among twenty, 3.02 standard errors are wanted for the 1.96 of one.
  CHECK(judge(within(7, 5), 5) == Verdict::moves);
  CHECK(judge(within(7, 5), 5, 20) == Verdict::unknown);
  CHECK(judge(within(7, 4.4), 5, 20) == Verdict::moves);
  CHECK(judge({0.5, {}}, 1) == Verdict::same);
  CHECK(judge({-2, {}}, 1) == Verdict::moves);
}

TEST_CASE("of equal things few are said to move, and runs as long as advised show nine in ten to be the same") {
  RandomStream random(11);
  const double error = 0.05, tolerance = 0.05;
  const double longer = longer_by(within(0, 1.96 * error * std::sqrt(2)), tolerance);
  CHECK(longer == Approx(std::pow((1.96 + 1.645) * std::sqrt(2), 2)).epsilon(1e-3));
  constexpr int trials = 20000;
  int moved = 0, same = 0;
  for (int k = 0; k < trials; ++k) {
    const auto measured = [&](double e) { return within(e * random.normal(), 1.96 * e); };
    moved += judge(difference(measured(error), measured(error)), tolerance) == Verdict::moves;
    const Verdict verdict = judge(difference(measured(error / std::sqrt(longer)), measured(error / std::sqrt(longer))), tolerance);
    same += verdict == Verdict::same || verdict == Verdict::moves_little;
  }
  CHECK(moved == Approx(0.05 * trials).epsilon(0.15));
  CHECK(same == Approx(0.90 * trials).epsilon(0.02));
}

TEST_CASE("softer laws keep their restitution at every speed, and collisions last longer") {
  const Folder folder("softening");
  const auto text = [](const std::string& law) {
    return "name = \"soft\"\nduration = 1\n[material.steel]\ndensity = 7800\nyoung = \"200 GPa\"\n[pair.default]\nfriction = 0.3\n" + law +
           "\n[species.ball]\nmaterial = \"steel\"\ndiameter = 0.04\n[insert.ball]\nspecies = \"ball\"\npositions = [[0, 0, 0], [0.1, 0, 0]]\n";
  };
  const std::vector<std::pair<std::string, double>> laws = {  // and the exponent of the force
      {"law = \"linear\"\nrestitution = 0.5\nnormal_stiffness = 1e6\ntangential_stiffness = 6e5", 1},
      {"law = \"linear\"\nrestitution = 0.5\npenetration_factor = 200\nmax_speed = 3", 1},
      {"law = \"hertz_mindlin\"\nrestitution = 0.5", 1.5},
      {"law = \"deresiewicz\"\nrestitution = 0.5", 1.5},
      {"law = \"power_law\"\nstiffness_coefficient = 5e10\ndamping_coefficient = 4.8e6\nimpact_mass = 0.1\nimpact_speed = 2", 1.6},
      {"law = \"linearized\"\nstiffness_coefficient = 5e10\ndamping_coefficient = 4.8e6\nimpact_mass = 0.1\nimpact_speed = 2", 1.6},
      {"law = \"linearized\"\nnormal_stiffness = 1e8\nnormal_damping = 1000", 1}};
  for (const auto& [law, exponent] : laws) {
    INFO(law);
    const std::string file = folder.write("soft.toml", text(law));
    const Case c = read_case(file), soft = read_case(file, softened(c, 10));
    const ContactLaw first = build(c).pair_laws[0].law, second = build(soft).pair_laws[0].law;
    for (const double speed : {0.3, 3.0}) {
      const HeadOnCollision a = collide_head_on(first, 0.01, 0.13, speed), b = collide_head_on(second, 0.01, 0.13, speed);
      CHECK(b.restitution == Approx(a.restitution).epsilon(1e-3));
      CHECK(b.duration == Approx(a.duration * std::pow(10, 1 / (exponent + 1))).epsilon(0.02));
    }
  }
}

TEST_CASE("two summaries are compared output by output") {
  const Folder folder("softening");
  const auto summary = [](double power, double shoulder, double rate, double overlap) {
    const auto entry = [](const char* key, double value, double half, const char* unit) {
      return "\"" + std::string(key) + "\": {\"value\": " + std::to_string(value) + ", \"unit\": \"" + unit + "\"" +
             (half > 0 ? ", \"ci95\": [" + std::to_string(value - half) + ", " + std::to_string(value + half) + "]" : "") + "}, ";
    };
    return "{" + entry("power", power, 3, "W") + entry("shoulder_angle", shoulder, 0.5, "deg") + entry("toe_angle", shoulder, 4, "deg") + entry("collision_rate", rate, 5, "1/s") +
           entry("shell_force", 1000, 5, "N") + entry("shell_force_horizontal", rate / 100, 20, "N") + entry("overlap_peak", overlap, 0, "1") + entry("fall_height_max", shoulder, 0, "m") +
           entry("critical_speed", 6, 0, "rad/s") + "\"time_step\": {\"value\": 1e-5}, \"wall_clock\": {\"value\": 2}}";
  };
  folder.write("a/summary.json", summary(500, 300, 1000, 0.02));
  folder.write("b/summary.json", summary(503, 301, 800, 0.06));
  SoftReport report;
  report.factor = 10;
  report.as_is.time_step = 1e-5, report.softer.time_step = 3e-5;
  report.as_is.steps = 3e5, report.softer.steps = 1e5;
  compare(report, (folder.path / "a").string(), (folder.path / "b").string());
  CHECK(row_of(report, "power").verdict == SoftVerdict::same);
  CHECK(row_of(report, "shoulder_angle").verdict == SoftVerdict::moves_little);
  CHECK(row_of(report, "toe_angle").verdict == SoftVerdict::unknown);
  CHECK(row_of(report, "toe_angle").longer > 4);
  CHECK(row_of(report, "collision_rate").verdict == SoftVerdict::moves);
  CHECK(row_of(report, "shell_force_horizontal").verdict == SoftVerdict::same);
  CHECK(row_of(report, "overlap_peak").verdict == SoftVerdict::by_nature);
  CHECK(row_of(report, "fall_height_max").verdict == SoftVerdict::no_interval);
  for (const SoftRow& row : report.rows) CHECK((row.key != "critical_speed" && row.key != "time_step" && row.key != "wall_clock"));
  REQUIRE(report.warnings.size() == 1);
  CHECK_THAT(report.warnings[0], Catch::Contains("6 % of the radius"));
  const std::string sentence = softening_sentence(report);
  CHECK_THAT(sentence, Catch::Contains("3 times as long") && Catch::Contains("does not move power, shell_force and shell_force_horizontal (by less than") && Catch::Contains("moves collision_rate (-20 ± 0.71 %)") && Catch::Contains("from 2 % to 6 %"));
}

TEST_CASE("check --soften shows that a bounce forgets the stiffness and that overlaps do not", "[cli]") {
  const Folder folder("softening");
  const std::string file = folder.write("drop.toml", drop), out = (folder.path / "out").string();
  REQUIRE(run_check("'" + file + "' --soften 10 --threads 1 --out '" + out + "'", folder.path / "log") == 0);
  const nlohmann::json report = nlohmann::json::parse(folder.read("out/soften.json"));
  CHECK(report["factor"] == 10);
  CHECK(report["outputs"]["speed_at_end_0"]["verdict"] == "does not move");
  CHECK(report["outputs"]["spin_at_end_0"]["verdict"] == "does not move");
  const nlohmann::json& overlap = report["outputs"]["overlap_peak"];
  CHECK(overlap["verdict"] == "moves by nature");
  // Hertz: the overlap goes as E^(−2/5).
  CHECK(overlap["softer"]["value"].get<double>() / overlap["as_is"]["value"].get<double>() == Approx(std::pow(10, 0.4)).epsilon(0.01));
  CHECK(report["softer"]["time_step"].get<double>() > 2.5 * report["as_is"]["time_step"].get<double>());
  CHECK_THAT(folder.read("out/soften.csv"), Catch::StartsWith("output,unit,as_is,") && Catch::Contains("speed_at_end_0,m/s,"));
  CHECK_THAT(folder.read("log"), Catch::Contains("does not move") && Catch::Contains("With contacts 10 times as soft the time step may be"));

  SECTION("finished runs are kept, and the factor is 10 unless told") {
    REQUIRE(run_check("'" + file + "' --out '" + out + "' --soften", folder.path / "log") == 0);
    CHECK_THAT(folder.read("log"), Catch::Contains("2 of 2 runs are finished already"));
  }
  SECTION("a step that the case gives grows with its limit") {
    REQUIRE(run_check("'" + file + "' --set time_step.value=1e-6 --soften 100 --out '" + out + "_given'", folder.path / "log") == 0);
    const nlohmann::json given = nlohmann::json::parse(folder.read("out_given/soften.json"));
    const auto share = [&](const char* run) { return given[run]["time_step"].get<double>() / given[run]["time_step_limit"].get<double>(); };
    CHECK(share("softer") == Approx(share("as_is")).epsilon(1e-6));
  }
  SECTION("bodies that still touch at the end are told") {
    REQUIRE(run_check("'" + file + "' --set duration=130us --soften 1000 --out '" + out + "_short'", folder.path / "log") == 0);
    CHECK_THAT(folder.read("log"), Catch::Contains("still touch") && Catch::Contains("--set duration="));
    CHECK(nlohmann::json::parse(folder.read("out_short/soften.json"))["outputs"]["speed_at_end_0"]["verdict"] == "cannot tell");
  }
  SECTION("a factor that softens nothing is refused") { CHECK(run_check("'" + file + "' --soften 0.5", folder.path / "log") == 2); }
}
