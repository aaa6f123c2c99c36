#include "src/output/claim.hpp"
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <cerrno>
#include "src/base/error.hpp"

namespace quern {

Claim::Claim(const std::string& directory) : descriptor_(open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  // File systems that know no locks claim nothing.
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError("Another run is writing into the directory " + directory + "; wait for it, or choose another directory with --out.");
}

Claim::~Claim() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace quern
