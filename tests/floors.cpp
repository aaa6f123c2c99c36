// A file includes only its own floor of the house or a lower one.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include "tests/places.hpp"

namespace {

const std::map<std::string, int> floors = {
    {"src/base", 0},  {"shapes", 1},     {"src/material", 1}, {"src/particle", 2}, {"src/contact", 2}, {"src/wall", 2},     {"bonds", 2},   {"mills", 3},
    {"src/field", 3}, {"src/engine", 4}, {"src/observe", 5},  {"src/grinding", 5}, {"src/case", 6},    {"src/output", 6}, {"src/calibrate", 7}, {"src/convert", 7}, {"src/diagnose", 7}, {"src/cli", 8}, {"src/python", 8}};

// The floor of a path from the root; −1: not in the house.
int floor_of(const std::string& path) {
  for (const auto& [folder, floor] : floors)
    if (path.rfind(folder + "/", 0) == 0) return floor;
  return -1;
}

}  // namespace

TEST_CASE("no file includes a floor above its own") {
  const std::filesystem::path root = quern::source_directory;
  const std::regex include("^\\s*#include \"([^\"]+)\"");
  std::size_t files = 0;
  for (const char* top : {"src", "bonds", "mills", "shapes"}) {
    if (!std::filesystem::exists(root / top)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
      const std::string ending = entry.path().extension();
      if (ending != ".hpp" && ending != ".cpp" && ending != ".inl") continue;
      const std::string file = std::filesystem::relative(entry.path(), root);
      ++files;
      REQUIRE(floor_of(file) >= 0);
      std::ifstream in(entry.path());
      std::string line;
      for (int number = 1; std::getline(in, line); ++number) {
        std::smatch found;
        if (!std::regex_search(line, found, include)) continue;
        INFO(file << ':' << number << " includes " << found[1]);
        CHECK(floor_of(found[1]) >= 0);
        CHECK(floor_of(found[1]) <= floor_of(file));
      }
    }
  }
  CHECK(files > 50);
}
