// What the benchmark program is asked to do.
#pragma once
#include <cstdint>
#include <string>

namespace bench {

struct Options {
  std::string work = "drum";    // drum: rotating, periodic along its axis; bed: resting, periodic sideways; agglomerate: bonded, hits a wall
  std::int64_t balls = 10000;
  int threads = 1;
  std::int64_t steps = 1000;    // timed
  std::int64_t warm = 200;      // before the timed ones
  std::string isa;              // empty: the best of this processor
  std::int64_t mesh = 0;        // triangles of the drum's wall; 0: a cylinder
  double settle = 0.2;          // simulated before anything else, where the start is not read [s]
  std::int64_t copies = 1;      // the drum is settled with 1/copies of its balls, then set side by side along its axis
  std::int64_t sample = 0;      // steps between the readings of energy, contacts and torque; 0: none
  std::string start, write;     // LAMMPS data files to begin from and to leave behind
};

// Leaves the program where the words are wrong or help is asked for.
Options read_options(int argc, char** argv);

}  // namespace bench
