// The frames for ParaView, read back.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include "src/base/vec.hpp"

namespace quern {

// Files of one instant, in the directory of the run; "": none.
struct SavedFrame {
  double time = 0;  // [s]
  std::string balls, walls, bonds, shapes;
};

// Of frames.pvd in a directory; empty where there is none.
std::vector<SavedFrame> saved_frames(const std::string& directory);

struct SavedBall {
  Vec3 position;                 // [m]
  double diameter = 0;           // [m]
  double speed = 0;              // [m/s]
  int id = 0, species = 0;
  int fragment = -1;             // by mass; −1: none
  int shape = 0;                 // 0: a sphere
  std::array<double, 4> turn{1, 0, 0, 0};  // w, x, y, z
};

struct SavedBalls {
  std::vector<SavedBall> list;
  std::vector<std::string> species;  // names
  bool fragments = false, shapes = false;
};

// Points and triangles: of one wall, or of one particle.
struct SavedSurface {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;  // three each
};

struct SavedBond {
  int number = 0, first = 0, second = 0;  // the bond, and the ids of its grains
};

// Each throws RunError where the file is torn or missing.
SavedBalls read_balls(const std::string& path);
std::vector<SavedSurface> read_walls(const std::string& path);
std::vector<SavedBond> read_bonds(const std::string& path);
// The surface of the particle of that id.
SavedSurface read_shape(const std::string& path, int id);

}  // namespace quern
