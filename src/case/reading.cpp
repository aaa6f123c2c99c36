#include "src/case/reading.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include "src/base/error.hpp"

namespace quern {

namespace fs = std::filesystem;

void refuse(const std::string& where, const std::string& key, const std::string& what) {
  std::string sentence = fmt::format("{}: {}: {}", where, key, what);
  if (sentence.back() != '.' && sentence.back() != '?') sentence += '.';
  throw InputError(sentence);
}

std::string quoted_list(const std::vector<std::string>& words) {
  return words.empty() ? "none, as the case has none" : fmt::format("one of {}", fmt::join(words, ", "));
}

std::uint8_t index_of(const Values& v, const std::string& key, const std::vector<std::string>& names, const std::string& kind) {
  const std::string name = v.text(key);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    const std::string nearest = nearest_word(name, names);
    v.refuse(key, fmt::format("found \"{}\", which is no {} of this case; allowed is {}.{}", name, kind, quoted_list(names),
                              nearest.empty() ? "" : " Did you mean " + nearest + "?"));
  }
  return static_cast<std::uint8_t>(found - names.begin());
}

void require(const Values& v, const std::string& table, const std::string& leaf, const std::string& why) {
  if (!v.has(table + "." + leaf)) {
    const Key* key = find_key(split_path(table + "." + leaf));
    v.refuse(table + "." + leaf, fmt::format("this is missing, needed for {}; allowed is {}", why, allowed_by(*key)));
  }
}

Vec3 direction(const Values& v, const std::string& key) {
  const Vec3 d = v.vector(key);
  if (!(d.norm() > 1e-12)) v.refuse(key, "found a vector of no length; allowed is any direction");
  return d.normalized();
}

std::string beside(const Values& v, const std::string& key) {
  const fs::path named(v.text(key)), folder = fs::absolute(v.file).parent_path();
  const fs::path full = (named.is_absolute() ? named : folder / named).lexically_normal();
  if (std::getenv(outside_is_allowed) != nullptr || v.given.at(split_path(key)).where.starts_with("--set ")) return full.string();
  // Where links lead to counts.
  std::error_code problem;
  const fs::path real = fs::weakly_canonical(full, problem), home = fs::weakly_canonical(folder, problem);
  const auto parted = std::mismatch(home.begin(), home.end(), real.begin(), real.end());
  if (problem || parted.first != home.end())
    v.refuse(key, fmt::format("found \"{}\", which is outside the folder of the case; allowed are files in it and below, and with --allow-outside any", named.string()));
  return full.string();
}

}  // namespace quern
