#include "bench/state.hpp"
#include <fmt/format.h>
#include <cstdio>
#include <fstream>
#include <sstream>
#include "src/base/error.hpp"

namespace bench {

State read_state(const std::string& path) {
  std::ifstream file(path);
  State state;
  std::string line;
  enum { header, atoms, velocities } part = header;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::size_t id = 0;
    int type = 0;
    if (line.rfind("Atoms", 0) == 0) {
      part = atoms;
    } else if (line.rfind("Velocities", 0) == 0) {
      part = velocities;
    } else if (part == header) {
      std::size_t count = 0;
      if (line.find(" atoms") != std::string::npos && words >> count) state.balls.resize(count);
      for (int axis = 0; axis < 3; ++axis)
        if (line.find(fmt::format("{0}lo {0}hi", "xyz"[axis])) != std::string::npos) words >> state.lower[axis] >> state.upper[axis];
    } else if (part == atoms && words >> id >> type >> state.diameter >> state.density && id >= 1 && id <= state.balls.size()) {
      quern::Vec3& x = state.balls[id - 1].position;
      words >> x.x() >> x.y() >> x.z();
    } else if (part == velocities && words >> id && id >= 1 && id <= state.balls.size()) {
      quern::Vec3 &v = state.balls[id - 1].velocity, &w = state.balls[id - 1].spin;
      words >> v.x() >> v.y() >> v.z() >> w.x() >> w.y() >> w.z();
    }
  }
  if (state.balls.empty() || !(state.diameter > 0)) throw quern::InputError(fmt::format("{}: no data file of spheres", path));
  return state;
}

void write_state(const State& state, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (!file) throw quern::InputError(fmt::format("{}: cannot be written", path));
  fmt::print(file, "balls for the benchmarks of quern\n\n{} atoms\n1 atom types\n\n", state.balls.size());
  for (int axis = 0; axis < 3; ++axis) fmt::print(file, "{:.17g} {:.17g} {}lo {}hi\n", state.lower[axis], state.upper[axis], "xyz"[axis], "xyz"[axis]);
  fmt::print(file, "\nAtoms\n\n");
  for (std::size_t k = 0; k < state.balls.size(); ++k) {
    const quern::Vec3& x = state.balls[k].position;
    fmt::print(file, "{} 1 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", k + 1, state.diameter, state.density, x.x(), x.y(), x.z());
  }
  fmt::print(file, "\nVelocities\n\n");
  for (std::size_t k = 0; k < state.balls.size(); ++k) {
    const quern::Vec3 &v = state.balls[k].velocity, &w = state.balls[k].spin;
    fmt::print(file, "{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", k + 1, v.x(), v.y(), v.z(), w.x(), w.y(), w.z());
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) throw quern::InputError(fmt::format("{}: could not be written whole", path));
}

}  // namespace bench
