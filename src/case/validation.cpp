#include "src/case/validation.hpp"
#include <fmt/format.h>
#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/keys.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// One table of check.toml; every key must be asked for, the others are refused.
class Entry {
 public:
  Entry(const toml::table& table, std::string file, std::string name) : table_(table), file_(std::move(file)), name_(std::move(name)) {}

  std::string where() const { return fmt::format("{}:{}", file_, table_.source().begin.line); }

  [[noreturn]] void refuse(const std::string& key, const std::string& what) const {
    const toml::node* node = table_.get(key);
    throw InputError(fmt::format("{}:{}: {}{}: {}.", file_, (node ? node->source() : table_.source()).begin.line, name_.empty() ? "" : name_ + ".", key, what));
  }

  const toml::node* node(const char* key) {
    known_.insert(key);
    return table_.get(key);
  }
  std::string text(const char* key, const char* fallback = nullptr) {
    const toml::node* n = node(key);
    if (!n && fallback) return fallback;
    if (!n) refuse(key, "is missing; needed is a text");
    if (!n->is_string()) refuse(key, "allowed is a text");
    return n->as_string()->get();
  }
  std::optional<double> number_if(const char* key) {
    const toml::node* n = node(key);
    if (!n) return std::nullopt;
    const auto value = n->value<double>();
    if (!value || n->is_string() || n->is_boolean()) refuse(key, "allowed is a number");
    return value;
  }
  bool flag(const char* key, bool fallback) {
    const toml::node* n = node(key);
    if (!n) return fallback;
    if (!n->is_boolean()) refuse(key, "allowed is true or false");
    return n->as_boolean()->get();
  }
  std::vector<std::string> texts(const char* key) {
    std::vector<std::string> all;
    const toml::node* n = node(key);
    if (!n) return all;
    if (!n->is_array()) refuse(key, "allowed is a list of texts");
    for (const toml::node& one : *n->as_array()) {
      if (!one.is_string()) refuse(key, "allowed is a list of texts");
      all.push_back(one.as_string()->get());
    }
    return all;
  }
  SweepPlace place(const char* key) {
    SweepPlace all;
    const toml::node* n = node(key);
    if (!n) return all;
    if (!n->is_table()) refuse(key, "allowed is a table such as { \"mill.speed_fraction\" = 0.7 }");
    collect(*n->as_table(), "", all, key);
    return all;
  }
  std::optional<Entry> table_if(const char* key) {
    const toml::node* n = node(key);
    if (!n) return std::nullopt;
    if (!n->is_table()) refuse(key, "allowed is a table in braces");
    return Entry(*n->as_table(), file_, key);
  }
  void refuse_others() const {
    for (const auto& [key, value] : table_) {
      const std::string one(key.str());
      if (known_.count(one)) continue;
      const std::string near = nearest_word(one, {known_.begin(), known_.end()});
      refuse(one, fmt::format("is not known here; allowed are {}{}", fmt::join(known_, ", "), near.empty() ? "" : ". The nearest is " + near));
    }
  }

 private:
  void collect(const toml::table& table, const std::string& before, SweepPlace& all, const char* key) const {
    for (const auto& [name, value] : table) {
      const std::string path = before + std::string(name.str());
      if (value.is_table()) collect(*value.as_table(), path + ".", all, key);
      else if (value.is_string()) all[path] = value.as_string()->get();
      else if (value.is_integer()) all[path] = fmt::format("{}", value.as_integer()->get());
      else if (value.is_floating_point()) all[path] = fmt::format("{}", value.as_floating_point()->get());
      else refuse(key, "allowed are numbers and texts");
    }
  }

  const toml::table& table_;
  std::string file_, name_;
  std::set<std::string> known_;
};

CheckRun read_run(Entry entry, const std::string& folder, bool slow) {
  CheckRun run;
  run.name = entry.text("name");
  const bool plain = !run.name.empty() && std::all_of(run.name.begin(), run.name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; });
  if (!plain) entry.refuse("name", fmt::format("found \"{}\"; allowed are letters, digits, _ and -", run.name));
  run.file = (fs::path(folder) / entry.text("file", "case.toml")).string();
  run.set = entry.texts("set");
  for (const std::string& one : entry.texts("sweep")) {
    try {
      run.sweep.push_back(read_swept_key(one));
    } catch (const InputError& e) {
      entry.refuse("sweep", e.what());
    }
  }
  run.slow = entry.flag("slow", slow);
  const std::string sizes = entry.text("grinding", "");
  GrindingRequest grinding{(fs::path(folder) / sizes).string(), "", entry.text("against", ""), entry.texts("limits"), entry.text("until", "")};
  if (!sizes.empty()) run.grinding = std::move(grinding);
  else if (entry.node("against") || entry.node("limits") || entry.node("until")) entry.refuse("grinding", "is missing; `against`, `limits` and `until` belong to it");
  if (run.grinding && (!run.set.empty() || !run.sweep.empty() || entry.node("file"))) entry.refuse("grinding", "stands alone: it takes no `file`, `set` or `sweep`");
  entry.refuse_others();
  return run;
}

