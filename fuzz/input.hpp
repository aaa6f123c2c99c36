// What the fuzzers share: bytes as a file that readers can be given, and which errors are answers.
#pragma once
#include <sys/mman.h>
#include <unistd.h>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include "src/base/error.hpp"

namespace quern {

// A file in memory that holds the bytes; one for the whole run of the fuzzer.
class Bytes {
 public:
  explicit Bytes(const char* name) : file_(memfd_create(name, 0)), path_("/proc/self/fd/" + std::to_string(file_)) {
    if (file_ < 0) std::abort();
  }
  const std::string& holding(std::string_view bytes) {
    if (ftruncate(file_, 0) != 0 || pwrite(file_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) std::abort();
    return path_;
  }

 private:
  int file_;
  std::string path_;
};

// Reads; a refusal in a sentence is an answer, everything else a finding.
template <class Read>
void try_to(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    const std::string_view sentence = error.what();
    if (sentence.empty() || sentence.size() > 4000) std::abort();
  }
}

// What a reader is begun with that only the program itself can write, so that it keeps its present form: into the folder that the variable
// QUERN_SEEDS names, where it is set.
inline void plant(const char* name, std::string_view bytes) {
  if (const char* folder = std::getenv("QUERN_SEEDS")) std::ofstream(std::string(folder) + "/" + name, std::ios::binary) << bytes;
}

inline std::string_view view(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

}  // namespace quern
