// Verdicts on recordings made here, from closed solutions: what is missing is named, what is not missing is not, and the amended case follows the recording.
#include "src/diagnose/diagnosis.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <regex>
#include "src/base/random.hpp"
#include "src/case/case.hpp"
#include "src/case/csv.hpp"
#include "tests/bounces.hpp"
#include "tests/folder.hpp"

using namespace quern;
using Catch::Contains;

namespace {

constexpr double g = 9.81, air = 1.2, diameter = 0.1, noise = 3e-3;
constexpr double masses[] = {0.05, 0.05, 0.08, 0.08, 0.12, 0.12};

const char* falling = R"(
duration = 1.5
gravity = [0, 0, -9.81]
time_step.value = 1e-3
[material.foam]
density = 100
young = 1e7
[species.ball]
material = "foam"
diameter = 0.1
[insert.one]
species = "ball"
positions = [[0, 0, 0]]
)";

// From rest under quadratic drag: z = z₀ − v²/g ln cosh(g t/v), v² = 2 m g/(C ρ A).
double height(double drag, int run, double t) {
  const double start = 2 + 0.1 * run;
  if (drag == 0) return start - 0.5 * g * t * t;
  const double terminal = std::sqrt(2 * masses[run] * g / (drag * air * std::numbers::pi / 4 * diameter * diameter));
  return start - terminal * terminal / g * std::log(std::cosh(g * t / terminal));
}

std::string falls(double drag, std::uint64_t seed, int runs = 6, int samples = 40) {
  std::string text = "run,t [s],z [m],mass [kg]\n";
  RandomStream random(seed);
  for (int run = 0; run < runs; ++run)
    for (int k = 0; k < samples; ++k) {
      const double t = 1.5 * k / (samples - 1);
      text += fmt::format("r{},{:.9g},{:.9g},{}\n", run, t, height(drag, run, t) + noise * random.normal(), masses[run]);
    }
  return text;
}

Diagnosis diagnosis_of(const std::string& text, const std::string& recorded, const std::vector<std::string>& overrides = {}) {
  const Folder folder("diagnosis");
  const Values values = read_values(folder.write("case.toml", text), overrides);
  const Recording recording = read_recordings({folder.write("r.csv", recorded)});
  const Experiment experiment(values, recording);
  ThreadTeam team(1);
  return diagnose(experiment, team, {});
}

}  // namespace

TEST_CASE("a ball that falls through air is said to miss drag, with its coefficient in the interval", "[diagnose][verdict]") {
  const Diagnosis d = diagnosis_of(falling, falls(0.47, 1));
  CHECK(d.verdict == Verdict::omitted_physics);
  CHECK(d.effects == std::vector<std::string>{"air_drag"});
  REQUIRE_FALSE(d.parameters.empty());
  const Estimate& e = d.parameters.front();
  CHECK(e.key == "medium.drag_coefficient");
  CHECK(e.of_effect);
  CHECK(e.interval()[0] < 0.47);
  CHECK(e.interval()[1] > 0.47);
  CHECK(e.deviation < 0.02);
  CHECK(d.adequacy_p < 0.01);
  CHECK(d.remaining_p > 0.01);
  REQUIRE(d.sealed);
  CHECK(d.sealed->before > 3);
  CHECK(d.sealed->after < 1.5);
  CHECK(d.where.channel == "z");
}

TEST_CASE("nothing is missing where the case has the drag, and where there is none", "[diagnose][verdict]") {
  const Diagnosis with = diagnosis_of(falling, falls(0.47, 2), {"medium.drag_coefficient=0.47"});
  CHECK(with.verdict == Verdict::nothing_missing);
  CHECK(with.effects.empty());
  CHECK(with.adequacy_p > 0.01);
  const Diagnosis without = diagnosis_of(falling, falls(0, 3));
  CHECK(without.verdict == Verdict::nothing_missing);
  CHECK_FALSE(without.detectable.empty());
}

TEST_CASE("a drag coefficient that was merely off is a parameter, not physics", "[diagnose][verdict]") {
  const Diagnosis d = diagnosis_of(falling, falls(0.47, 4), {"medium.drag_coefficient=0.6", "diagnose.free=[\"medium.drag_coefficient\"]"});
  CHECK(d.verdict == Verdict::parameters_only);
  REQUIRE(d.parameters.size() == 1);
  CHECK(d.parameters[0].value == Approx(0.47).margin(4 * d.parameters[0].deviation));
  CHECK(*d.parameters[0].nominal == 0.6);
}

TEST_CASE("a restitution that was merely off is a parameter, not physics", "[diagnose][verdict]") {
  // Each rebound e times as fast: z between bounces is a parabola. A touch lasts 0.5 ms, in which the ball would fly 1 mm: a quarter of the noise.
  const std::string bouncing = R"(
duration = 1
gravity = [0, 0, -9.81]
[material.steel]
density = 7800
young = "1 GPa"
[pair.default]
restitution = 0.9
[species.ball]
material = "steel"
diameter = 0.02
[wall.plate]
type = "plane"
material = "steel"
[insert.one]
species = "ball"
positions = [[0, 0, 0.3]]
[diagnose]
free = ["pair.default.restitution"]
)";
  std::string text = "run,t [s],z [m],drop_height [m]\n";
  RandomStream random(5);
  for (int run = 0; run < 5; ++run) {
    const double drop = 0.2 + 0.05 * run;
    for (int k = 0; k < 40; ++k) {
      const double t = 0.02 * k;
      text += fmt::format("{},{:.9g},{:.9g},{}\n", run, t, 0.01 + bounce_height(drop, 0.8, t) + 4e-3 * random.normal(), drop);
    }
  }
  const Diagnosis d = diagnosis_of(bouncing, text);
  CHECK(d.verdict == Verdict::parameters_only);
  CHECK(d.effects.empty());
  REQUIRE(d.parameters.size() == 1);
  CHECK(d.parameters[0].value == Approx(0.8).margin(0.01));
  CHECK(*d.parameters[0].nominal == 0.9);
}

