// A part of space to be filled, in axes of its own.
#pragma once
#include <array>
#include <variant>
#include "src/base/domain.hpp"
#include "src/base/pose.hpp"
#include "src/base/random.hpp"

namespace quern {

struct CylinderRegion {
  double radius = 0, z_0 = 0, z_1 = 0;  // about its z axis [m]
};
struct BoxRegion {
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  // [m]
};
struct SphereRegion {
  double radius = 0;  // about its origin [m]
};
// Balls lie wholly inside, except where the region spans a periodic direction: there its two ends are one.
struct Region {
  std::variant<CylinderRegion, BoxRegion, SphereRegion> shape;
  Pose pose;
};

double volume(const Region& region);  // [m³]

// Throws InputError unless the region has a volume.
void check(const Region& region);

// Which of the region's own directions have no ends because they span a periodic direction.
std::array<bool, 3> joined_directions(const Region& region, const Domain& domain);

// The radius of the largest ball that fits [m].
double largest_radius(const Region& region, const std::array<bool, 3>& joined);

// A point evenly distributed over the places that a ball of this radius [m] can have; its middle if the ball is too large.
Vec3 random_place(const Region& region, const std::array<bool, 3>& joined, double radius, RandomStream& random);

// The nearest place to `centre` that a ball of this radius can have.
Vec3 nearest_place(const Region& region, const std::array<bool, 3>& joined, double radius, const Vec3& centre);

}  // namespace quern
