#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <filesystem>
#include <memory>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/cli/commands.hpp"
#include "src/convert/converted.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

struct ConvertWords {
  std::vector<std::string> files;
  std::string directory;
};

int convert(const ConvertWords& words) {
  const fs::path first(words.files.front());
  const bool tables = std::all_of(words.files.begin(), words.files.end(), [](const std::string& file) { return fs::path(file).extension() == ".csv"; });
  if (!tables && words.files.size() > 1) throw InputError(fmt::format("{}: found {} files; allowed is one input script, or several CSV tables.", words.files[1], words.files.size()));
  const Converted made = tables ? convert_materials(words.files) : convert_liggghts(words.files.front());
  const fs::path directory = words.directory.empty() ? fs::path("out") / (first.stem().string() + "_converted") : fs::path(words.directory);
  make_directory(directory.string());
  const fs::path file = directory / (tables ? "materials.toml" : "case.toml");
  std::vector<std::string> missing;
  for (const std::string& mesh : made.meshes) {
    const fs::path from = fs::path(mesh).is_absolute() ? fs::path(mesh) : first.parent_path() / mesh;
    std::error_code problem;
    fs::copy_file(from, directory / from.filename(), fs::copy_options::overwrite_existing, problem);
    if (problem) missing.push_back(fmt::format("{}: it cannot be copied ({}); the case needs it beside it.", from.string(), problem.message()));
  }
  write_whole_file(file.string(), made.text);
  fmt::print("Written: {}\n", file.string());
  const std::size_t left_out = made.left_out.size() + missing.size();
  if (left_out > 0) fmt::print("Left out, or to be looked at:\n");
  for (const auto& list : {made.left_out, missing})
    for (const std::string& one : list) fmt::print("  {}\n", one);
  return 0;
}

}  // namespace

void add_convert(CLI::App& program, Action& action) {
  auto words = std::make_shared<ConvertWords>();
  CLI::App* command = program.add_subcommand("convert", "An input script of LIGGGHTS to a case, or tables of materials (CSV, as EDEM shows them) to those of a case; says what it left out");
  command->add_option("FILE", words->files, "Input script of LIGGGHTS, or CSV tables: docs/converting.md")->required();
  command->add_option("--out", words->directory, "Directory; default out/<name>_converted");
  command->callback([words, &action] { action = [words] { return convert(*words); }; });
}

}  // namespace quern
