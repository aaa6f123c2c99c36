#include "src/case/schema.hpp"
#include <fmt/format.h>
#include <cmath>
#include <nlohmann/json.hpp>
#include "src/case/keys.hpp"

namespace quern {
namespace {

using Json = nlohmann::ordered_json;

// A number in SI units, or a text with a unit: of the latter an editor cannot tell the range.
Json quantity(const Key& key, bool whole = false) {
  Json number = {{"type", whole ? "integer" : "number"}};
  if (std::isfinite(key.range.least)) number[key.range.above_least ? "exclusiveMinimum" : "minimum"] = key.range.least;
  if (std::isfinite(key.range.most)) number["maximum"] = key.range.most;
  if (whole) return number;
  return {{"anyOf", {number, {{"type", "string"}}}}};
}

Json list_of(const Json& items) { return {{"type", "array"}, {"items", items}}; }

Json vector_of(const Key& key) {
  Json vector = list_of(quantity(key));
  vector["minItems"] = vector["maxItems"] = 3;
  return vector;
}

Json type_of(const Key& key) {
  switch (key.kind) {
    case KeyKind::flag: return {{"type", "boolean"}};
    case KeyKind::word: return {{"enum", words_of(key)}};
    case KeyKind::text:
    case KeyKind::name:
    case KeyKind::file: return {{"type", "string"}};
    case KeyKind::names: return list_of({{"type", "string"}});
    case KeyKind::number: return quantity(key);
    case KeyKind::whole: return quantity(key, true);
    case KeyKind::numbers: return list_of(quantity(key));
    case KeyKind::wholes: return list_of(quantity(key, true));
    case KeyKind::vector: return vector_of(key);
    case KeyKind::vectors: return list_of(vector_of(key));
  }
  return {};
}

Json entry_of(const Key& key) {
  Json entry = type_of(key);
  entry["description"] = fmt::format("{}\n\nAllowed: {}. Default: {}.{}", key.meaning, allowed_by(key), key.required() ? "none, it is required" : key.fallback[0] ? key.fallback : "–",
                                     key.source[0] ? fmt::format(" Source: {}.", key.source) : "");
  return entry;
}

// The table that holds one more segment of a path, made where it is not there. Names of the user's are what is no known word.
Json& deeper(Json& table, const std::string& segment) {
  Json& home = segment.front() == '<' ? table["additionalProperties"] : table["properties"][segment];
  if (!home.is_object()) home = {{"type", "object"}, {"additionalProperties", false}};
  return home;
}

void place(Json& table, const Path& path, const Key& key) {
  Json* home = &table;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) home = &deeper(*home, path[k]);
  if (path.back() == "<key>") {  // names of keys: quoted, or as they are, which TOML reads as tables
    (*home)["additionalProperties"] = {{"anyOf", {entry_of(key), {{"type", "object"}}}}};
    return;
  }
  (*home)["properties"][path.back()] = entry_of(key);
  if (key.required()) (*home)["required"].push_back(path.back());
}

}  // namespace

std::string case_schema() {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "A case of quern"}, {"description", "Made by `quern list keys --schema` from the program's own table"},
                 {"type", "object"},  {"additionalProperties", false}};
  for (const Key& key : all_keys()) {
    const Path path = split_path(key.path);
    place(schema, path, key);
    // [pair.default] and [bond.default] have one name where others have two.
    if ((path[0] == "pair" || path[0] == "bond") && path.size() == 4) place(schema, {path[0], "default", path[3]}, key);
  }
  return schema.dump(1) + "\n";
}

}  // namespace quern
