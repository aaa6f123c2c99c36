#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/whole_file.hpp"
#include "src/case/breakage_input.hpp"
#include "src/cli/commands.hpp"
#include "src/grinding/breakage.hpp"
#include "src/output/breakage_report.hpp"
#include "src/output/pictures.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct BreakageWords {
  BreakageRequest request;
  std::string directory;
  bool no_pictures = false;
};

int study(const BreakageWords& words) {
  const BreakageStudy study = read_breakage(words.request);
  const BreakageResult result = study_breakage(study);
  const fs::path source = fs::path(words.request.source).lexically_normal();
  const std::string name = (source.has_filename() ? source : source.parent_path()).stem().string();
  const fs::path directory = words.directory.empty() ? fs::path("out") / (name + "_breakage") : fs::path(words.directory);
  make_directory(directory.string());
  write_breakage(study, result, directory.string());
  for (const std::string& line : breakage_words(study, result)) fmt::print("{}\n", line);
  for (const std::string& remark : result.remarks) fmt::print("{}\n", remark);
  if (!words.no_pictures) {
    PictureRequest pictures;
    pictures.directory = directory.string();
    pictures.charts = breakage_charts(study, result, name);
    for (const std::string& remark : draw_pictures(pictures).remarks) fmt::print("{}\n", remark);
  }
  fmt::print("Tables, summary.json{} are in {}\n", words.no_pictures ? "" : " and a picture", directory.string());
  return 0;
}

}  // namespace

void add_breakage(CLI::App& program, Action& action) {
  auto words = std::make_shared<BreakageWords>();
  CLI::App* command = program.add_subcommand("breakage", "Fits damage, probability of breakage and t10 of bonded bodies against the specific energy of their impact");
  command->add_option("SOURCE", words->request.source, "Folder of a sweep over insert.<name>.speed and seed, or a CSV with specific_energy or speed and what became of the bodies")->required();
  command->add_option("--against", words->request.against, "Column of the speed or specific energy, where it cannot be told");
  command->add_option("--broken", words->request.broken_below, "A body is broken if its largest fragment has less than this part of its mass; default 0.9");
  command->add_option("--size", words->request.size, "Size of the bodies, \"100 mm\": gives f_mat and x W_min too");
  command->add_option("--out", words->directory, "Directory; default out/<name>_breakage");
  command->add_flag("--no-pictures", words->no_pictures, "Tables only");
  command->callback([words, &action] { action = [words] { return study(*words); }; });
}

}  // namespace quern