Figure read_figure(Entry entry) {
  Figure figure;
  figure.where = entry.where();
  figure.name = entry.text("name");
  figure.run = entry.text("run");
  figure.at = entry.place("at");
  figure.unit = entry.text("unit", "");
  figure.kind = entry.text("kind", "");
  figure.note = entry.text("note", "");
  figure.scale = entry.number_if("scale").value_or(1);
  figure.offset = entry.number_if("offset").value_or(0);
  figure.reference = entry.number_if("reference");
  figure.known_miss = entry.flag("known_miss", false);
  const std::vector<std::string> kinds = {"measured", "printed simulation", "closed form", "other codes", "expectation", ""};
  if (std::find(kinds.begin(), kinds.end(), figure.kind) == kinds.end())
    entry.refuse("kind", fmt::format("found \"{}\"; allowed is one of {}", figure.kind, fmt::join(kinds.begin(), kinds.end() - 1, ", ")));
  if (figure.reference && figure.kind.empty()) entry.refuse("kind", "is missing; a reference needs one of " + fmt::format("{}", fmt::join(kinds.begin(), kinds.end() - 1, ", ")));
  if (figure.known_miss && figure.note.empty()) entry.refuse("note", "is missing; a known miss needs a note that tells why");
  const toml::node* band = entry.node("band");
  const toml::array* ends = band ? band->as_array() : nullptr;
  if (!ends || ends->size() != 2 || !(*ends)[0].is_number() || !(*ends)[1].is_number()) entry.refuse("band", "needed are two numbers [from, to]");
  figure.band = {*(*ends)[0].value<double>(), *(*ends)[1].value<double>()};
  if (!(figure.band[0] <= figure.band[1])) entry.refuse("band", "allowed are two ascending numbers [from, to]");

  int measures = 0;
  if (entry.node("value")) ++measures, figure.measure = HeadlineMeasure{entry.text("value")};
  using Kind = SweepMeasure::Kind;
  for (const auto& [word, kind, needs_over] : {std::tuple("peak_at", Kind::peak_at, true), std::tuple("largest", Kind::largest, false), std::tuple("smallest", Kind::smallest, false),
                                               std::tuple("mean", Kind::mean, false), std::tuple("exponent", Kind::exponent, true), std::tuple("slope", Kind::slope, true)}) {
    if (auto part = entry.table_if(word)) {
      ++measures;
      SweepMeasure sweep{kind, part->text("of"), ""};
      if (needs_over) sweep.over = part->text("over");
      part->refuse_others();
      figure.measure = sweep;
    }
  }
  for (const char* word : {"ratio", "difference"}) {
    if (auto part = entry.table_if(word)) {
      ++measures;
      PairMeasure pair;
      pair.ratio = std::string_view(word) == "ratio";
      pair.of = part->text("of");
      pair.of2 = part->text("of2", pair.of.c_str());
      pair.run = part->text("run", figure.run.c_str());
      pair.at = part->node("at") ? part->place("at") : figure.at;
      part->refuse_others();
      figure.measure = pair;
    }
  }
  if (auto part = entry.table_if("table")) {
    ++measures;
    TableMeasure table;
    table.file = part->text("file"), table.column = part->text("column"), table.over = part->text("over", ""), table.pick = part->text("pick", ""), table.x = part->text("x", "");
    const auto at = part->number_if("at");
    table.at = at.value_or(0);
    table.where = part->place("where");
    const std::vector<std::string> picks = {"first", "last", "max", "min", "mean"};
    if (table.pick.empty() == table.x.empty() || table.x.empty() == at.has_value()) part->refuse("pick", "needed is pick, or x with at");
    if (!table.pick.empty() && std::find(picks.begin(), picks.end(), table.pick) == picks.end()) part->refuse("pick", fmt::format("found \"{}\"; allowed is one of {}", table.pick, fmt::join(picks, ", ")));
    part->refuse_others();
    figure.measure = table;
  }
  if (measures != 1) entry.refuse("value", fmt::format("found {} measures; needed is one of value, peak_at, largest, smallest, mean, exponent, slope, ratio, difference, table", measures));
  entry.refuse_others();
  return figure;
}

