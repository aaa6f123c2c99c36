// src/case — TOML in, a ready simulation out; all checking of input. No stepping.
//
// The one table of everything that a case can set. Reading, checking, `quern list keys`, the echo of the complete case and
// docs/case-reference.md are made from it; nothing is described twice.
#pragma once
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace quern {

enum class KeyKind { number, whole, flag, word, text, name, names, file, numbers, wholes, vector, vectors };

inline constexpr double no_bound = std::numeric_limits<double>::infinity();

struct Range {
  double least = -no_bound, most = no_bound;
  bool above_least = false;  // least itself is not allowed
};

struct Key {
  const char* path;      // "material.<name>.young": <…> stands for a name of the user's
  KeyKind kind;
  const char* unit;      // SI, as UDUNITS reads it; "1" pure number; "" where none applies
  const char* fallback;  // as it would stand in a case; "required"; "" where absence has the meaning told
  Range range;           // of the value, or of each of its components
  const char* words;     // allowed words, separated by blanks
  const char* meaning;
  const char* source;    // paper or "" where none is needed

  bool required() const { return std::string_view(fallback) == "required"; }
};

std::span<const Key> all_keys();

using Path = std::vector<std::string>;
Path split_path(std::string_view dotted);
std::string join_path(const Path& path);

// The key that a path in a case means, or null. A literal segment goes before a <…>.
const Key* find_key(const Path& path);
// Whether some key begins with this path.
bool is_table(const Path& path);
// The known key nearest to a path (edit distance, segment by segment), with the user's own names in it.
std::string nearest_key(const Path& path);
std::string nearest_table(const Path& path);
// The nearest of some words; empty if none is anywhere near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

std::vector<std::string> words_of(const Key& key);
// "more than 0", "from 0 to 1", a list of words … in plain words, with the unit.
std::string allowed_by(const Key& key);

}  // namespace quern
