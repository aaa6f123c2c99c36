// Where balls are and how they move, as a LAMMPS data file (atom style sphere): the common start of all codes.
#pragma once
#include <string>
#include <vector>
#include "src/base/vec.hpp"

namespace bench {

struct Ball {
  quern::Vec3 position, velocity, spin;  // [m], [m/s], [rad/s]
};

struct State {
  double diameter = 0, density = 0;          // of every ball [m], [kg/m³]
  quern::Vec3 lower = quern::Vec3::Zero();   // of the box [m]
  quern::Vec3 upper = quern::Vec3::Zero();
  std::vector<Ball> balls;
};

// Throw quern::InputError if the file cannot be read or written.
State read_state(const std::string& path);
void write_state(const State& state, const std::string& path);

}  // namespace bench
