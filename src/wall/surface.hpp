// src/wall — planes, cylinders, cones, discs, triangle meshes, and where a sphere touches them. Not which machine they belong to.
#pragma once
#include "src/base/vec.hpp"

namespace quern {

// One point where a sphere touches a surface.
struct Touch {
  Vec3 point;       // on the surface [m]
  Vec3 normal;      // unit, into the sphere
  double distance;  // from the sphere's centre to the surface along the normal; negative behind a one-sided surface [m]
};

// All of z ≤ 0 in the wall's own axes is solid; the surface is z = 0.
struct Plane {
  Touch touch(const Vec3& centre) const { return {{centre.x(), centre.y(), 0}, Vec3::UnitZ(), centre.z()}; }
};

// The segment from (radius_0, z_0) to (radius_1, z_1) turned about the wall's own z axis: a cylinder's jacket
// (radius_0 = radius_1), a cone, a disc or ring (z_0 = z_1).
struct Revolved {
  // Which side is free: `inside` pushes towards the axis (a drum), `outside` away from it (a shaft); `both` is a thin sheet.
  enum class Side { inside, outside, both };
  double radius_0 = 0, z_0 = 0, radius_1 = 0, z_1 = 0;  // [m]
  Side side = Side::both;

  // The closest point of the surface to a centre given in the wall's own axes.
  Touch touch(const Vec3& centre) const {
    const double rho = std::sqrt(centre.x() * centre.x() + centre.y() * centre.y());
    const Vec3 radial = rho > 1e-150 ? Vec3(centre.x() / rho, centre.y() / rho, 0) : Vec3::UnitX().eval();
    const double along_rho = radius_1 - radius_0, along_z = z_1 - z_0;
    const double length_squared = along_rho * along_rho + along_z * along_z;
    const double s = ((rho - radius_0) * along_rho + (centre.z() - z_0) * along_z) / length_squared;
    const double at = s < 0 ? 0 : s > 1 ? 1 : s;
    const double from_rho = rho - (radius_0 + at * along_rho), from_z = centre.z() - (z_0 + at * along_z);
    const Vec3 offset = from_rho * radial + from_z * Vec3::UnitZ();
    if (side != Side::both && at == s) {
      // The normal of the segment that looks to the free side: towards the axis for `inside`.
      const double length = std::sqrt(length_squared), sign = (along_z > 0) == (side == Side::inside) ? -1 : 1;
      const Vec3 normal = sign * (along_z / length * radial - along_rho / length * Vec3::UnitZ());
      const double distance = offset.dot(normal);
      return {centre - distance * normal, normal, distance};
    }
    const double distance = offset.norm();
    if (distance < 1e-300) return {centre, Vec3::UnitZ(), 0};
    return {centre - offset, offset / distance, distance};
  }
};

}  // namespace quern
