#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/whole_file.hpp"
#include "src/case/grinding_input.hpp"
#include "src/cli/commands.hpp"
#include "src/grinding/study.hpp"
#include "src/output/grinding_report.hpp"
#include "src/output/pictures.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct GrindingWords {
  GrindingRequest request;
  std::string directory;
  bool no_pictures = false;
};

int grind(const GrindingWords& words) {
  const GrindingStudy study = read_grinding(words.request);
  const GrindingResult result = study_grinding(study);
  const fs::path source = fs::path(words.request.file).lexically_normal();
  const std::string name = (source.has_filename() ? source : source.parent_path()).stem().string();
  const fs::path directory = words.directory.empty() ? fs::path("out") / (name + "_grinding") : fs::path(words.directory);
  make_directory(directory.string());
  write_grinding(study, result, directory.string());
  for (const std::string& line : grinding_words(study, result)) fmt::print("{}\n", line);
  for (const std::string& remark : result.remarks) fmt::print("{}\n", remark);
  if (!words.no_pictures) {
    PictureRequest pictures;
    pictures.directory = directory.string();
    pictures.charts = grinding_charts(study, result, name);
    for (const std::string& remark : draw_pictures(pictures).remarks) fmt::print("{}\n", remark);
  }
  fmt::print("Tables, summary.json{} are in {}\n", words.no_pictures ? "" : " and pictures", directory.string());
  return 0;
}

}  // namespace

void add_grinding(CLI::App& program, Action& action) {
  auto words = std::make_shared<GrindingWords>();
  CLI::App* command = program.add_subcommand("grinding", "Fits first-order kinetics to sizes against time, and the rate against the impact energy: K_p = a E_i^b");
  command->add_option("FILE", words->request.file, "CSV with t and D80, D50, … (or size and percent), run, and what was set; or the folder of a sweep of mills with bonded bodies")->required();
  command->add_option("--sweep", words->request.sweep, "Folder of a sweep of the same operating points: takes E_i from its sweep.csv");
  command->add_option("--against", words->request.against, "Column (of the sweep, with --sweep) that the rate is held against; default E_i, or the only further one");
  command->add_option("--limit", words->request.limits, "Known size in the end, \"20 um\" or \"D80=20 um\"; may be repeated; default: the column D80_limit, or fitted");
  command->add_option("--until", words->request.until, "Last time that counts, \"60 s\"");
  command->add_option("--out", words->directory, "Directory; default out/<file name>_grinding");
  command->add_flag("--no-pictures", words->no_pictures, "Tables only");
  command->callback([words, &action] { action = [words] { return grind(*words); }; });
}

}  // namespace quern
