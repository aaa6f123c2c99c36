// Where a rigid body is and how it moves at one instant.
#pragma once
#include "src/base/vec.hpp"

namespace quern {

struct Pose {
  Vec3 origin = Vec3::Zero();            // of the body's own axes, in the fixed frame [m]
  Mat3 axes = Mat3::Identity();          // columns: the body's axes in the fixed frame
  Vec3 velocity = Vec3::Zero();          // of the origin [m/s]
  Vec3 angular_velocity = Vec3::Zero();  // [rad/s], fixed frame

  Vec3 to_fixed(const Vec3& local) const { return origin + axes * local; }
  Vec3 to_local(const Vec3& fixed) const { return axes.transpose() * (fixed - origin); }
  Vec3 velocity_at(const Vec3& fixed) const { return velocity + angular_velocity.cross(fixed - origin); }
};

// Some right-handed axes whose z is the given unit vector.
inline Mat3 axes_with_z(const Vec3& z) { return Rotation::FromTwoVectors(Vec3::UnitZ(), z).toRotationMatrix(); }

}  // namespace quern
