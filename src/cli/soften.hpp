// `quern check --soften`: the case as it is and with softer contacts, run one after the other and compared.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct SoftenWords {
  std::string file;
  std::vector<std::string> overrides;
  double factor = 10;
  int threads = 0;        // of each run; 0: as many as pay
  std::string directory;  // default out/<case name>_soften
};

// Returns the exit status.
int soften(const SoftenWords& words);

}  // namespace quern
