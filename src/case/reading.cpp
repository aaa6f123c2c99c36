#include "src/case/reading.hpp"
#include <fmt/format.h>
#include <algorithm>
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

std::string beside(const Values& v, const std::string& name) {
  const fs::path path(name);
  return fs::absolute(path.is_absolute() ? path : fs::path(v.file).parent_path() / path).lexically_normal().string();
}

}  // namespace quern
