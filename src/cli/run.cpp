#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <algorithm>
#include <csignal>
#include <memory>
#include "src/base/say.hpp"
#include "src/case/build.hpp"
#include "src/case/mill_headlines.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/stop_signal.hpp"
#include "src/observe/observers.hpp"
#include "src/output/run.hpp"
#include "src/output/run_plan.hpp"
#include "src/output/run_report.hpp"

namespace quern {
namespace {

struct RunWords {
  std::string file, directory;
  std::vector<std::string> overrides;
  int threads = 0;
  bool resume = false, quiet = false, no_report = false;
  double checkpoint = 300;
};

// A run does not fail for its report.
void add_report(const std::string& directory, RunSummary& summary) {
  try {
    const ReportWritten report = write_run_report(directory);
    summary.files.insert(summary.files.end(), report.files.begin(), report.files.end());
    summary.remarks.insert(summary.remarks.end(), report.remarks.begin(), report.remarks.end());
  } catch (const std::exception& error) {
    summary.remarks.push_back(std::string("The report is left out: ") + error.what());
  }
}

int run(const RunWords& words) {
  leave_on_stop_signals();
  std::signal(SIGPIPE, SIG_IGN);  // `quern run … | head`: whoever stops reading does not stop the run
  const Case c = read_case(words.file, words.overrides);
  Built built = build_case(c);
  for (const std::string& warning : built.warnings) say("Warning: " + warning + "\n");

  Simulation& simulation = built.simulation;
  const int threads = words.threads > 0 ? words.threads : useful_threads(simulation.particles.owned);
  simulation.team = std::make_shared<ThreadTeam>(threads);
  Observers observers(built.observe);
  simulation.start(observers.needs_collisions());

  OutputSettings settings;
  settings.name = c.name;
  settings.title = c.title;
  settings.case_text = c.text;
  settings.case_files = c.files;
  settings.frame_interval = c.output.frames;
  settings.energy_interval = c.output.energy;
  settings.vtk_frames = c.output.paraview;
  settings.trajectory = c.output.trajectory;
  settings.pictures = c.output.pictures;
  settings.stages = c.output.stages;
  if (c.mill) settings.view_axis = c.mill->axis;
  if (c.stirred) {
    // Along the axis of a mill that lies, from the side onto one that stands.
    const Vec3 axis = c.stirred->axis.normalized();
    settings.view_axis = axis.cross(c.gravity).norm() > 0.5 * c.gravity.norm() ? axis : pose_of(*c.stirred).axes.col(1).eval();
  }
  if (c.planetary) settings.view_axis = vial_pose(*c.planetary, 0).axes.col(2);
  settings.headlines = mill_headlines(c, built);

  RunOptions options;
  options.directory = words.directory.empty() ? "out/" + c.name : words.directory;
  options.threads = threads;
  options.resume = words.resume;
  options.checkpoint_interval = words.checkpoint;
  options.quiet = words.quiet;
  options.stop_signal = watch_stop_signals();
  RunSummary summary = run_simulation(simulation, observers, settings, options, c.duration);
  if (c.output.pictures && !words.no_report) add_report(options.directory, summary);

  if (!words.quiet) {
    for (const std::string& file : summary.files)
      if (file.ends_with(".png") || file.ends_with(".html")) say(fmt::format("{}/{}\n", options.directory, file), stdout);
    for (const Headline& h : summary.headlines) {
      const std::string unit = h.unit == "1" ? "" : " " + h.unit;
      const std::string interval = h.ci95 ? fmt::format("  ({:.4g} … {:.4g})", (*h.ci95)[0], (*h.ci95)[1]) : "";
      say(fmt::format("{:28} {:.5g}{}{}\n", h.key, h.value, unit, interval), stdout);
    }
  }
  for (const std::string& remark : summary.remarks) say(remark + "\n");
  if (!words.quiet) say("Results are in " + options.directory + "\n", stdout);
  return summary.finished ? 0 : 128 + summary.stopped_by;
}

}  // namespace

void add_run(CLI::App& program, Action& action) {
  auto words = std::make_shared<RunWords>();
  CLI::App* command = program.add_subcommand("run", "Runs a case and writes its results");
  command->add_option("CASE", words->file, "Case file (TOML)")->required();
  command->add_option("--out", words->directory, "Directory of the results; default out/<case name>");
  command->add_option("--threads", words->threads, "Number of threads; default: as many as pay. Results do not depend on it")
      ->check(CLI::Range(1, 1024));
  command->add_option("--set", words->overrides, "key=value, laid over the case; may be repeated");
  command->add_option("--checkpoint", words->checkpoint, "Seconds of wall clock between checkpoints; default 300")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--resume", words->resume, "Go on from the checkpoint in the directory");
  command->add_flag("--no-report", words->no_report, "No report.html; `quern report` makes it later");
  command->add_flag("--quiet", words->quiet, "No progress, no summary on the terminal");
  command->callback([words, &action] { action = [words] { return run(*words); }; });
}

}  // namespace quern