// Text to number in SI units, if it is one of this key.
std::optional<double> number_of(const std::string& key, std::string text) {
  static const Units units;
  std::erase(text, '"');
  const Key* known = find_key(split_path(key));
  try {
    return units.read(text, known && *known->unit ? known->unit : "1");
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool same(const std::string& key, const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto x = number_of(key, a), y = number_of(key, b);
  return x && y && std::abs(*x - *y) <= 1e-6 * std::max(std::abs(*x), std::abs(*y));
}

std::string place_text(const SweepPlace& place) {
  std::string text;
  for (const auto& [key, value] : place) text += (text.empty() ? "" : ", ") + key + " = " + value;
  return text;
}

[[noreturn]] void missing(const Figure& figure, const std::string& what) { throw InputError(fmt::format("{}: figure \"{}\": {}.", figure.where, figure.name, what)); }

std::vector<RunResult> runs_at(const Figure& figure, const RunResults& results, const std::string& run, const SweepPlace& at) {
  std::vector<RunResult> found;
  const auto those = results.find(run);
  if (those == results.end()) missing(figure, fmt::format("the run {} has no results", run));
  for (const RunResult& one : those->second) {
    const bool here = std::all_of(at.begin(), at.end(), [&](const auto& part) {
      const auto swept = one.place.find(part.first);
      return swept != one.place.end() && same(part.first, swept->second, part.second);
    });
    if (here) found.push_back(one);
  }
  if (found.empty()) missing(figure, fmt::format("no run of {} is at {}", run, place_text(at)));
  return found;
}

RunResult run_at(const Figure& figure, const RunResults& results, const std::string& run, const SweepPlace& at) {
  const std::vector<RunResult> found = runs_at(figure, results, run, at);
  if (found.size() > 1) missing(figure, fmt::format("{} runs of {} are meant; `at` must choose one", found.size(), run));
  return found[0];
}

Measured headline(const Figure& figure, const RunResult& run, const std::string& key) {
  std::ifstream stream(fs::path(run.directory) / "summary.json");
  const Json summary = Json::parse(stream, nullptr, false);
  if (!summary.is_object() || !summary.contains(key) || !summary[key].contains("value") || !summary[key]["value"].is_number()) {
    std::vector<std::string> names;
    if (summary.is_object())
      for (const auto& [name, entry] : summary.items()) names.push_back(name);
    const std::string near = nearest_word(key, names);
    missing(figure, fmt::format("{} has no number {}{}", (fs::path(run.directory) / "summary.json").string(), key, near.empty() ? "" : "; the nearest is " + near));
  }
  Measured m{summary[key]["value"], {}};
  if (summary[key].contains("ci95") && summary[key]["ci95"].is_array() && summary[key]["ci95"].size() == 2) m.ci95 = {{summary[key]["ci95"][0], summary[key]["ci95"][1]}};
  return m;
}

double half_width(const Measured& m) { return m.ci95 ? 0.5 * ((*m.ci95)[1] - (*m.ci95)[0]) : 0.0; }

Measured with_half_width(double value, double half) { return half > 0 ? Measured{value, {{value - half, value + half}}} : Measured{value, {}}; }

double slope_of(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mx = 0, my = 0, xy = 0, xx = 0;
  for (std::size_t k = 0; k < x.size(); ++k) mx += x[k] / n, my += y[k] / n;
  for (std::size_t k = 0; k < x.size(); ++k) xy += (x[k] - mx) * (y[k] - my), xx += (x[k] - mx) * (x[k] - mx);
  return xy / xx;
}

// The top of the parabola through three points about the greatest; at the edge, the edge.
double peak_of(const std::vector<double>& x, const std::vector<double>& y) {
  const auto k = static_cast<std::size_t>(std::max_element(y.begin(), y.end()) - y.begin());
  if (k == 0 || k + 1 == y.size()) return x[k];
  const double left = (y[k] - y[k - 1]) / (x[k] - x[k - 1]), right = (y[k + 1] - y[k]) / (x[k + 1] - x[k]);
  const double curvature = (right - left) / (x[k + 1] - x[k - 1]);
  return 0.5 * (x[k - 1] + x[k]) - 0.5 * left / curvature;
}

Measured over_sweep(const Figure& figure, const SweepMeasure& sweep, const RunResults& results) {
  std::vector<std::array<double, 2>> points;
  for (const RunResult& run : runs_at(figure, results, figure.run, figure.at)) {
    double x = static_cast<double>(points.size());
    if (!sweep.over.empty()) {
      const auto swept = run.place.find(sweep.over);
      const auto number = swept != run.place.end() ? number_of(sweep.over, swept->second) : headline(figure, run, sweep.over).value;
      if (!number) missing(figure, sweep.over + " is not a number");
      x = *number;
    }
    points.push_back({x, headline(figure, run, sweep.of).value});
  }
  std::sort(points.begin(), points.end());
  std::vector<double> x, y;
  for (const auto& [a, b] : points) x.push_back(a), y.push_back(b);
  using Kind = SweepMeasure::Kind;
  if (sweep.kind == Kind::largest) return {*std::max_element(y.begin(), y.end()), {}};
  if (sweep.kind == Kind::smallest) return {*std::min_element(y.begin(), y.end()), {}};
  if (sweep.kind == Kind::peak_at) return {peak_of(x, y), {}};
  if (sweep.kind == Kind::mean) {
    double sum = 0;
    for (const double one : y) sum += one;
    return {sum / static_cast<double>(y.size()), {}};
  }
  if (x.size() < 2 || x.front() == x.back()) missing(figure, fmt::format("a slope over {} needs two runs that differ in it", sweep.over));
  if (sweep.kind == Kind::exponent) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (!(x[k] > 0 && y[k] > 0)) missing(figure, "an exponent needs positive numbers");
      x[k] = std::log(x[k]), y[k] = std::log(y[k]);
    }
  }
  return {slope_of(x, y), {}};
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    else if (c == ',' && !quoted) cells.emplace_back();
    else if (c != '\r') cells.back() += c;
  }
  return cells;
}

