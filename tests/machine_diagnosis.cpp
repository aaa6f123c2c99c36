// Verdicts on curves of a mill whose simulation is replaced by formulas with scatter: what is missing is named, what is not missing is not.
#include "src/diagnose/machine/machine_diagnosis.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include <fmt/format.h>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "tests/folder.hpp"

using namespace quern;
using Catch::Contains;

namespace {

const char* mill = R"(
duration = 1
[material.steel]
density = 7800
young = 2e7
[pair.steel.steel]
restitution = 0.6
friction = 0.5
[mill]
diameter = 0.25
length = 0.064
speed_fraction = 0.7
[species.ball]
material = "steel"
diameter = 0.016
[insert.charge]
species = "ball"
count = 20
[diagnose]
free = ["pair.steel.steel.friction"]
[diagnose.bounds]
"pair.steel.steel.friction" = [0.1, 0.9]
)";

// How a mill might answer: friction, rolling resistance and adhesion lift the charge, each in its own way along the speed.
struct Answer {
  double power, shoulder, toe;
};
Answer answer_of(double speed, double friction, double rolling, double adhesion) {
  const double f = friction - 0.5;
  return {20 * speed * (1 - 0.35 * speed * speed) * (1 + 0.4 * f) + 6 * rolling * (0.7 - speed) * 10 + 0.02 * adhesion * speed * speed * speed,
          280 + 45 * speed + 20 * f + 90 * rolling * speed - 0.3 * adhesion * (1 - speed), 150 - 10 * speed * speed - 5 * f + 12 * rolling - 0.2 * adhesion};
}
constexpr double power_scatter = 0.05, angle_scatter = 0.4;

CaseRunner formulas(int* runs = nullptr) {
  return [runs](const std::vector<WantedRun>& wanted) {
    std::vector<Outcome> all;
    for (const WantedRun& one : wanted) {
      if (runs != nullptr) ++*runs;
      const auto number = [&](const char* key) { return one.values.has(key) ? one.values.number(key) : 0.0; };
      const Answer a = answer_of(number("mill.speed_fraction"), number("pair.steel.steel.friction"), number("pair.steel.steel.rolling_friction"), number("pair.steel.steel.surface_energy"));
      std::uint64_t hash = 1469598103934665603u;  // scatter that belongs to the case
      for (const char c : complete_case(one.values)) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
      RandomStream random(hash);
      Outcome outcome;
      outcome.sound = true;
      outcome.numbers["power"] = {a.power + power_scatter * random.normal(), power_scatter};
      outcome.numbers["shoulder_angle"] = {a.shoulder + angle_scatter * random.normal(), angle_scatter};
      outcome.numbers["toe_angle"] = {a.toe + angle_scatter * random.normal(), angle_scatter};
      all.push_back(outcome);
    }
    return all;
  };
}

// Eight speeds; `more`: what acts besides, on power [W], shoulder and toe [deg].
template <class More>
std::string curve(std::uint64_t seed, double friction, double rolling, More more) {
  RandomStream random(seed);
  std::string text = "speed_fraction,power [W],power_sd [W],shoulder [deg],shoulder_sd [deg],toe [deg],toe_sd [deg]\n";
  for (int k = 0; k < 8; ++k) {
    const double speed = 0.45 + 0.07 * k;
    Answer a = answer_of(speed, friction, rolling, 0);
    more(speed, a);
    text += fmt::format("{:.4f},{:.6f},{},{:.6f},{},{:.6f},{}\n", speed, a.power + power_scatter * random.normal(), power_scatter, a.shoulder + angle_scatter * random.normal(), angle_scatter,
                        a.toe + angle_scatter * random.normal(), angle_scatter);
  }
  return text;
}
std::string curve(std::uint64_t seed, double friction, double rolling) {
  return curve(seed, friction, rolling, [](double, Answer&) {});
}

MachineDiagnosis diagnosis_of(const std::string& recorded, int* runs = nullptr) {
  const Folder folder("machine");
  const Values values = read_values(folder.write("case.toml", mill), {});
  const MachineRecording recording = read_machine_recordings({folder.write("r.csv", recorded)});
  const MachineExperiment experiment(values, recording);
  return diagnose_machine(experiment, formulas(runs), {});
}

const Estimate* find(const MachineDiagnosis& d, const std::string& key) {
  for (const Estimate& e : d.parameters)
    if (e.key == key) return &e;
  return nullptr;
}

}  // namespace

TEST_CASE("a mill curve that the case explains misses nothing", "[diagnose][machine]") {
  int clean = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) clean += diagnosis_of(curve(seed, 0.5, 0)).verdict == Verdict::nothing_missing;
  CHECK(clean == 5);  // at a level of 1 %, five of five in 95 of 100
}

TEST_CASE("friction that was off is calibrated and not called physics", "[diagnose][machine]") {
  const MachineDiagnosis d = diagnosis_of(curve(2, 0.35, 0));
  CHECK(d.verdict == Verdict::parameters_only);
  const Estimate* friction = find(d, "pair.steel.steel.friction");
  REQUIRE(friction != nullptr);
  CHECK(friction->value == Approx(0.35).margin(3.5 * friction->deviation));
  CHECK(friction->deviation < 0.03);
}

