#include "src/case/values.hpp"
#include <fmt/format.h>
#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"

namespace quern {
namespace {

constexpr std::uintmax_t largest_case = 4 << 20;  // [bytes]

[[noreturn]] void fail(const std::string& message) { throw InputError(message); }

std::string ended(std::string sentence) {
  while (!sentence.empty() && (sentence.back() == '\n' || sentence.back() == ' ')) sentence.pop_back();
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  if (sentence.empty() || (sentence.back() != '.' && sentence.back() != '?')) sentence += '.';
  return sentence;
}

std::string content_of(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code problem;
  const fs::file_status status = fs::status(file, problem);
  if (status.type() == fs::file_type::not_found) fail(file + ": there is no such file; a case file (TOML) is needed.");
  if (fs::is_directory(status)) fail(file + ": this is a directory; a case file (TOML) is needed, such as " + (fs::path(file) / "case.toml").string() + ".");
  if (fs::is_regular_file(status) && fs::file_size(file, problem) > largest_case)
    fail(fmt::format("{}: this file has {:.1f} MB; a case file has at most {} MB.", file, static_cast<double>(fs::file_size(file)) / 1e6, largest_case >> 20));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(file + ": this file cannot be read; a case file (TOML) that you may read is needed.");
  std::string content(std::istreambuf_iterator<char>(stream), {});
  return content;
}

// The parser recurses once for each part of a dotted key; a key without end would take all of its stack. Returns the line of
// the first key that is too deep, or 0.
int too_deep(std::string_view content) {
  constexpr int most_dots = 64;
  int line = 1, dots = 0;
  bool comment = false;
  for (const char c : content) {
    if (c == '\n') ++line, comment = false;
    if (c == '#') comment = true;
    if (comment || std::string_view("=,{\n").find(c) != std::string_view::npos) dots = 0;
    else if (c == '.' && ++dots > most_dots) return line;
  }
  return 0;
}

struct Leaf {
  const toml::node* node;
  std::string where;
};

bool good_name(const std::string& name) {
  return !name.empty() && name.size() <= 100 && std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

class Reader {
 public:
  explicit Reader(const std::string& file) { values_.file = file; }

  Values read(const std::string& content, const std::vector<std::string>& overrides) {
    if (content.find('\0') != content.npos) fail(values_.file + ": this is a binary file; a case file is text (TOML).");
    if (content.find_first_not_of(" \t\r\n") == content.npos) fail(values_.file + ": this file is empty; a case names at least a duration, materials and what is inserted.");
    if (const int line = too_deep(content)) fail(fmt::format("{}:{}: found a key of more than 64 parts; the longest known key has 5.", values_.file, line));
    toml::table document;
    try {
      document = toml::parse(content, values_.file);
    } catch (const toml::parse_error& e) {
      fail(ended(fmt::format("{}:{}: {}", values_.file, e.source().begin.line, e.description())));
    }
    flatten(document, {}, "", true);
    std::vector<toml::table> kept(overrides.size());
    for (std::size_t k = 0; k < overrides.size(); ++k) override_with(overrides[k], kept[k]);
    for (const auto& [path, leaf] : leaves_) check(path, leaf);
    for (const auto& [path, where] : values_.where) require_all(path, where);
    require_all({}, values_.file);
    return std::move(values_);
  }

 private:
  std::string where_of(const toml::node& node, const std::string& given) const {
    return given.empty() ? fmt::format("{}:{}", values_.file, node.source().begin.line) : given;
  }

  [[noreturn]] void unknown(const Path& path, const std::string& where) const {
    fail(fmt::format("{}: {} is not a known key. The nearest known key is {}.", where, shorten(join_path(path)), nearest_key(path)));
  }

  static std::string shorten(const std::string& text) { return text.size() <= 80 ? text : text.substr(0, 80) + "…"; }

  void flatten(const toml::table& table, const Path& path, const std::string& given, bool once) {
    for (const auto& [name, node] : table) {
      Path here = path;
      // The names in diagnose.bounds are keys, quoted or not.
      if (here.size() == 3 && here[0] == "diagnose" && here[1] == "bounds") here[2] += "." + std::string(name.str());
      else here.emplace_back(name.str());
      place(here, node, given, once);
    }
  }

  void place(Path path, const toml::node& node, const std::string& given, bool once) {
    const std::string where = where_of(node, given);
    const bool bounds = path.size() == 3 && path[0] == "diagnose" && path[1] == "bounds";
    if (bounds && node.is_table()) return flatten(*node.as_table(), path, given, once);
    if (!bounds && !good_name(path.back())) fail(fmt::format("{}: found the name \"{}\"; allowed are letters, digits, _ and -.", where, shorten(path.back())));
    if (path.size() >= 3 && (path[0] == "pair" || path[0] == "bond") && path[1] != "default" && path[1] > path[2]) std::swap(path[1], path[2]);
    const Key* key = find_key(path);
    if (node.is_table()) {
      if (key) refuse(path, where, *key, "a table");
      if (!is_table(path)) fail(fmt::format("{}: [{}] is not a known table. The nearest known one is [{}].", where, shorten(join_path(path)), nearest_table(path)));
      values_.where.emplace(path, where);
      flatten(*node.as_table(), path, given, once);
      return;
    }
    if (!key) {
      if (is_table(path)) fail(fmt::format("{}: {} is a table, written [{}]; found {}.", where, join_path(path), join_path(path), shown(node)));
      unknown(path, where);
    }
    if (!once) leaves_.erase(path);
    const auto [old, fresh] = leaves_.emplace(path, Leaf{&node, where});
    if (!fresh) fail(fmt::format("{}: {} is given twice, here and at {}.", where, join_path(path), old->second.where));
    for (std::size_t depth = 1; depth < path.size(); ++depth) values_.where.emplace(Path(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(depth)), where);
  }

  void override_with(const std::string& text, toml::table& kept) {
    const std::string where = "--set " + shorten(text);
    const auto equals = text.find('=');
    if (equals == text.npos || equals == 0) fail(where + ": allowed is key=value, such as mill.speed_fraction=0.75.");
    const std::string value = text.substr(equals + 1);
    try {
      if (too_deep(value)) fail(where + ": found a key of more than 64 parts; the longest known key has 5.");
      kept = toml::parse("value = " + value);
    } catch (const toml::parse_error&) {
      kept = toml::table{{"value", value}};
    }
    if (kept.size() != 1) kept = toml::table{{"value", value}};
    place(split_path(text.substr(0, equals)), *kept.get("value"), where, false);
  }

  static std::string shown(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (node.is_array() && node.as_array()->size() > 6) return "a list of " + std::to_string(node.as_array()->size());
    if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
    if (const auto* text = node.as_string()) return fmt::format("\"{}\"", shorten(text->get()));
    std::ostringstream stream;
    node.visit([&](const auto& n) { stream << n; });
    return shorten(stream.str());
  }

  [[noreturn]] static void refuse(const Path& path, const std::string& where, const Key& key, const std::string& found) {
    fail(fmt::format("{}: {}: found {}; allowed is {}.", where, join_path(path), found, allowed_by(key)));
  }

  double number_of(const Path& path, const Leaf& leaf, const Key& key, const toml::node& node) const {
    double number = 0;
    if (const auto* text = node.as_string()) {
      try {
        number = units_.read(text->get(), key.unit);
      } catch (const InputError& e) {
        fail(fmt::format("{}: {}: {}.", leaf.where, join_path(path), e.what()));
      }
    } else if (node.is_number()) {
      number = *node.value<double>();
    } else {
      refuse(path, leaf.where, key, shown(node));
    }
    const Range& r = key.range;
    const bool inside = (r.above_least ? number > r.least : number >= r.least) && number <= r.most;
    if (!std::isfinite(number) || !inside) refuse(path, leaf.where, key, shown(node));
    return number;
  }

  std::vector<double> numbers_of(const Path& path, const Leaf& leaf, const Key& key, const toml::node& node) const {
    if (!node.is_array()) refuse(path, leaf.where, key, shown(node));
    std::vector<double> numbers;
    for (const toml::node& one : *node.as_array()) numbers.push_back(number_of(path, leaf, key, one));
    return numbers;
  }

  Vec3 vector_of(const Path& path, const Leaf& leaf, const Key& key, const toml::node& node) const {
    const std::vector<double> numbers = numbers_of(path, leaf, key, node);
    if (numbers.size() != 3) refuse(path, leaf.where, key, shown(node));
    return {numbers[0], numbers[1], numbers[2]};
  }

  void check(const Path& path, const Leaf& leaf) {
    const Key& key = *find_key(path);
    const toml::node& node = *leaf.node;
    Value value;
    value.key = &key;
    value.where = leaf.where;
    switch (key.kind) {
      case KeyKind::number: value.data = number_of(path, leaf, key, node); break;
      case KeyKind::whole: {
        const double number = number_of(path, leaf, key, node);
        if (number != std::floor(number) || node.is_string()) refuse(path, leaf.where, key, shown(node));
        value.data = static_cast<std::int64_t>(number);
        break;
      }
      case KeyKind::flag:
        if (!node.is_boolean()) refuse(path, leaf.where, key, shown(node));
        value.data = *node.value<bool>();
        break;
      case KeyKind::word:
      case KeyKind::text:
      case KeyKind::name:
      case KeyKind::file: {
        if (!node.is_string()) refuse(path, leaf.where, key, shown(node));
        const std::string word = *node.value<std::string>();
        const std::vector<std::string> words = words_of(key);
        if (key.kind == KeyKind::word && std::find(words.begin(), words.end(), word) == words.end()) {
          const std::string nearest = nearest_word(word, words);
          fail(fmt::format("{}: {}: found \"{}\"; allowed is {}.{}", leaf.where, join_path(path), shorten(word), allowed_by(key),
                           nearest.empty() ? "" : " Did you mean " + nearest + "?"));
        }
        value.data = word;
        break;
      }
      case KeyKind::names: {
        if (!node.is_array()) refuse(path, leaf.where, key, shown(node));
        std::vector<std::string> names;
        for (const toml::node& one : *node.as_array()) {
          if (!one.is_string()) refuse(path, leaf.where, key, shown(node));
          names.push_back(*one.value<std::string>());
        }
        value.data = names;
        break;
      }
      case KeyKind::numbers:
      case KeyKind::wholes: value.data = numbers_of(path, leaf, key, node); break;
      case KeyKind::vector: {
        const Vec3 v = vector_of(path, leaf, key, node);
        value.data = std::vector<double>{v.x(), v.y(), v.z()};
        break;
      }
      case KeyKind::vectors: {
        if (!node.is_array()) refuse(path, leaf.where, key, shown(node));
        std::vector<Vec3> vectors;
        for (const toml::node& one : *node.as_array()) vectors.push_back(vector_of(path, leaf, key, one));
        value.data = vectors;
        break;
      }
    }
    values_.given[path] = std::move(value);
  }

  void require_all(const Path& table, const std::string& where) const {
    for (const Key& key : all_keys()) {
      if (!key.required()) continue;
      Path path = split_path(key.path);
      if (path.size() != table.size() + 1) continue;
      std::copy(table.begin(), table.end(), path.begin());
      if (find_key(path) == &key && values_.given.count(path) == 0)
        fail(fmt::format("{}: {} is missing; needed is {} ({}).", where, join_path(path), allowed_by(key), key.meaning));
    }
  }

  Values values_;
  std::map<Path, Leaf> leaves_;
  Units units_;
};

Value read_default(const Key& key) {
  Value value;
  value.key = &key;
  const toml::table parsed = toml::parse(fmt::format("value = {}", key.fallback));
  const toml::node& node = *parsed.get("value");
  switch (key.kind) {
    case KeyKind::number: value.data = *node.value<double>(); break;
    case KeyKind::whole: value.data = *node.value<std::int64_t>(); break;
    case KeyKind::flag: value.data = *node.value<bool>(); break;
    case KeyKind::numbers:
    case KeyKind::vector: {
      std::vector<double> numbers;
      for (const toml::node& one : *node.as_array()) numbers.push_back(*one.value<double>());
      value.data = numbers;
      break;
    }
    default: value.data = *node.value<std::string>(); break;
  }
  return value;
}

// By key; most keys of a case have theirs, so each is read but once.
const Value& default_of(const Key& key) {
  static const std::vector<Value> all = [] {
    std::vector<Value> values;
    for (const Key& one : all_keys()) {
      const bool none = one.required() || std::string_view(one.fallback).empty();
      values.push_back(none ? Value{} : read_default(one));
    }
    return values;
  }();
  return all[static_cast<std::size_t>(&key - all_keys().data())];
}

std::string as_toml(const Value& value) {
  struct Writer {
    std::string operator()(double x) const { return fmt::format("{}", x); }
    std::string operator()(std::int64_t n) const { return fmt::format("{}", n); }
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(const std::string& text) const {
      std::ostringstream stream;
      stream << toml::value<std::string>(text);
      return stream.str();
    }
    std::string operator()(const std::vector<double>& numbers) const { return fmt::format("[{}]", fmt::join(numbers, ", ")); }
    std::string operator()(const std::vector<std::string>& texts) const {
      std::string all;
      for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + (*this)(text);
      return "[" + all + "]";
    }
    std::string operator()(const std::vector<Vec3>& vectors) const {
      std::string all;
      for (const Vec3& v : vectors) all += fmt::format("{}[{}, {}, {}]", all.empty() ? "" : ", ", v.x(), v.y(), v.z());
      return "[" + all + "]";
    }
  };
  return std::visit(Writer{}, value.data);
}

}  // namespace

bool Values::has_table(const std::string& path) const {
  const Path prefix = split_path(path);
  return std::any_of(given.begin(), given.end(), [&](const auto& entry) {
    return entry.first.size() > prefix.size() && std::equal(prefix.begin(), prefix.end(), entry.first.begin());
  });
}

void Values::put(const std::string& path, decltype(Value::data) data, const std::string& from) {
  const Path split = split_path(path);
  const Key* key = find_key(split);
  if (key == nullptr) throw std::logic_error("no key " + path);
  given[split] = Value{std::move(data), key, from};
  for (std::size_t depth = 1; depth < split.size(); ++depth) where.emplace(Path(split.begin(), split.begin() + static_cast<std::ptrdiff_t>(depth)), from);
}

std::vector<std::string> Values::names(const std::string& table) const {
  const Path prefix = split_path(table);
  std::vector<std::string> found;
  for (const auto& [path, place] : where)
    if (path.size() == prefix.size() + 1 && std::equal(prefix.begin(), prefix.end(), path.begin())) found.push_back(path.back());
  return found;
}

Value Values::value(const std::string& path) const {
  const Path split = split_path(path);
  const auto found = given.find(split);
  if (found != given.end()) return found->second;
  const Key* key = find_key(split);
  if (!key || key->required() || std::string_view(key->fallback).empty()) throw std::logic_error("no value for " + path);
  return default_of(*key);
}

double Values::number(const std::string& path) const { return std::get<double>(value(path).data); }
std::int64_t Values::whole(const std::string& path) const { return std::get<std::int64_t>(value(path).data); }
bool Values::flag(const std::string& path) const { return std::get<bool>(value(path).data); }
std::string Values::text(const std::string& path) const { return std::get<std::string>(value(path).data); }
std::vector<double> Values::numbers(const std::string& path) const { return std::get<std::vector<double>>(value(path).data); }
std::vector<std::string> Values::texts(const std::string& path) const { return std::get<std::vector<std::string>>(value(path).data); }
std::vector<Vec3> Values::vectors(const std::string& path) const { return std::get<std::vector<Vec3>>(value(path).data); }
Vec3 Values::vector(const std::string& path) const {
  const std::vector<double> v = numbers(path);
  return {v[0], v[1], v[2]};
}
std::optional<double> Values::number_if(const std::string& path) const { return has(path) ? std::optional(number(path)) : std::nullopt; }

void Values::refuse(const std::string& path, const std::string& what) const {
  const Path split = split_path(path);
  std::string place = file;
  if (const auto leaf = given.find(split); leaf != given.end()) {
    place = leaf->second.where;
  } else {
    for (std::size_t depth = split.size(); depth > 0; --depth) {
      const auto table = where.find(Path(split.begin(), split.begin() + static_cast<std::ptrdiff_t>(depth)));
      if (table == where.end()) continue;
      place = table->second;
      break;
    }
  }
  fail(ended(fmt::format("{}: {}{}{}", place, path, path.empty() ? "" : ": ", what)));
}

Values read_values(const std::string& file, const std::vector<std::string>& overrides) { return Reader(file).read(content_of(file), overrides); }

Values read_values_in(const std::string& text, const std::string& file, const std::vector<std::string>& overrides) { return Reader(file).read(text, overrides); }

std::string complete_case(const Values& values) {
  // Tables in the order of the keys; those of one kind in the alphabetical order of the user's names.
  const auto table_of = [](const Path& path) { return Path(path.begin(), path.end() - 1); };
  std::vector<Path> tables, kinds;
  for (const Key& key : all_keys()) {
    const Path kind = table_of(split_path(key.path));
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) continue;
    kinds.push_back(kind);
    std::set<Path> named;
    if (kind.empty() || kind == Path{"time_step"} || kind == Path{"output"} || kind == Path{"observe"}) named.insert(kind);
    for (const auto& [path, value] : values.given)
      if (table_of(split_path(value.key->path)) == kind) named.insert(table_of(path));
    tables.insert(tables.end(), named.begin(), named.end());
  }
  std::string text = "# The complete case as run, in SI units: what was given, and every default.\n";
  for (const Path& table : tables) {
    if (!table.empty()) text += fmt::format("\n[{}]\n", join_path(table));
    for (const Key& key : all_keys()) {
      Path path = split_path(key.path);
      const bool pair_default = table.size() == 2 && (table[0] == "pair" || table[0] == "bond") && path[0] == table[0];
      if (!pair_default && path.size() != table.size() + 1) continue;
      if (path.back() == "<key>") {
        if (table_of(path) != table) continue;
        for (const auto& [given, value] : values.given)
          if (value.key == &key) text += fmt::format("\"{}\" = {}\n", given.back(), as_toml(value));
        continue;
      }
      const std::string leaf = path.back();
      path = table;
      path.push_back(leaf);
      if (find_key(path) != &key) continue;
      const auto given = values.given.find(path);
      if (given == values.given.end() && (key.required() || std::string_view(key.fallback).empty())) continue;
      const bool unit = key.unit[0] != 0 && std::string_view(key.unit) != "1";
      text += fmt::format("{} = {}  # {}{}{}\n", leaf, as_toml(given != values.given.end() ? given->second : default_of(key)),
                          unit ? fmt::format("[{}] ", key.unit) : "", key.meaning, given == values.given.end() ? " (default)" : "");
    }
  }
  return text;
}

}  // namespace quern
