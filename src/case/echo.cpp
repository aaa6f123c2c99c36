#include "src/case/echo.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <boost/crc.hpp>
#include <cctype>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/case/reading.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

// A number that follows from what a file holds; of one that cannot be read, which its reader will tell, nothing's.
std::uint32_t checksum_of(const std::string& file) {
  boost::crc_32_type crc;
  std::ifstream stream(file, std::ios::binary);
  char piece[1 << 16];
  while (stream.read(piece, sizeof piece) || stream.gcount() > 0) crc.process_bytes(piece, static_cast<std::size_t>(stream.gcount()));
  return crc.checksum();
}

std::string plain(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return name;
}

}  // namespace

std::string echo_of(Values values, std::vector<NamedFile>& files) {
  std::vector<std::pair<Path, std::string>> copies;
  for (const auto& [path, value] : values.given) {
    if (value.key->kind != KeyKind::file) continue;
    const std::string from = beside(values, join_path(path));
    const std::string name = fmt::format("files/{}_{:08x}{}", plain(fs::path(from).stem().string()), checksum_of(from), plain(fs::path(from).extension().string()));
    if (std::none_of(files.begin(), files.end(), [&](const NamedFile& file) { return file.name == name; })) files.push_back({from, name});
    copies.emplace_back(path, name);
  }
  for (auto& [path, name] : copies) values.given[path].data = name;
  return complete_case(values);
}

void copy_files(const std::vector<NamedFile>& files, const std::string& directory) {
  for (const NamedFile& file : files) {
    const fs::path to = fs::path(directory) / file.name;
    std::error_code problem;
    fs::create_directories(to.parent_path(), problem);
    if (fs::equivalent(file.from, to, problem)) continue;  // an echo that is run where it stands
    problem.clear();
    fs::copy_file(file.from, to, fs::copy_options::overwrite_existing, problem);
    if (problem) throw WriteError(fmt::format("The file {} cannot be copied to {}: {}.", file.from, to.string(), problem.message()));
  }
}

std::string write_echo(const std::string& file, const std::string& heading, const Values& values) {
  std::vector<NamedFile> files;
  std::string text = heading + echo_of(values, files);
  copy_files(files, fs::path(file).parent_path().string());
  write_whole_file(file, text);
  return text;
}

}  // namespace quern