TEST_CASE("rolling resistance that a mill's case lacks is named, with its coefficient", "[diagnose][machine]") {
  const MachineDiagnosis d = diagnosis_of(curve(3, 0.42, 0.15));
  CHECK(d.verdict == Verdict::omitted_physics);
  CHECK(d.effects == std::vector<std::string>{"rolling_resistance"});
  const Estimate* rolling = find(d, "pair.steel.steel.rolling_friction");
  REQUIRE(rolling != nullptr);
  CHECK(rolling->value == Approx(0.15).margin(3.5 * rolling->deviation));
  CHECK(rolling->deviation < 0.02);
  REQUIRE(d.sealed.has_value());
  CHECK(d.sealed->after < 0.5 * d.sealed->before);
  CHECK(d.excess_removed > 0.7);
}

TEST_CASE("a bearing moves the power and no angle, and is told from gears by the speed", "[diagnose][machine]") {
  constexpr double torque = 0.1, critical = 9.157;  // √(2g/(D − d)) [rad/s]
  const MachineDiagnosis d = diagnosis_of(curve(4, 0.5, 0, [&](double speed, Answer& a) { a.power += torque * speed * critical; }));
  CHECK(d.verdict == Verdict::omitted_physics);
  CHECK(d.effects == std::vector<std::string>{"bearing_torque"});
  const Estimate* found = find(d, "mill.bearing_torque");
  REQUIRE(found != nullptr);
  CHECK(found->value == Approx(torque).epsilon(0.1));
  CHECK(d.where.channel == "power");
  CHECK(d.where.sign == "above");
}

TEST_CASE("what no effect does is unexplained, and where it is, is told", "[diagnose][machine]") {
  const MachineDiagnosis d = diagnosis_of(curve(5, 0.5, 0, [](double speed, Answer& a) {
    if (speed > 0.7) a.toe += 6;
    if (speed < 0.6) a.shoulder -= 8;
  }));
  CHECK(d.verdict == Verdict::unexplained);
  CHECK((d.where.channel == "shoulder" || d.where.channel == "toe"));
}

TEST_CASE("the same mill curve and seed give the same verdict to the bit", "[diagnose][machine]") {
  const MachineDiagnosis a = diagnosis_of(curve(3, 0.42, 0.15)), b = diagnosis_of(curve(3, 0.42, 0.15));
  CHECK(a.verdict == b.verdict);
  CHECK(a.confidence == b.confidence);
  CHECK(a.best.z == b.best.z);
  CHECK(a.adequacy_p == b.adequacy_p);
}

TEST_CASE("numbers too few to tell noise from physics are said to be", "[diagnose][machine]") {
  const MachineDiagnosis d = diagnosis_of("speed_fraction,power [W]\n0.5,9\n0.6,10\n");
  CHECK(d.verdict == Verdict::insufficient_data);
}

TEST_CASE("repeats of a mill curve become means whose noise is their scatter", "[diagnose][machine]") {
  const Folder folder("machine_repeats");
  const std::string file = folder.write("r.csv", "run,speed [rpm],power [W]\na,60,10\nb,60,12\na,30,5\nb,30,5\n");
  const MachineRecording recording = read_machine_recordings({file});
  REQUIRE(recording.rows.size() == 2);
  CHECK(recording.rows[1].conditions.at("speed") == Approx(2 * M_PI));
  const MachineExperiment experiment(read_values(folder.write("case.toml", mill), {}), recording);
  const auto& sites = experiment.channels().front().sites;
  REQUIRE(sites.size() == 2);
  CHECK(sites[1].value == Approx(11));
  // Its own squares, 2 with one degree of freedom, and the channel's variance, 2/2, that counts for three; two repeats.
  CHECK(sites[1].deviation == Approx(std::sqrt((2 + 3 * 1.0) / (1 + 3) / 2)));
}

TEST_CASE("recordings of machines that cannot be read say where and why", "[diagnose][machine]") {
  const Folder folder("machine_bad");
  const auto refusal = [&](const std::string& text) {
    try {
      read_machine_recordings({folder.write("r.csv", text)});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  CHECK_THAT(refusal("sped [rpm],power [W]\n1,2\n"), Contains("r.csv:1: found the column sped") && Contains("did you mean speed?"));
  CHECK_THAT(refusal("speed [rpm],power [m]\n1,2\n"), Contains("r.csv:1"));
  CHECK_THAT(refusal("speed [rpm],rate [1/s]\n1,2\n"), Contains("without energy"));
  CHECK_THAT(refusal("speed [rpm],power [W],power_sd [W]\n1,2,0\n"), Contains("r.csv:2") && Contains("standard deviation above 0"));
  CHECK_THAT(refusal("speed [rpm],power [W]\n,2\n"), Contains("r.csv:2") && Contains("condition"));
  CHECK_THAT(refusal("speed [rpm],power [W],held_out\n1,2,0\n1,2,1\n"), Contains("r.csv:3") && Contains("held out whole"));
  const Values values = read_values(folder.write("case.toml", mill), {"mill.speed_fraction=0.7"});
  const MachineRecording two = read_machine_recordings({folder.write("s.csv", "mill.lifters.height [m],power [W]\n0.5,2\n")});
  CHECK_THROWS_AS(MachineExperiment(values, two), InputError);
}
