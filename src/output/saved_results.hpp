// What a run wrote, read back from its directory.
#pragma once
#include <optional>
#include <string>
#include <vector>
#include "src/base/vec.hpp"
#include "src/observe/table.hpp"

namespace quern {

// Of the complete case, as far as a report needs it.
struct SavedCase {
  std::string name, title, text;
  double duration = 0;               // [s]
  Vec3 gravity{0, 0, -9.81};         // [m/s²]
  Vec3 axis = Vec3::Zero();          // of the mill; zero: there is none
};

struct SavedRun {
  SavedCase of;
  bool ended = false;                // it wrote its tables; false: it goes on, or was killed
  bool stopped = false;              // it left a checkpoint to go on from
  double time = 0;                   // reached [s]; 0 where that is not known
  std::vector<Headline> headlines;   // in the order of summary.json
};

// Throws InputError where the directory holds no run.
SavedRun read_run(const std::string& directory);

// The table of that name; none where there is no such file or it is empty.
std::optional<Table> read_table(const std::string& directory, const std::string& name);

// Of a file as json_of wrote it; empty where there is none.
std::vector<Headline> read_headlines(const std::string& file);

}  // namespace quern
