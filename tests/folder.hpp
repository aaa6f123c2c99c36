// A directory of one test case, gone when it ends.
#pragma once
#include <sys/wait.h>
#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include "tests/places.hpp"

namespace quern {

struct Folder {
  std::filesystem::path path;
  explicit Folder(const std::string& name) : path(std::filesystem::temp_directory_path() / ("quern_" + name + "_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(path), std::filesystem::create_directories(path);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((path / file).parent_path());
    std::ofstream(path / file) << text;
    return (path / file).string();
  }
  std::string read(const std::string& file) const {
    std::ifstream stream(path / file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
};

// Runs `quern` with these arguments; its words go to the file `log`. Returns its exit status, −1 where it did not end by itself.
inline int run_quern(const std::string& arguments, const std::filesystem::path& log) {
  const std::string command = std::string("'") + quern::program + "' " + arguments + " > '" + log.string() + "' 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace quern
