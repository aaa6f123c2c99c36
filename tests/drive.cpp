// What a drive gives beside what the charge takes, and what wear leaves of lifters.
#include <catch2/catch.hpp>
#include <cmath>
#include "src/base/error.hpp"
#include "src/case/case.hpp"
#include "src/case/values.hpp"
#include "src/observe/torque_power.hpp"
#include "tests/folder.hpp"

using namespace quern;
using Catch::Contains;

namespace {

double value_of(const std::vector<Headline>& lines, const std::string& key) {
  for (const Headline& line : lines)
    if (line.key == key) return line.value;
  return NAN;
}

const char* mill = R"(
name = "driven"
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
speed = 5
bearing_torque = 0.2
gear_loss = 0.05
campaign_time = "1000 h"
lifters = {count = 8, height = 0.01, width = 0.01, wear = 0.001, wear_rate = 1e-9}
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

}  // namespace

TEST_CASE("the power of a drive is that of the charge, its bearings' torque times the speed, and the gears' part of both", "[mill]") {
  TorquePower seen;
  for (int k = 0; k < 200; ++k) {
    seen.time.push_back(0.01 * (k + 1));
    seen.torque.push_back(2 + 0.1 * std::sin(k));
    seen.power.push_back(5 * seen.torque.back());
    seen.wall_power.push_back(seen.power.back());
    seen.ledger_power.push_back(seen.power.back());
  }
  ObserverSettings settings;
  settings.start_time = 0;
  settings.mill = MillAxis{};
  settings.mill->speed = -5;
  const auto plain = seen.headlines(settings);
  settings.drive = {0.2, 0.05};
  const auto driven = seen.headlines(settings);
  CHECK(value_of(driven, "power_charge") == value_of(plain, "power"));
  CHECK(value_of(driven, "power") == Approx((value_of(plain, "power") + 0.2 * 5) * 1.05).epsilon(1e-12));
  CHECK(value_of(driven, "torque") == Approx((value_of(plain, "torque") + 0.2) * 1.05).epsilon(1e-12));
  CHECK(value_of(driven, "power_agreement") == value_of(plain, "power_agreement"));
}

TEST_CASE("lifters are as high as wear has left them", "[mill]") {
  const Folder folder("drive");
  const Values values = read_values(folder.write("case.toml", mill), {});
  const Case c = case_of(values);
  CHECK(c.observe.drive.bearing_torque == 0.2);
  CHECK(c.mill->lifters.height == Approx(0.01 - 0.001 - 1e-9 * 3.6e6).epsilon(1e-12));
  const Values worn = read_values(folder.write("case.toml", mill), {"mill.lifters.wear=0.0099"});
  CHECK_THROWS_WITH(case_of(worn), Contains("worn off") && Contains("mill.lifters.height"));
}

TEST_CASE("a complete case with bounds of a comparison can be read again", "[case]") {
  const Folder folder("drive_again");
  const Values values = read_values(folder.write("case.toml", mill), {});
  const std::string text = complete_case(values);
  const Values again = read_values(folder.write("again.toml", text), {});
  CHECK(again.given.count({"diagnose", "bounds", "pair.steel.steel.friction"}) == 1);
  CHECK(again.given.size() >= values.given.size());
}
