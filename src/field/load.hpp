// What a field does to one particle.
#pragma once
#include "src/base/vec.hpp"

namespace quern {

struct FieldLoad {
  Vec3 force, torque;  // [N], [N m]
};

}  // namespace quern
