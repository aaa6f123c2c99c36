#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include "src/base/error.hpp"
#include "src/base/say.hpp"
#include "src/base/units.hpp"
#include "src/case/case.hpp"
#include "src/case/grid.hpp"
#include "src/case/keys.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/points.hpp"
#include "src/output/run_report.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct SweepWords {
  std::string file, directory;
  std::vector<std::string> sets;
  int jobs = 0;
};

// A cell of a swept key in SI units where it is a number.
std::string cell_of(const std::string& key, const std::string& value) {
  const Key* known = find_key(split_path(key));
  if (known && (known->kind == KeyKind::number || known->kind == KeyKind::whole)) {
    std::string bare = value;
    std::erase(bare, '"');
    return fmt::format("{}", Units().read(bare, known->unit));
  }
  const bool quote = value.find_first_of(",\"") != value.npos && value.front() != '"';
  return quote ? "\"" + value + "\"" : value;
}

void write_table(const std::vector<SweptKey>& swept, const std::vector<Point>& points, const fs::path& file) {
  std::vector<std::string> names;  // of headline numbers, in the order met
  std::map<std::string, std::string> units;
  std::map<std::string, bool> intervals;
  std::vector<nlohmann::json> summaries;
  for (const Point& point : points) {
    summaries.push_back(point.finished ? nlohmann::json::parse(content_of(point.directory + "/summary.json"), nullptr, false) : nlohmann::json());
    for (const auto& [name, entry] : summaries.back().items()) {
      if (!entry.is_object() || !entry.contains("value") || !entry["value"].is_number()) continue;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      units[name] = entry.value("unit", "1");
      intervals[name] |= entry.contains("ci95");
    }
  }
  std::string text;
  for (const SweptKey& key : swept) {
    const Key* known = find_key(split_path(key.key));
    const bool number = known && (known->kind == KeyKind::number || known->kind == KeyKind::whole);
    text += number ? fmt::format("{} [{}],", key.key, known->unit) : key.key + ",";
  }
  for (const std::string& name : names) {
    text += fmt::format("{} [{}],", name, units[name]);
    if (intervals[name]) text += fmt::format("{0}_from [{1}],{0}_to [{1}],", name, units[name]);
  }
  text += "directory\n";
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!points[k].finished) continue;
    for (std::size_t j = 0; j < swept.size(); ++j) {
      const std::string& one = points[k].overrides[j];
      text += cell_of(swept[j].key, one.substr(one.find('=') + 1)) + ",";
    }
    for (const std::string& name : names) {
      const nlohmann::json& entry = summaries[k].contains(name) ? summaries[k][name] : nlohmann::json();
      const auto number = [](const nlohmann::json& n) { return n.is_number() ? n.dump() : std::string(); };
      text += (entry.is_object() ? number(entry.value("value", nlohmann::json())) : "") + ",";
      if (!intervals[name]) continue;
      const bool both = entry.is_object() && entry.contains("ci95") && entry["ci95"].is_array() && entry["ci95"].size() == 2;
      text += (both ? number(entry["ci95"][0]) : "") + "," + (both ? number(entry["ci95"][1]) : "") + ",";
    }
    text += fs::path(points[k].directory).filename().string() + "\n";
  }
  write_aside(file.string(), text);
}

// A sweep does not fail for its report.
void tell_report(const std::string& directory) {
  try {
    const ReportWritten report = write_sweep_report(directory);
    for (const std::string& remark : report.remarks) say(remark + "\n");
    fmt::print("{}\n", (fs::path(directory) / "report.html").string());
  } catch (const std::exception& error) {
    say(std::string("The report is left out: ") + error.what() + "\n");
  }
}

int sweep(const SweepWords& words) {
  std::vector<SweptKey> swept;
  for (const std::string& set : words.sets) {
    swept.push_back(read_swept_key(set));
    for (std::size_t k = 0; k + 1 < swept.size(); ++k)
      if (swept[k].key == swept.back().key) throw InputError(fmt::format("--set {}: the key {} is swept twice.", set, swept.back().key));
  }
  std::vector<Point> points;
  std::string directory = words.directory;
  for (const auto& overrides : grid_of(swept)) {
    const Case c = read_case(words.file, overrides);  // every point is checked before any is run
    if (directory.empty()) directory = "out/" + c.name + "_sweep";
    points.push_back({words.file, overrides, (fs::path(directory) / folder_name(swept, overrides)).string(), c.text});
  }
  std::error_code problem;
  fs::create_directories(directory, problem);
  if (problem) throw InputError(fmt::format("{}: this directory cannot be made: {}.", directory, problem.message()));

  const std::size_t kept = keep_finished(points);
  if (kept > 0) fmt::print("{} of {} runs are finished already and are kept.\n", kept, points.size());

  const auto table = [&] { write_table(swept, points, fs::path(directory) / "sweep.csv"); };
  const int status = run_points(points, words.jobs, table);
  table();
  const auto done = std::count_if(points.begin(), points.end(), [](const Point& point) { return point.finished; });
  fmt::print("{} of {} runs are in {}\n", done, points.size(), (fs::path(directory) / "sweep.csv").string());
  if (done > 0) tell_report(directory);
  return status;
}

}  // namespace

void add_sweep(CLI::App& program, Action& action) {
  auto words = std::make_shared<SweepWords>();
  CLI::App* command = program.add_subcommand("sweep", "Runs a grid of cases in parallel into one table, sweep.csv; finished runs are kept");
  command->add_option("CASE", words->file, "Case file (TOML)")->required();
  command->add_option("--set", words->sets, "key=a,b,c or key=from:to:count; may be repeated")->required();
  command->add_option("--out", words->directory, "Directory; default out/<case name>_sweep");
  command->add_option("-j,--jobs", words->jobs, "Runs at a time; default: one per core")->check(CLI::Range(1, 1024));
  command->callback([words, &action] { action = [words] { return sweep(*words); }; });
}

}  // namespace quern
