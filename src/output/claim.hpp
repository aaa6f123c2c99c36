// The right to write into a directory: one run at a time.
#pragma once
#include <string>

namespace quern {

class Claim {
 public:
  // Throws InputError where another run has it. Given back when this goes, however the process ends.
  explicit Claim(const std::string& directory);
  ~Claim();
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  int descriptor_;
};

}  // namespace quern
