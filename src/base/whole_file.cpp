#include "src/base/whole_file.hpp"
#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include "src/base/error.hpp"

namespace quern {
namespace {

bool write_all(int file, std::string_view piece) {
  while (!piece.empty()) {
    const ssize_t written = ::write(file, piece.data(), piece.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return false;
    piece.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// A rename itself must survive a power cut: what is synced is the directory.
void sync_directory_of(const std::string& path) {
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  const int directory = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);
  ::close(directory);
}

}  // namespace

void make_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  std::error_code unseen;
  if (!std::filesystem::is_directory(path, unseen)) {
    throw InputError("The directory " + path + " cannot be made: " + (error ? error.message() : "there is a file of that name") + ".");
  }
  if (::access(path.c_str(), W_OK | X_OK) != 0) {
    throw InputError("The directory " + path + " cannot be written into: " + std::strerror(errno) + ".");
  }
}

void write_whole_file(const std::string& path, std::initializer_list<std::string_view> pieces, Synced synced) {
  const std::string aside = path + ".part";
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  bool good = file >= 0;
  for (const std::string_view piece : pieces) good = good && write_all(file, piece);
  if (synced == Synced::yes) good = good && ::fsync(file) == 0;
  int error = errno;
  if (file >= 0 && ::close(file) != 0 && good) good = false, error = errno;
  if (good && std::rename(aside.c_str(), path.c_str()) != 0) good = false, error = errno;
  if (!good) {
    if (file >= 0) ::unlink(aside.c_str());
    throw WriteError("The file " + path + " cannot be written: " + std::strerror(error) + ".");
  }
  if (synced == Synced::yes) sync_directory_of(path);
}

void rename_file(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0)
    throw WriteError("The file " + from + " cannot be renamed " + to + ": " + std::strerror(errno) + ".");
  sync_directory_of(to);
}

}  // namespace quern