TEST_CASE("a force that swings to and fro is missing, and no known effect", "[diagnose][verdict]") {
  // z'' = a sin ω t, from rest: z = a/ω² (ω t − sin ω t); the part in proportion to t is a start that nobody knows. Twice the noise in 240 samples.
  const double omega = 2 * std::numbers::pi * 6 / 1.5, swing = 2 * noise;
  std::string text = "run,t [s],z [m]\n";
  RandomStream random(8);
  for (int run = 0; run < 6; ++run)
    for (int k = 0; k < 40; ++k) {
      const double t = 1.5 * k / 39;
      text += fmt::format("r{},{:.9g},{:.9g}\n", run, t, height(0, run, t) - swing * std::sin(omega * t) + noise * random.normal());
    }
  const Diagnosis d = diagnosis_of(falling, text);
  CHECK(d.verdict == Verdict::unexplained);
  CHECK(d.adequacy_p < 1e-6);
}

TEST_CASE("a spin that dies out in proportion to itself tells of a torque by the spin, not of a friction", "[diagnose][verdict]") {
  // Two runs at each spin: a table says nothing beyond its ends.
  const std::string spinning = R"(
duration = 1
gravity = [0, 0, -9.81]
[material.steel]
density = 7800
[pair.default]
law = "linear"
normal_stiffness = 1e5
restitution = 0.5
friction = 0.3
[species.ball]
material = "steel"
diameter = 0.02
[wall.plate]
type = "plane"
material = "steel"
[insert.one]
species = "ball"
positions = [[0, 0, 0.01]]
spin = [0, 0, 50]
)";
  std::string text = "run,t [s],wz [rad/s]\n";
  RandomStream random(9);
  for (int run = 0; run < 4; ++run)
    for (int k = 0; k < 25; ++k) {
      const double t = 0.04 * k;
      text += fmt::format("r{},{:.9g},{:.9g}\n", run, t, (run % 2 == 0 ? 45 : 60) * std::exp(-t / 0.8) + 0.1 * random.normal());
    }
  const Diagnosis d = diagnosis_of(spinning, text);
  CHECK(d.verdict == Verdict::unexplained);
  CHECK_THAT(d.form, Contains("torque"));
  REQUIRE(d.sealed);
  CHECK(d.sealed->after < 1.5);
  CHECK(d.sealed->before > 20);
}

TEST_CASE("a handful of samples is too few to tell", "[diagnose][verdict]") {
  const Diagnosis d = diagnosis_of(falling, falls(0.47, 6, 1, 6));
  CHECK(d.verdict == Verdict::insufficient_data);
  CHECK(d.effects.empty());
  CHECK_FALSE(d.remarks.empty());
}

TEST_CASE("the same seed gives the same diagnosis for any number of threads, and its amended case follows the recording", "[diagnose][verdict]") {
  const Folder folder("diagnosis");
  const std::string file = folder.write("case.toml", falling), recording = folder.write("r.csv", falls(0.47, 7));
  const auto run = [&](int threads, const std::string& out) {
    return run_quern(fmt::format("diagnose '{}' --recording '{}' --out '{}' --seed 3 --no-pictures --threads {}", file, recording, (folder.path / out).string(), threads), folder.path / "log");
  };
  REQUIRE(run(1, "one") == 0);
  REQUIRE(run(2, "two") == 0);
  const std::string told = folder.read("one/diagnosis.json");
  CHECK_THAT(told, Contains("\"air_drag\""));
  for (const char* written : {"diagnosis.json", "amended.toml", "residuals.csv", "fits.csv"}) {
    INFO(written);
    CHECK(folder.read(std::string("one/") + written) == folder.read(std::string("two/") + written));
  }

  const std::string amended = folder.read("one/amended.toml");
  std::smatch found;
  REQUIRE(std::regex_search(amended, found, std::regex("as run r(\\d) of the recording")));
  const int of = std::stoi(found[1]);
  const Case c = read_case((folder.path / "one/amended.toml").string());
  CHECK(c.observe.signal);
  CHECK(c.fields.size() == 1);
  REQUIRE(run_quern(fmt::format("run '{0}/one/amended.toml' --out '{0}/run' --set output.pictures=false --quiet", folder.path.string()), folder.path / "log") == 0);
  const NumberTable signal = read_numbers((folder.path / "run/signal.csv").string());
  const std::vector<double>&t = *signal.find("t"), &z = *signal.find("z");
  REQUIRE(t.size() >= 1000);
  CHECK(t.back() > 1.49);
  // Within what forty samples leave open of its start, its speed and its drag.
  for (std::size_t k = 0; k < t.size(); k += 20) CHECK(z[k] == Approx(height(0.47, of, t[k])).margin(1.5 * noise));
  CHECK(std::abs(height(0, of, 1.5) - height(0.47, of, 1.5)) > 30 * noise);
}
