#include "src/case/reference.hpp"
#include <fmt/format.h>
#include "src/base/units.hpp"
#include "src/case/keys.hpp"

namespace quern {
namespace {

std::string table_of(const Key& key) {
  Path path = split_path(key.path);
  path.pop_back();
  return join_path(path);
}

std::string default_of(const Key& key) {
  if (key.required()) return "required";
  return std::string_view(key.fallback).empty() ? "–" : key.fallback;
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '|' || c == '<') safe += '\\';
    safe += c;
  }
  return safe;
}

std::string code(const std::string& text) { return fmt::format("`{}`", text); }

}  // namespace

std::string key_as_text(const Key& key, const std::string& name, std::size_t column) {
  const std::string begin = name.size() > column ? fmt::format("  {}\n  {:{}}", name, "", column) : fmt::format("  {:{}}", name, column);
  return fmt::format("{} {}\n  {:{}}   {}; default {}{}\n", begin, key.meaning, "", column, allowed_by(key), default_of(key), key.source[0] ? fmt::format(" ({})", key.source) : "");
}

std::string keys_as_text(const std::string& prefix) {
  std::string text;
  std::string table = "-";
  for (const Key& key : all_keys()) {
    if (!std::string_view(key.path).starts_with(prefix)) continue;
    if (table_of(key) != table) {
      table = table_of(key);
      text += fmt::format("{}{}\n", text.empty() ? "" : "\n", table.empty() ? "At the top" : fmt::format("[{}]", table));
    }
    text += key_as_text(key, split_path(key.path).back());
  }
  return text;
}

std::string case_reference() {
  std::string text =
      "# Everything a case can set\n\n"
      "Made by `quern list keys --markdown` from the program's own table. A quantity is a number in the unit shown or a text with its unit\n"
      "(\"54.5 cm\", \"250 rpm\", \"206 GPa\", \"0.5 %\"). `<name>` stands for a name of yours: letters, digits, `_` and `-`. `[pair.<a>.<b>]` takes\n"
      "two materials in either order; `[pair.default]` serves the pairs without a table of their own; so with `[bond.<a>.<b>]` and two species.\n";
  std::string table = "-";
  for (const Key& key : all_keys()) {
    if (table_of(key) != table) {
      table = table_of(key);
      text += fmt::format("\n## {}\n\n| key | meaning | allowed | default | source |\n|---|---|---|---|---|\n", table.empty() ? "At the top" : fmt::format("`[{}]`", table));
    }
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", split_path(key.path).back(), escaped(key.meaning), escaped(allowed_by(key)),
                        default_of(key) == "required" || default_of(key) == "–" ? default_of(key) : code(default_of(key)), key.source);
  }
  return text;
}

}  // namespace quern
