// The checked values of a case by key, before they are given meaning.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>
#include "src/base/vec.hpp"
#include "src/case/keys.hpp"

namespace quern {

struct Value {
  std::variant<double, std::int64_t, bool, std::string, std::vector<double>, std::vector<std::string>, std::vector<Vec3>> data;
  const Key* key = nullptr;
  std::string where;  // "case.toml:12", or the override
};

class Values {
 public:
  std::string file;                   // as the user wrote it
  std::map<Path, Value> given;        // pairs of materials in alphabetical order
  std::map<Path, std::string> where;  // of each table

  bool has(const std::string& path) const { return given.count(split_path(path)) > 0; }
  // Whether any key of a table is given.
  bool has_table(const std::string& path) const;
  // The names used under a table: of materials for "material"; first names alone for "pair".
  std::vector<std::string> names(const std::string& table) const;

  // The given value or the key's default; asking for a key without either is a mistake of the program.
  double number(const std::string& path) const;
  std::int64_t whole(const std::string& path) const;
  bool flag(const std::string& path) const;
  std::string text(const std::string& path) const;
  Vec3 vector(const std::string& path) const;
  std::vector<double> numbers(const std::string& path) const;
  std::vector<std::string> texts(const std::string& path) const;
  std::vector<Vec3> vectors(const std::string& path) const;
  std::optional<double> number_if(const std::string& path) const;

  // Gives a key a value of its kind, in SI units, which is not checked; `from` is where it comes from, for messages.
  void put(const std::string& path, decltype(Value::data) data, const std::string& from);

  // Throws InputError: where the key stands (or its table, or the file), its name, and what is wrong with it.
  [[noreturn]] void refuse(const std::string& path, const std::string& what) const;

 private:
  Value value(const std::string& path) const;
};

// Reads a TOML file, lays the overrides ("key=value") over it, and checks every key against the table: known, of its kind and
// unit, in its range, all required ones there. Throws InputError on the first that is not.
Values read_values(const std::string& file, const std::vector<std::string>& overrides);

// The same of a text. `file` is what messages call it, and files that it names are beside that.
Values read_values_in(const std::string& text, const std::string& file, const std::vector<std::string>& overrides);

// The complete case as TOML, in SI units: what was given and every default that applies, each with its meaning.
std::string complete_case(const Values& values);

}  // namespace quern
