#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/whole_file.hpp"
#include "src/cli/commands.hpp"
#include "src/diagnose/report.hpp"
#include "src/diagnose/written.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct DiagnoseWords {
  std::string file, directory;
  std::vector<std::string> recordings, overrides;
  DiagnoseOptions options;
  bool no_pictures = false;
};

int compare(const DiagnoseWords& words) {
  const Values values = read_values(words.file, words.overrides);
  const Recording recording = read_recordings(words.recordings);
  const Experiment experiment(values, recording);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  ThreadTeam team(words.options.threads > 0 ? words.options.threads : cores);
  const Diagnosis diagnosis = diagnose(experiment, team, words.options);
  const fs::path folder = fs::absolute(words.file).lexically_normal();
  const std::string name = folder.stem() == "case" ? folder.parent_path().filename().string() : folder.stem().string();
  const std::string directory = words.directory.empty() ? "out/" + name + "_diagnosis" : words.directory;
  make_directory(directory);
  write_diagnosis(experiment, diagnosis, directory);
  std::vector<std::string> skipped;
  if (!words.no_pictures) skipped = write_report(experiment, diagnosis, team, directory);
  if (!words.options.quiet) {
    for (const std::string& remark : recording.remarks) fmt::print("{}\n", remark);
    for (const std::string& line : diagnosis_words(diagnosis)) fmt::print("{}\n", line);
    for (const std::string& line : skipped) fmt::print("{}\n", line);
    fmt::print("{}diagnosis.json, amended.toml, residuals.csv and fits.csv are in {}\n", words.no_pictures ? "" : "report.html, ", directory);
  }
  return 0;
}

}  // namespace

void add_diagnose(CLI::App& program, Action& action) {
  auto words = std::make_shared<DiagnoseWords>();
  CLI::App* command = program.add_subcommand("diagnose", "Compares a case with recordings: where they differ, which physics was left out, and how much better it fits with it");
  command->add_option("CASE", words->file, "Case file (TOML): the experiment with the physics believed in; [diagnose] names what may be calibrated")->required();
  command->add_option("--recording", words->recordings, "CSV of what was recorded: docs/diagnose.md; may be repeated")->required();
  command->add_option("--out", words->directory, "Directory; default out/<case name>_diagnosis");
  command->add_option("--set", words->overrides, "key=value, laid over the case; may be repeated");
  command->add_option("--seed", words->options.seed, "Of the split into runs for fitting, choosing and checking, and of the bootstrap; default 1");
  command->add_option("--threads", words->options.threads, "Number of threads; results do not depend on it")->check(CLI::Range(1, 1024));
  command->add_flag("--no-pictures", words->no_pictures, "No report, tables only");
  command->add_flag("--quiet", words->options.quiet, "Nothing on the terminal");
  command->callback([words, &action] { action = [words] { return compare(*words); }; });
}

}  // namespace quern
