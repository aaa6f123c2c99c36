// The granule of cases/agglomerate_speeds: no damage below its threshold, nearly all bonds broken on its plateau, and the same bits every time.
#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include "tests/folder.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

// Returns the damage ratio.
double impact(const Folder& folder, const std::string& name, double speed, int seed, int threads) {
  const std::string out = (folder.path / name).string();
  REQUIRE(run_quern(fmt::format("run '{}/cases/agglomerate_speeds/case.toml' --set insert.granule.speed={} --set seed={} --threads {} --out '{}'", source_directory, speed, seed, threads, out), folder.path / "log") == 0);
  return nlohmann::json::parse(folder.read(name + "/summary.json"))["damage_ratio"]["value"].get<double>();
}

}  // namespace

TEST_CASE("a granule of equal bonds is whole below its threshold and broken to grains on its plateau", "[cli]") {
  const Folder folder("impacts");
  for (const int seed : {1, 2}) {
    CHECK(impact(folder, "slow", 0.5, seed, 1) == 0);
    CHECK(impact(folder, "fast", 40, seed, 1) > 0.98);
  }
}

TEST_CASE("an impact is repeated to the bit, by any number of threads", "[cli]") {
  const Folder folder("repeated");
  const double damage = impact(folder, "first", 8, 3, 1);
  CHECK((damage > 0.1 && damage < 0.9));
  CHECK(impact(folder, "again", 8, 3, 1) == damage);
  CHECK(impact(folder, "two", 8, 3, 2) == damage);
  for (const char* file : {"damage.csv", "failures.csv", "fragments.csv", "energy.csv"}) {
    INFO(file);
    const std::string written = folder.read(std::string("first/") + file);
    CHECK(!written.empty());
    CHECK(folder.read(std::string("again/") + file) == written);
    CHECK(folder.read(std::string("two/") + file) == written);
  }
}
