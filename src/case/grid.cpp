#include "src/case/grid.hpp"
#include <fmt/format.h>
#include <charconv>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/keys.hpp"

namespace quern {
namespace {

// Cut at a separator that stands outside brackets and quotes.
std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    quoted ^= c == '"';
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == separator && depth == 0 && !quoted) parts.emplace_back();
    else parts.back() += c;
  }
  return parts;
}

}  // namespace

SweptKey read_swept_key(const std::string& text) {
  const std::string where = "--set " + text;
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0) throw InputError(where + ": allowed is key=a,b,c or key=from:to:count, such as mill.speed_fraction=0.5:1.0:6.");
  SweptKey swept{text.substr(0, equals), {}};
  const Key* key = find_key(split_path(swept.key));
  if (!key) throw InputError(fmt::format("{}: {} is not a known key. The nearest known key is {}.", where, swept.key, nearest_key(split_path(swept.key))));
  const std::string values = text.substr(equals + 1);
  const std::vector<std::string> range = parts_of(values, ':');
  if (range.size() == 3 && (key->kind == KeyKind::number || key->kind == KeyKind::whole)) {
    int count = 0;
    const auto [end, status] = std::from_chars(range[2].data(), range[2].data() + range[2].size(), count);
    if (status != std::errc() || end != range[2].data() + range[2].size() || count < 2 || count > 10000)
      throw InputError(fmt::format("{}: found \"{}\" for the count of from:to:count; allowed is a whole number from 2 to 10000.", where, range[2]));
    try {
      const Units units;
      const double from = units.read(range[0], key->unit), to = units.read(range[1], key->unit);
      for (int k = 0; k < count; ++k) swept.values.push_back(fmt::format("{:.12g}", from + (to - from) * k / (count - 1)));
    } catch (const InputError& e) {
      throw InputError(fmt::format("{}: {}.", where, e.what()));
    }
    return swept;
  }
  swept.values = parts_of(values, ',');
  for (const std::string& value : swept.values)
    if (value.empty()) throw InputError(where + ": found an empty value; allowed is key=a,b,c or key=from:to:count.");
  return swept;
}

std::vector<std::vector<std::string>> grid_of(const std::vector<SweptKey>& keys) {
  std::vector<std::vector<std::string>> grid(1);
  for (const SweptKey& swept : keys) {
    std::vector<std::vector<std::string>> longer;
    for (const auto& run : grid) {
      for (const std::string& value : swept.values) {
        longer.push_back(run);
        longer.back().push_back(swept.key + "=" + value);
      }
    }
    grid = std::move(longer);
  }
  return grid;
}

}  // namespace quern
