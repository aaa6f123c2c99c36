// The grid of runs of a sweep.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct SweptKey {
  std::string key;
  std::vector<std::string> values;  // as overrides take them
};

// "key=a,b,c" or "key=from:to:count" (evenly spread, both ends; quantities may carry units, "10 rpm:50 rpm:5"). A list in brackets
// is one value. Throws InputError.
SweptKey read_swept_key(const std::string& text);

// Overrides of every run: all combinations, the last key varying fastest.
std::vector<std::vector<std::string>> grid_of(const std::vector<SweptKey>& keys);

}  // namespace quern