Measured from_table(const Figure& figure, const TableMeasure& table, const RunResult& run) {
  const std::string file = (fs::path(run.directory) / table.file).string();
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) missing(figure, file + " cannot be read");
  std::vector<std::string> names = cells_of(line);
  for (std::string& name : names) name = name.substr(0, name.find(" ["));
  const auto index = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) missing(figure, fmt::format("{} has no column {}; it has {}", file, name, fmt::join(names, ", ")));
    return static_cast<std::size_t>(found - names.begin());
  };
  const std::size_t column = index(table.column);
  std::vector<double> x, y;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != names.size()) continue;
    if (!std::all_of(table.where.begin(), table.where.end(), [&](const auto& part) { return same("", cells[index(part.first)], part.second); })) continue;
    auto number = number_of("", cells[column]);
    if (number && !table.over.empty()) number = *number / number_of("", cells[index(table.over)]).value_or(NAN);
    const auto along = table.x.empty() ? std::optional(0.0) : number_of("", cells[index(table.x)]);
    if (number && along) y.push_back(*number), x.push_back(*along);
  }
  if (y.empty()) missing(figure, fmt::format("{} has no row with {}", file, place_text(table.where)));
  if (table.pick == "first") return {y.front(), {}};
  if (table.pick == "last") return {y.back(), {}};
  if (table.pick == "max") return {*std::max_element(y.begin(), y.end()), {}};
  if (table.pick == "min") return {*std::min_element(y.begin(), y.end()), {}};
  if (table.pick == "mean") {
    double sum = 0;
    for (const double one : y) sum += one;
    return {sum / static_cast<double>(y.size()), {}};
  }
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    if ((x[k] - table.at) * (x[k + 1] - table.at) > 0 || x[k] == x[k + 1]) continue;
    return {y[k] + (y[k + 1] - y[k]) * (table.at - x[k]) / (x[k + 1] - x[k]), {}};
  }
  missing(figure, fmt::format("{}: {} = {} lies outside {} … {}", file, table.x, table.at, x.front(), x.back()));
}

std::string escaped(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != text.npos; at += 2) text.insert(at, "\\");
  return text;
}

}  // namespace

const CheckRun& Check::run(const std::string& run_name) const {
  return *std::find_if(runs.begin(), runs.end(), [&](const CheckRun& one) { return one.name == run_name; });
}

