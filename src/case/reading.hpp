// What the readers of a case's parts share.
#pragma once
#include <cstdint>
#include <string>
#include <vector>
#include "src/case/values.hpp"

namespace quern {

// The variable of the environment that --allow-outside sets, so that runs which a command starts know it too.
inline constexpr const char* outside_is_allowed = "QUERN_ALLOW_OUTSIDE";

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& list) {
  std::vector<std::string> names;
  for (const Named& one : list) names.push_back(one.name);
  return names;
}

// Throws InputError: where a key stands, its name, and what is wrong with it.
[[noreturn]] void refuse(const std::string& where, const std::string& key, const std::string& what);

// "one of a, b, c".
std::string quoted_list(const std::vector<std::string>& words);

// The index in `names` of the name that a key holds; refuses one that is not there, `kind` being what it should name.
std::uint8_t index_of(const Values& v, const std::string& key, const std::vector<std::string>& names, const std::string& kind);

// Refuses a table without that key, which is needed for `why`.
void require(const Values& v, const std::string& table, const std::string& leaf, const std::string& why);

// The unit vector along the one that a key holds; refuses one of no length.
Vec3 direction(const Values& v, const std::string& key);

// The full name of the file that a key names, relative to the folder of the case. Refuses one that a case names outside its folder, unless
// the person who runs it has asked for that: in the command itself (--set) or by --allow-outside.
std::string beside(const Values& v, const std::string& key);

}  // namespace quern
