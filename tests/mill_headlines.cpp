#include "src/case/mill_headlines.hpp"
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include "tests/places.hpp"

using namespace quern;

namespace {

const std::string small_mill = std::string(quern::source_directory) + "/cases/mill_545mm/case.toml";

std::map<std::string, double> headlines_of(const Case& c) {
  std::map<std::string, double> values;
  for (const Headline& line : mill_headlines(c, build_case(c))) values[line.key] = line.value;
  return values;
}

}  // namespace

TEST_CASE("The classical models of power are told the charge as it is") {
  const std::map<std::string, double> lines = headlines_of(read_case(small_mill, {"mill.speed_fraction=0.75"}));
  CHECK(lines.at("speed_fraction") == Approx(0.75));
  CHECK(lines.at("filling") == Approx(0.423).epsilon(0.001));
  // By hand: 140 kg, whose segment of 42.3 % has its centre of mass 0.1337 m below the axis, leaning at 40 degrees, at 4.741 rad/s.
  CHECK(lines.at("power_hogg_fuerstenau") == Approx(140 * 9.81 * 0.1337 * 0.642788 * 4.741).epsilon(0.01));
  CHECK(lines.at("power_morrell") > 0);
  CHECK(lines.at("power_bond") > 0);
}

TEST_CASE("Power models keep silent where they do not reach") {
  const std::map<std::string, double> lines = headlines_of(read_case(small_mill, {"mill.speed_fraction=1.2"}));
  CHECK(lines.count("power_hogg_fuerstenau") == 1);
  CHECK(lines.count("power_morrell") == 0);
  CHECK(lines.count("power_bond") == 0);
}

TEST_CASE("A mill's length may be told by its diameter") {
  const Case c = read_case(std::string(quern::source_directory) + "/cases/mill_127_254_508mm/case.toml", {"mill.diameter=127 mm"});
  CHECK(c.mill->length == Approx(1.15 * 0.127));
}
