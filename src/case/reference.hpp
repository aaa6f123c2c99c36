// The table of keys as text for people: `quern list keys` and docs/case-reference.md.
#pragma once
#include <string>
#include "src/case/keys.hpp"

namespace quern {

// What a key means, what is allowed, its default and source, in two lines beside its name, or below a name that is wider than the column.
std::string key_as_text(const Key& key, const std::string& name, std::size_t column = 24);

// One line per key that begins with `prefix` ("" for all), grouped by table.
std::string keys_as_text(const std::string& prefix = "");

// The page docs/case-reference.md, Markdown.
std::string case_reference();

}  // namespace quern