bool Check::slow(const Figure& figure) const {
  const auto* pair = std::get_if<PairMeasure>(&figure.measure);
  return run(figure.run).slow || (pair && run(pair->run).slow);
}

Check read_check(const std::string& folder) {
  const std::string file = (fs::path(folder) / "check.toml").string();
  Check check;
  check.folder = folder;
  check.name = fs::path(folder).lexically_normal().filename().string();
  if (check.name.empty()) check.name = fs::path(folder).lexically_normal().parent_path().filename().string();
  toml::table document;
  if (!fs::is_regular_file(file)) throw InputError(file + ": this file cannot be read; a case that is checked needs it (docs/adding-a-case.md).");
  try {
    document = toml::parse_file(file);
  } catch (const toml::parse_error& e) {
    throw InputError(fmt::format("{}:{}: this is not TOML: {}.", file, e.source().begin.line, e.description()));
  }
  Entry top(document, file, "");
  check.source = top.text("source");
  const bool slow = top.flag("slow", false);
  const auto tables = [&](const char* key) {
    const toml::node* node = top.node(key);
    if (!node || !node->is_array_of_tables()) top.refuse(key, fmt::format("at least one [[{}]] is needed", key));
    std::vector<const toml::table*> all;
    for (const toml::node& one : *node->as_array()) all.push_back(one.as_table());
    return all;
  };
  for (const toml::table* one : tables("run")) check.runs.push_back(read_run(Entry(*one, file, "run"), folder, slow));
  const auto known = [&](const std::string& name) { return std::any_of(check.runs.begin(), check.runs.end(), [&](const CheckRun& run) { return run.name == name; }); };
  std::set<std::string> names;
  for (const toml::table* one : tables("figure")) {
    const Entry entry(*one, file, "figure");
    Figure figure = read_figure(entry);
    const auto* pair = std::get_if<PairMeasure>(&figure.measure);
    for (const std::string& name : {figure.run, pair ? pair->run : figure.run})
      if (!known(name)) entry.refuse("run", fmt::format("found \"{}\"; no [[run]] has that name", name));
    if (!names.insert(figure.name).second) entry.refuse("name", fmt::format("two figures are called \"{}\"", figure.name));
    check.figures.push_back(std::move(figure));
  }
  top.refuse_others();
  return check;
}

Measured measure(const Figure& figure, const RunResults& results) {
  Measured m;
  if (const auto* value = std::get_if<HeadlineMeasure>(&figure.measure)) m = headline(figure, run_at(figure, results, figure.run, figure.at), value->key);
  if (const auto* sweep = std::get_if<SweepMeasure>(&figure.measure)) m = over_sweep(figure, *sweep, results);
  if (const auto* table = std::get_if<TableMeasure>(&figure.measure)) m = from_table(figure, *table, run_at(figure, results, figure.run, figure.at));
  if (const auto* pair = std::get_if<PairMeasure>(&figure.measure)) {
    const Measured a = headline(figure, run_at(figure, results, figure.run, figure.at), pair->of);
    const Measured b = headline(figure, run_at(figure, results, pair->run, pair->at), pair->of2);
    if (pair->ratio) m = with_half_width(a.value / b.value, std::abs(a.value / b.value) * std::hypot(half_width(a) / a.value, half_width(b) / b.value));
    else m = with_half_width(a.value - b.value, std::hypot(half_width(a), half_width(b)));
  }
  const auto shown = [&](double x) { return x * figure.scale + figure.offset; };
  m.value = shown(m.value);
  if (m.ci95) m.ci95 = {{std::min(shown((*m.ci95)[0]), shown((*m.ci95)[1])), std::max(shown((*m.ci95)[0]), shown((*m.ci95)[1]))}};
  return m;
}

bool meets(const Figure& figure, const Measured& m) { return m.value >= figure.band[0] && m.value <= figure.band[1]; }

Memory read_memory(const std::string& folder) {
  Memory memory;
  std::ifstream stream(fs::path(folder) / "result.json");
  const Json all = stream ? Json::parse(stream, nullptr, false) : Json();
  if (!all.is_object() || !all.contains("figures") || !all["figures"].is_array()) return memory;
  for (const Json& one : all["figures"]) {
    if (!one.is_object() || !one.contains("name") || !one.contains("value") || !one["value"].is_number()) continue;
    RememberedFigure remembered{{one["value"], {}}, one.value("date", ""), one.value("version", "")};
    if (one.contains("ci95") && one["ci95"].is_array() && one["ci95"].size() == 2) remembered.measured.ci95 = {{one["ci95"][0], one["ci95"][1]}};
    memory[one["name"]] = remembered;
  }
  return memory;
}

