#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/error.hpp"
#include "src/base/say.hpp"
#include "src/cli/commands.hpp"
#include "src/output/run_report.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

int report(const std::string& directory) {
  const fs::path folder(directory);
  if (fs::exists(folder / "diagnosis.json")) {
    // What a comparison found stands in its own page, which needs the recordings.
    if (!fs::exists(folder / "report.html")) throw InputError(fmt::format("{}: this comparison wrote no page; `quern diagnose` without --no-pictures writes it.", directory));
    fmt::print("{}\n", (folder / "report.html").string());
    return 0;
  }
  const ReportWritten written = fs::exists(folder / "sweep.csv") ? write_sweep_report(directory) : write_run_report(directory, true);
  for (const std::string& file : written.files) fmt::print("{}\n", (folder / file).string());
  for (const std::string& remark : written.remarks) say(remark + "\n");
  return 0;
}

}  // namespace

void add_report(CLI::App& program, Action& action) {
  auto directory = std::make_shared<std::string>();
  CLI::App* command = program.add_subcommand("report", "Makes report.html, one page whole in itself, and pictures from the directory of a run or sweep");
  command->add_option("DIR", *directory, "Directory of a run, also of one that goes on or was killed; of a sweep; of a comparison")->required();
  command->callback([directory, &action] { action = [directory] { return report(*directory); }; });
}

}  // namespace quern
