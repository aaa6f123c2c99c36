// What a field does to one particle.
#pragma once
#include <numbers>
#include "src/base/vec.hpp"

namespace quern {

struct FieldLoad {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // [N], [N m]
};

inline double ball_volume(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }

}  // namespace quern
