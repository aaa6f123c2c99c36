#include <CLI/CLI.hpp>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <memory>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/case/case.hpp"
#include "src/case/validation.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/points.hpp"
#include "src/output/grinding_report.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct ValidateWords {
  std::vector<std::string> folders;
  std::string directory = "out/validate", page;
  int jobs = 0;
  bool slow = false, list = false, fresh = false;
};

std::vector<std::string> all_folders() {
  std::vector<std::string> folders;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator("cases", problem))
    if (fs::exists(entry.path() / "check.toml")) folders.push_back(entry.path().string());
  if (folders.empty()) throw InputError("cases: no folder here has a check.toml; allowed are folders of cases, or no folder in the directory that holds cases/.");
  std::sort(folders.begin(), folders.end());
  return folders;
}

// All runs of one case that are wanted, as points of the grid.
struct Planned {
  const CheckRun* run;
  std::size_t first, count;  // among the points
};

std::vector<Planned> plan(const Check& check, const ValidateWords& words, std::vector<Point>& points) {
  std::vector<Planned> planned;
  for (const CheckRun& run : check.runs) {
    if (run.slow && !words.slow) continue;
    planned.push_back({&run, points.size(), 0});
    if (run.grinding) continue;
    for (std::vector<std::string> overrides : grid_of(run.sweep)) {
      const fs::path folder = fs::path(words.directory) / check.name / run.name;
      const std::string directory = run.sweep.empty() ? folder.string() : (folder / folder_name(run.sweep, overrides)).string();
      overrides.insert(overrides.end(), run.set.begin(), run.set.end());
      points.push_back({run.file, overrides, directory, read_case(run.file, overrides).text});
      ++planned.back().count;
    }
  }
  return planned;
}

// Fits are quick and made anew each time.
RunResult ground(const GrindingRequest& request, const std::string& directory) {
  const GrindingStudy study = read_grinding(request);
  make_directory(directory);
  write_grinding(study, study_grinding(study), directory);
  return {{}, directory};
}

RunResults results_of(const Check& check, const ValidateWords& words, const std::vector<Planned>& planned, const std::vector<Point>& points) {
  RunResults results;
  for (const Planned& one : planned) {
    if (one.run->grinding) {
      results[one.run->name] = {ground(*one.run->grinding, (fs::path(words.directory) / check.name / one.run->name).string())};
      continue;
    }
    std::vector<RunResult> finished;
    for (std::size_t k = one.first; k < one.first + one.count; ++k) {
      if (!points[k].finished) continue;
      RunResult result{{}, points[k].directory};
      for (std::size_t j = 0; j < one.run->sweep.size(); ++j) {
        const std::string& override = points[k].overrides[j];
        result.place[override.substr(0, override.find('='))] = override.substr(override.find('=') + 1);
      }
      finished.push_back(result);
    }
    if (finished.size() == one.count) results[one.run->name] = finished;
  }
  return results;
}

std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))); }

void print_figure(const Figure& figure, const std::string& ours, const std::string& how) {
  fmt::print("  {:12}  {}: {}{}{}, band {}\n", how, figure.name, ours, figure.unit.empty() ? "" : " " + figure.unit,
             figure.reference ? fmt::format("; {} {}", figure.kind, number_text(*figure.reference)) : "", band_text(figure.band));
}

// Whether every band is met, known misses apart.
bool judge(const Check& check, const ValidateWords& words, const RunResults& results) {
  Memory memory = read_memory(check.folder);
  bool good = true;
  fmt::print("\n{}\n", check.name);
  for (const Figure& figure : check.figures) {
    if (check.slow(figure) && !words.slow) {
      print_figure(figure, memory.count(figure.name) ? ours_text(memory[figure.name].measured) : "–", "slow, not run");
      continue;
    }
    try {
      const Measured measured = measure(figure, results);
      const auto before = memory.find(figure.name);
      const bool unchanged = before != memory.end() && before->second.measured.value == measured.value && before->second.measured.ci95 == measured.ci95;
      if (!unchanged) memory[figure.name] = {measured, today(), program_version};
      const std::string how = verdict(figure, memory);
      print_figure(figure, ours_text(measured), how);
      good = good && how != "MISS";
    } catch (const InputError& e) {
      memory.erase(figure.name);
      fmt::print("  {:12}  {}\n", "MISS", e.what());
      good = false;
    }
  }
  const std::string file = (fs::path(check.folder) / "result.json").string(), text = memory_text(check, memory);
  if (content_of(file) != text) write_aside(file, text);
  return good;
}

int validate(const ValidateWords& words) {
  std::vector<Check> checks;
  for (const std::string& folder : words.folders.empty() ? all_folders() : words.folders) checks.push_back(read_check(folder));
  int status = 0;
  if (words.list) {
    for (const Check& check : checks) {
      const Memory memory = read_memory(check.folder);
      fmt::print("\n{}\n", check.name);
      for (const Figure& figure : check.figures) print_figure(figure, memory.count(figure.name) ? ours_text(memory.at(figure.name).measured) : "–", verdict(figure, memory));
    }
  } else {
    std::vector<Point> points;
    std::vector<std::vector<Planned>> planned;
    for (const Check& check : checks) planned.push_back(plan(check, words, points));
    if (!words.fresh) keep_finished(points);
    const int ended = run_points(points, words.jobs, [] {});
    if (ended > 1) return ended;
    status = ended;
    for (std::size_t k = 0; k < checks.size(); ++k)
      if (!judge(checks[k], words, results_of(checks[k], words, planned[k], points))) status = 1;
  }
  if (!words.page.empty()) {
    checks.clear();
    for (const std::string& folder : all_folders()) checks.push_back(read_check(folder));
    write_aside(words.page, validation_page(checks));
  }
  return status;
}

}  // namespace

void add_validate(CLI::App& program, Action& action) {
  auto words = std::make_shared<ValidateWords>();
  CLI::App* command = program.add_subcommand("validate", "Runs cases and holds their results against their sources (check.toml); finished runs are kept");
  command->add_option("CASE_FOLDER", words->folders, "Folders of cases; default: all under cases/");
  command->add_flag("--slow", words->slow, "Slow runs too");
  command->add_flag("--fresh", words->fresh, "Run again what is finished already");
  command->add_flag("--list", words->list, "Tell the figures and the latest results; run nothing");
  command->add_option("--docs", words->page, "Write the page of all cases (docs/validation.md)");
  command->add_option("--out", words->directory, "Directory of the runs")->capture_default_str();
  command->add_option("-j,--jobs", words->jobs, "Runs at a time; default: one per core")->check(CLI::Range(1, 1024));
  command->callback([words, &action] { action = [words] { return validate(*words); }; });
}

}  // namespace quern
