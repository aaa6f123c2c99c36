// Nothing is undocumented: the pages are held against the program's own tables.
#include <catch2/catch.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include "src/case/keys.hpp"
#include "src/case/reference.hpp"
#include "src/case/schema.hpp"
#include "src/diagnose/catalogue.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

std::string page(const std::string& name) {
  std::ifstream in(std::filesystem::path(source_directory) / name);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string said_by(const std::string& words) {
  const std::string command = std::string(program) + " " + words;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  std::array<char, 4096> piece;
  for (std::size_t got; (got = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) text.append(piece.data(), got);
  CHECK(pclose(pipe) == 0);
  return text;
}

}  // namespace

TEST_CASE("the pages made from the program's tables are those that it makes", "[documents]") {
  CHECK(page("docs/case-reference.md") == case_reference());
  CHECK(page("docs/case.schema.json") == case_schema());
  CHECK(page("docs/commands.md") == said_by("manual markdown"));
}

TEST_CASE("every key has a meaning, and every effect its place in the pages", "[documents]") {
  for (const Key& key : all_keys()) {
    INFO(key.path);
    CHECK(std::string(key.meaning).size() > 3);
  }
  const std::string pages = page("docs/effects.md") + page("docs/diagnose.md") + page("docs/diagnose-machines.md");
  for (const EffectEntry& effect : all_effects()) {
    INFO(effect.name);
    CHECK(pages.find(effect.name) != pages.npos);
  }
}

TEST_CASE("the README names every command, and nothing that is none", "[documents]") {
  const std::string readme = page("README.md"), commands = page("docs/commands.md");
  std::set<std::string> known;
  const std::regex heading("\n## quern ([a-z]+)");
  for (std::sregex_iterator k(commands.begin(), commands.end(), heading), end; k != end; ++k) known.insert((*k)[1]);
  CHECK(known.size() >= 12);
  for (const std::string& command : known) {
    INFO(command);
    CHECK(readme.find("quern " + command) != readme.npos);
  }
  // `quern WORD` in code.
  const std::regex named("`quern ([a-z]+)");
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(source_directory) / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = page("docs/" + entry.path().filename().string());
    for (std::sregex_iterator k(text.begin(), text.end(), named), end; k != end; ++k) {
      INFO(entry.path().filename() << ": quern " << (*k)[1]);
      CHECK(known.count((*k)[1]) == 1);
    }
  }
}

TEST_CASE("links between pages lead somewhere", "[documents]") {
  const std::regex link("\\]\\(([^)#: ]+)(#[^)]*)?\\)");
  std::vector<std::string> pages = {"README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(source_directory) / "docs"))
    if (entry.path().extension() == ".md") pages.push_back("docs/" + entry.path().filename().string());
  for (const std::string& name : pages) {
    const std::string text = page(name);
    for (std::sregex_iterator k(text.begin(), text.end(), link), end; k != end; ++k) {
      const std::filesystem::path to = (std::filesystem::path(source_directory) / name).parent_path() / (*k)[1].str();
      INFO(name << " → " << (*k)[1]);
      CHECK(std::filesystem::exists(to));
    }
  }
}

TEST_CASE("the schema for editors knows the keys, their units as texts, and refuses others", "[documents]") {
  const auto schema = nlohmann::json::parse(case_schema());
  const auto& pairs = schema["properties"]["pair"];
  CHECK(pairs["properties"]["default"]["properties"]["friction"]["anyOf"][0]["maximum"] == 100);
  CHECK(pairs["additionalProperties"]["additionalProperties"]["properties"]["law"]["enum"].size() == 5);
  CHECK(schema["additionalProperties"] == false);
  CHECK(schema["properties"]["mill"]["additionalProperties"] == false);
  CHECK(schema["required"][0] == "duration");
}
