// mills — motion frames, and tumbling, planetary and stirred mills: geometry and kinematics from a few numbers.
//
// A frame moves in its parent; frames nest (fixed → rotates → translates …). Gravity stays in the fixed frame.
#pragma once
#include <string>
#include <variant>
#include <vector>
#include "src/base/pose.hpp"

namespace quern {

struct Rotating {
  Vec3 centre = Vec3::Zero();   // a point of the axis, in the parent [m]
  Vec3 axis = Vec3::UnitZ();    // unit, in the parent
  double speed = 0;             // [rad/s]
};

// Angular speed given at instants, linear between them and constant outside: a ramp has two instants.
struct RotatingByTable {
  Vec3 centre = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  std::vector<double> time;   // ascending [s]
  std::vector<double> speed;  // [rad/s]
};

struct Translating {
  Vec3 velocity = Vec3::Zero();  // in the parent [m/s]
  double ramp = 0;               // from rest to that velocity, evenly [s]
};

struct Oscillating {
  Vec3 amplitude = Vec3::Zero();  // [m]
  double frequency = 0;           // [Hz]
  double phase = 0;               // [rad]: displacement = amplitude sin(2π f t + phase) − amplitude sin(phase)
};

using Motion = std::variant<Rotating, RotatingByTable, Translating, Oscillating>;

// Turns at `speed` [rad/s] about the unit axis; from rest, linearly, within `ramp` [s] if that is not 0.
Motion turning(const Vec3& centre, const Vec3& axis, double speed, double ramp);

struct Frame {
  std::string name;
  Index parent = -1;  // −1: the fixed frame; parents come before their children
  Motion motion;
};

// Pose of each frame at time t [s] in the fixed frame, in the order of the list. Exact, not stepped: no drift.
std::vector<Pose> poses_at(const std::vector<Frame>& frames, double time);

// What a motion turns about and how, at time t [s]; for one that does not turn, angle and speed are zero.
struct Turn {
  Vec3 centre = Vec3::Zero();  // a point of the axis, in the parent [m]
  Vec3 axis = Vec3::UnitZ();   // unit, in the parent
  double angle = 0;            // since time 0 [rad]
  double speed = 0;            // [rad/s]
};
Turn turn_at(const Motion& motion, double time);

// A body whose pose in a frame is `rest`, seen from the fixed frame. Its own velocities in the frame, if any, are added.
Pose carried(const Pose& frame, const Pose& rest);

}  // namespace quern
