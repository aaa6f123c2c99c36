#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/case.hpp"
#include "src/case/grid.hpp"
#include "src/case/keys.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/stop_signal.hpp"

extern char** environ;

namespace quern {
namespace {

namespace fs = std::filesystem;

struct SweepWords {
  std::string file, directory;
  std::vector<std::string> sets;
  int jobs = 0;
};

// One point of the grid, run by a process of its own.
struct Point {
  std::vector<std::string> overrides;
  std::string directory;
  std::string text;  // the complete case, by which a finished run is known again
  pid_t process = 0;
  bool finished = false;
  int status = 0;
};

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_aside(const fs::path& file, const std::string& content) {
  const fs::path aside = file.string() + ".part";
  std::ofstream(aside, std::ios::binary) << content;
  std::error_code problem;
  fs::rename(aside, file, problem);
  if (problem) throw RunError(fmt::format("{} cannot be written: {}.", file.string(), problem.message()));
}

fs::path mark_of(const Point& point) { return fs::path(point.directory) / "finished.toml"; }

// Named by the keys that differ between the runs.
std::string folder_name(const std::vector<SweptKey>& swept, const std::vector<std::string>& overrides) {
  std::string name;
  for (std::size_t k = 0; k < swept.size(); ++k)
    if (swept[k].values.size() > 1) name += (name.empty() ? "" : "__") + overrides[k];
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string_view("=._-+").find(c) == std::string_view::npos) c = '_';
  return name.empty() ? "run" : name;
}

void start(Point& point, const SweepWords& words) {
  fs::create_directories(point.directory);
  std::vector<std::string> arguments = {"quern", "run", words.file, "--out", point.directory, "--threads", "1", "--quiet"};
  for (const std::string& one : point.overrides) arguments.push_back("--set=" + one);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  const std::string log = point.directory + "/log.txt";
  posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  const int problem = posix_spawn(&point.process, "/proc/self/exe", &files, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (problem != 0) throw RunError(fmt::format("A run of the sweep could not be started: {}.", std::strerror(problem)));
}

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
    summaries.push_back(point.finished ? nlohmann::json::parse(content_of(fs::path(point.directory) / "summary.json"), nullptr, false) : nlohmann::json());
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
  write_aside(file, text);
}

std::string joined(const std::vector<std::string>& overrides) { return fmt::format("{}", fmt::join(overrides, " ")); }

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
    points.push_back({overrides, (fs::path(directory) / folder_name(swept, overrides)).string(), c.text});
  }
  std::error_code problem;
  fs::create_directories(directory, problem);
  if (problem) throw InputError(fmt::format("{}: this directory cannot be made: {}.", directory, problem.message()));

  std::size_t kept = 0;
  for (Point& point : points)
    if (content_of(mark_of(point)) == point.text) point.finished = true, ++kept;
  if (kept > 0) fmt::print("{} of {} runs are finished already and are kept.\n", kept, points.size());

  const std::atomic<int>* stop = watch_stop_signals();
  const auto jobs = static_cast<std::size_t>(words.jobs > 0 ? words.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  std::vector<Point*> running;
  std::size_t next = 0, done = kept, failed = 0;
  bool told = false;
  while (!running.empty() || (next < points.size() && *stop == 0)) {
    while (*stop == 0 && running.size() < jobs && next < points.size()) {
      Point& point = points[next++];
      if (point.finished) continue;
      start(point, words);
      running.push_back(&point);
    }
    if (*stop != 0 && !told) {
      for (const Point* point : running) kill(point->process, *stop);
      told = true;
    }
    for (std::size_t k = 0; k < running.size();) {
      Point& point = *running[k];
      int status = 0;
      if (waitpid(point.process, &status, WNOHANG) != point.process) {
        ++k;
        continue;
      }
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(k));
      point.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      if (point.status == 0) {
        write_aside(mark_of(point), point.text);
        point.finished = true;
        fmt::print("{}/{}  {}\n", ++done, points.size(), joined(point.overrides));
        std::fflush(stdout);
        write_table(swept, points, fs::path(directory) / "sweep.csv");
      } else if (*stop == 0) {
        ++failed;
        std::string log = content_of(fs::path(point.directory) / "log.txt");
        while (!log.empty() && log.back() == '\n') log.pop_back();
        fmt::print(stderr, "The run {} failed (exit status {}): {}\n", joined(point.overrides), point.status, log.substr(log.rfind('\n') + 1));
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  write_table(swept, points, fs::path(directory) / "sweep.csv");
  fmt::print("{} of {} runs are in {}\n", done, points.size(), (fs::path(directory) / "sweep.csv").string());
  if (*stop != 0) return 128 + *stop;
  return failed > 0 ? 1 : 0;
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