std::string memory_text(const Check& check, const Memory& memory) {
  Json figures = Json::array();
  for (const Figure& figure : check.figures) {
    const auto found = memory.find(figure.name);
    if (found == memory.end()) continue;
    const RememberedFigure& one = found->second;
    Json entry = {{"name", figure.name}, {"value", one.measured.value}, {"unit", figure.unit}};
    if (one.measured.ci95) entry["ci95"] = *one.measured.ci95;
    entry["date"] = one.date, entry["version"] = one.version;
    figures.push_back(entry);
  }
  return Json{{"case", check.name}, {"figures", figures}}.dump(1) + "\n";
}

std::string verdict(const Figure& figure, const Memory& memory) {
  const auto found = memory.find(figure.name);
  if (found == memory.end()) return "not run";
  return meets(figure, found->second.measured) ? "pass" : figure.known_miss ? "MISS (known)" : "MISS";
}

std::string number_text(double value) { return fmt::format("{:.4g}", value); }

std::string ours_text(const Measured& m) {
  return number_text(m.value) + (m.ci95 ? fmt::format(" ({} … {})", number_text((*m.ci95)[0]), number_text((*m.ci95)[1])) : "");
}

std::string band_text(const std::array<double, 2>& band) {
  if (std::isinf(band[0]) && std::isinf(band[1])) return "any";
  if (std::isinf(band[0])) return "at most " + number_text(band[1]);
  if (std::isinf(band[1])) return "at least " + number_text(band[0]);
  return number_text(band[0]) + " … " + number_text(band[1]);
}

std::string validation_page(const std::vector<Check>& checks) {
  std::string cases, overview;
  for (const Check& check : checks) {
    const Memory memory = read_memory(check.folder);
    int passed = 0, missed = 0, waiting = 0;
    std::string rows, days;
    std::vector<std::string> notes;
    std::set<std::string> dates;
    for (const Figure& figure : check.figures) {
      const std::string how = verdict(figure, memory);
      ++(how == "pass" ? passed : how == "not run" ? waiting : missed);
      const auto found = memory.find(figure.name);
      if (found != memory.end()) dates.insert(found->second.date + ", quern " + found->second.version);
      std::string mark;
      if (!figure.note.empty()) {
        auto note = std::find(notes.begin(), notes.end(), figure.note);
        if (note == notes.end()) note = notes.insert(notes.end(), figure.note);
        mark = fmt::format(" ({})", note - notes.begin() + 1);
      }
      rows += fmt::format("| {}{} | {} | {} | {} | {} | {} | {} |\n", escaped(figure.name), mark, found != memory.end() ? ours_text(found->second.measured) : "–",
                          figure.reference ? number_text(*figure.reference) : "–", figure.unit.empty() ? "–" : figure.unit, figure.kind.empty() ? "–" : figure.kind, band_text(figure.band),
                          how == "pass" || how == "not run" ? how : "**" + how + "**");
    }
    for (const std::string& day : dates) days += (days.empty() ? "" : "; ") + day;
    overview += fmt::format("| [{0}](../cases/{0}) | {1} | {2} | {3} |\n", check.name, passed, missed, waiting);
    cases += fmt::format("\n## {0}\n\n{1}\n\n| figure | ours | source | unit | the source's is | band for ours | verdict |\n|---|---|---|---|---|---|---|\n{2}", check.name, check.source, rows);
    if (!notes.empty()) cases += "\n";
    for (std::size_t k = 0; k < notes.size(); ++k) cases += fmt::format("{}. {}\n", k + 1, notes[k]);
    if (!days.empty()) cases += fmt::format("\nRun on {}.\n", days);
  }
  return "# Validation\n\nMade by `quern validate --docs docs/validation.md` from the results (`cases/*/result.json`) and what they are checked against\n"
         "(`cases/*/check.toml`); nothing is written by hand. Ours carries its 95 % interval where it has one. A band says where ours must lie; a known\n"
         "miss is a band that ours does not meet for a reason that its note tells.\n\n| case | bands met | missed | not run |\n|---|---|---|---|\n" +
         overview + cases;
}

}  // namespace quern
