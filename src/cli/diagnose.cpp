#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/machine_runs.hpp"
#include "src/diagnose/finding_written.hpp"
#include "src/diagnose/machine/machine_written.hpp"
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

std::string directory_of(const DiagnoseWords& words) {
  const fs::path folder = fs::absolute(words.file).lexically_normal();
  const std::string name = folder.stem() == "case" ? folder.parent_path().filename().string() : folder.stem().string();
  return words.directory.empty() ? "out/" + name + "_diagnosis" : words.directory;
}

void tell(const DiagnoseWords& words, const Finding& finding, const std::vector<std::string>& remarks, const std::vector<std::string>& skipped, const std::string& directory) {
  if (words.options.quiet) return;
  for (const std::string& remark : remarks) fmt::print("{}\n", remark);
  for (const std::string& line : diagnosis_words(finding)) fmt::print("{}\n", line);
  for (const std::string& line : skipped) fmt::print("{}\n", line);
  fmt::print("{}diagnosis.json, amended.toml, residuals.csv and fits.csv are in {}\n", words.no_pictures ? "" : "report.html, ", directory);
}

// Of a machine or of breakage, whose runs take processes of their own.
int compare_machine(const DiagnoseWords& words, const Values& values) {
  for (const std::string& file : words.recordings)
    if (!is_machine_recording(file)) throw InputError(fmt::format("{}: this is a recording of a body or a contact, and {} one of a machine; allowed are files of one kind.", file, words.recordings.front()));
  const MachineRecording recording = read_machine_recordings(words.recordings);
  const MachineExperiment experiment(values, recording);
  const std::string directory = directory_of(words);
  make_directory(directory);
  const CaseRunner runner = run_cases_in(directory + "/runs", words.options.threads, words.options.quiet);
  try {
    const MachineDiagnosis diagnosis = diagnose_machine(experiment, runner, words.options);
    write_machine_diagnosis(experiment, diagnosis, directory);
    std::vector<std::string> skipped;
    if (!words.no_pictures) skipped = write_machine_report(experiment, diagnosis, directory);
    tell(words, diagnosis, experiment.remarks(), skipped, directory);
  } catch (const Stopped& stopped) {
    if (!words.options.quiet) fmt::print("Stopped; the runs that finished are kept in {}, and the same command goes on from there.\n", directory + "/runs");
    return 128 + stopped.signal;
  }
  return 0;
}

int compare(const DiagnoseWords& words) {
  const Values values = read_values(words.file, words.overrides);
  if (is_machine_recording(words.recordings.front())) return compare_machine(words, values);
  const Recording recording = read_recordings(words.recordings);
  const Experiment experiment(values, recording);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  ThreadTeam team(words.options.threads > 0 ? words.options.threads : cores);
  const Diagnosis diagnosis = diagnose(experiment, team, words.options);
  const std::string directory = directory_of(words);
  make_directory(directory);
  write_diagnosis(experiment, diagnosis, directory);
  std::vector<std::string> skipped;
  if (!words.no_pictures) skipped = write_report(experiment, diagnosis, team, directory);
  tell(words, diagnosis, recording.remarks, skipped, directory);
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
