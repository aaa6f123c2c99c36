#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <thread>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/base/whole_file.hpp"
#include "src/calibrate/bonds.hpp"
#include "src/cli/commands.hpp"
#include "src/output/tables.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct CalibrateWords {
  std::string file, agglomerate, young, poisson, tensile, compressive, directory;
  std::vector<std::string> overrides;
  std::int64_t grains = 400;
  int specimens = 3, threads = 0;
  bool no_sizes = false;
};

double positive(const Units& units, const char* option, const std::string& text, const char* unit) {
  try {
    const double value = units.read(text, unit);
    if (!(value > 0)) throw InputError(fmt::format("found \"{}\"; allowed is more than 0 {}", text, unit));
    return value;
  } catch (const InputError& e) {
    throw InputError(fmt::format("quern calibrate bonds, {}: {}.", option, e.what()));
  }
}

std::size_t chosen_agglomerate(const Case& c, const std::string& name) {
  std::string known;
  for (std::size_t k = 0; k < c.agglomerates.size(); ++k) {
    if (c.agglomerates[k].name == name || (name.empty() && c.agglomerates.size() == 1)) return k;
    known += (k == 0 ? "" : ", ") + c.agglomerates[k].name;
  }
  if (known.empty()) throw InputError(fmt::format("{}: found no [agglomerate.…]; quern calibrate bonds needs one, whose grains make the specimens.", c.file));
  throw InputError(fmt::format("quern calibrate bonds, --agglomerate: found \"{}\"; allowed is one of {} of {}.", name, known, c.file));
}

int calibrate(const CalibrateWords& words) {
  const Units units;
  BondRequest request;
  BondTargets& targets = request.targets;
  targets.young = positive(units, "--young", words.young, "Pa");
  if (!words.poisson.empty()) {
    targets.poisson = positive(units, "--poisson", words.poisson, "1");
    if (*targets.poisson >= 0.5) throw InputError(fmt::format("quern calibrate bonds, --poisson: found {}; allowed is more than 0 and less than 0.5.", *targets.poisson));
  }
  if (!words.tensile.empty()) targets.tensile = positive(units, "--tensile-strength", words.tensile, "Pa");
  if (!words.compressive.empty()) targets.compressive = positive(units, "--compressive-strength", words.compressive, "Pa");
  if (words.grains < 100 || words.grains > 100000) throw InputError(fmt::format("quern calibrate bonds, --grains: found {}; allowed are 100 to 100000.", words.grains));
  if (words.specimens < 1 || words.specimens > 100) throw InputError(fmt::format("quern calibrate bonds, --specimens: found {}; allowed are 1 to 100.", words.specimens));
  const Case c = read_case(words.file, words.overrides);
  request.agglomerate = chosen_agglomerate(c, words.agglomerate);
  request.grains = words.grains, request.specimens = words.specimens, request.sizes = !words.no_sizes;
  request.threads = words.threads > 0 ? words.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));

  const BondCalibration calibration = calibrate_bonds(c, request);
  const fs::path directory = words.directory.empty() ? fs::path("out") / (c.name + "_bonds") : fs::path(words.directory);
  make_directory(directory.string());
  for (const Table& table : calibration_tables(calibration)) write_whole_file((directory / (table.name + ".csv")).string(), csv_of(table));
  write_whole_file((directory / "summary.json").string(), json_of(calibration_headlines(calibration, targets)));
  write_whole_file((directory / "bonds.toml").string(), bond_tables(calibration));
  for (const std::string& line : calibration_words(calibration, targets)) fmt::print("{}\n", line);
  for (const std::string& remark : calibration.remarks) fmt::print("{}\n", remark);
  fmt::print("\n{}\nThese keys (bonds.toml), tables and summary.json are in {}\n", bond_tables(calibration), directory.string());
  return 0;
}

}  // namespace

void add_calibrate(CLI::App& program, Action& action) {
  auto words = std::make_shared<CalibrateWords>();
  CLI::App* group = program.add_subcommand("calibrate", "Finds parameters of a case from what was measured");
  group->require_subcommand(1);
  CLI::App* command = group->add_subcommand("bonds", "Stiffness and strength of bonds from Young's modulus, Poisson's ratio and strength of a specimen, by pulling and pressing small ones");
  command->add_option("CASE", words->file, "Case with [bond.…] and an agglomerate: grains, bonds to begin with, contacts")->required();
  command->add_option("--young", words->young, "Young's modulus of the specimen, \"20 GPa\"")->required();
  command->add_option("--poisson", words->poisson, "Its Poisson's ratio; default: stiffness_ratio stays as it is");
  command->add_option("--tensile-strength", words->tensile, "Its strength in direct tension, \"5 MPa\"");
  command->add_option("--compressive-strength", words->compressive, "Its strength in uniaxial compression");
  command->add_option("--agglomerate", words->agglomerate, "Which of the case's agglomerates; may be left out if there is one");
  command->add_option("--grains", words->grains, "Grains of a specimen")->capture_default_str();
  command->add_option("--specimens", words->specimens, "Specimens whose mean counts")->capture_default_str();
  command->add_flag("--no-sizes", words->no_sizes, "Do not repeat at half and twice the grains");
  command->add_option("--threads", words->threads, "Default: as many as the machine has cores");
  command->add_option("--out", words->directory, "Directory; default out/<case name>_bonds");
  command->add_option("--set", words->overrides, "key=value laid over the case; may be repeated");
  command->callback([words, &action] { action = [words] { return calibrate(*words); }; });
}

}  // namespace quern
