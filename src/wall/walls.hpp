// The walls of a simulation, each a surface on a pose, and their contact with the particles of a block.
#pragma once
#include <string>
#include <variant>
#include "src/base/pose.hpp"
#include "src/contact/kernels.hpp"
#include "src/wall/mesh.hpp"

namespace quern {

using Surface = std::variant<Plane, Revolved, Mesh>;

struct Wall {
  std::string name;
  std::uint8_t material = 0;
  Surface surface;
  Index frame = -1;      // of the motion frames; −1: fixed
  Pose rest;             // where it stands in its frame
  Pose pose;             // where it is now, in the fixed frame
  Triple<double> force{};   // of the particles on it, at the last step [N]
  Triple<double> torque{};  // about pose.origin [N m]
};

// The touch of a sphere with a wall's surface, in the fixed frame; meshes search their whole tree. Touches beyond `radius` are
// not reported. At most most_touches. For setting up and packing, not for the step.
int touch_wall(const Wall& wall, const Vec3& centre, double radius, Touch* touches);

// How fast the wall's surface may come nearer to a point of space: motion along the surface itself does not count [m/s].
double closing_speed(const Wall& wall, double domain_size);

// Fills block.wall_candidates with the particles of the block nearer to a wall than `skin` [m] beyond their radius. Touches that
// exist keep their memory.
void find_wall_candidates(const std::vector<Wall>& walls, const Particles& particles, double skin, ContactBlock& block);

// Fills block.wall_touches and block.walls (by pair kind) with this step's touches; new ones get a slot, parted ones end.
void find_wall_touches(const StepContext& step, const std::vector<Wall>& walls, ContactBlock& block);

}  // namespace quern
