#include "src/output/whole_file.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"

namespace quern {

void make_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !std::filesystem::is_directory(path)) {
    throw InputError("The directory " + path + " cannot be made: " + (error ? error.message() : "there is a file of that name") + ".");
  }
}

std::string aside(const std::string& path) { return path + ".part"; }

void put_in_place(const std::string& path) {
  if (std::rename(aside(path).c_str(), path.c_str()) != 0) {
    throw RunError("The file " + path + " cannot be written: " + std::strerror(errno) + ".");
  }
}

void write_whole_file(const std::string& path, const std::string& contents) {
  std::ofstream file(aside(path), std::ios::binary | std::ios::trunc);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  file.close();
  if (!file) {
    const std::string reason = std::strerror(errno);
    std::remove(aside(path).c_str());
    throw RunError("The file " + path + " cannot be written: " + reason + ".");
  }
  put_in_place(path);
}

}  // namespace quern
