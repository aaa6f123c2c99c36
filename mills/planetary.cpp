#include "mills/planetary.hpp"
#include <cmath>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr double pi = 3.141592653589793;

void require(bool holds, const std::string& message) {
  if (!holds) throw InputError(message);
}

bool positive(double value) { return std::isfinite(value) && value > 0; }

double arm(const PlanetaryMill& mill) { return 0.5 * mill.disc_diameter; }

// From the disc's axis to a vial, at time 0.
Vec3 outward(const PlanetaryMill& mill, int vial) {
  const Vec3 axis = mill.axis.normalized();
  const Vec3 x = std::abs(axis.x()) < 0.9 ? (Vec3::UnitX() - axis.x() * axis).normalized() : (Vec3::UnitY() - axis.y() * axis).normalized();
  const double angle = 2 * pi * vial / mill.vials;
  return std::cos(angle) * x + std::sin(angle) * axis.cross(x);
}

}  // namespace

void check(const PlanetaryMill& mill) {
  require(positive(mill.disc_diameter), "The disc of a planetary mill must have a diameter above 0 m.");
  require(positive(mill.vial_diameter) && positive(mill.vial_length),
          "The vials of a planetary mill must have a diameter and a length above 0 m.");
  require(mill.vials >= 1, "A planetary mill must have at least one vial.");
  require(std::isfinite(mill.speed) && std::isfinite(mill.ratio), "The speed of a planetary mill and its ratio must be finite numbers.");
  require(std::isfinite(mill.ramp) && mill.ramp >= 0, "The ramp of a mill's speed must be 0 s or more.");
  require(mill.axis.allFinite() && mill.axis.norm() > 0 && mill.centre.allFinite(),
          "The axis and centre of a mill must be finite, and the axis not zero.");
  require(mill.tilt >= 0 && mill.tilt <= 0.5 * pi + 1e-9, "The vials of a planetary mill must be tilted by 0 to 90 degrees.");
  require(mill.tilt == 0 || mill.ratio_to == PlanetaryMill::RatioTo::disc,
          "Where the vials are tilted, their speed can be counted against the disc only, as their axes are not the disc's.");
  if (mill.vials == 1 || mill.vessel) return;
  // Half the extent of a vial across the spoke through its middle; a tilted one also reaches inward.
  const double across = 0.5 * mill.vial_diameter;
  const double inward = 0.5 * (mill.vial_diameter * std::cos(mill.tilt) + mill.vial_length * std::sin(mill.tilt));
  const double nearest = mill.tilt == 0 ? arm(mill) * std::sin(pi / mill.vials) : (arm(mill) - inward) * std::tan(pi / mill.vials);
  require((mill.vials == 2 ? arm(mill) > inward : nearest > across),
          "The vials of a planetary mill meet: make them smaller or the disc larger.");
}

Motion disc_motion(const PlanetaryMill& mill) { return turning(mill.centre, mill.axis.normalized(), mill.speed, mill.ramp); }

Motion vial_motion(const PlanetaryMill& mill, int vial) {
  const Pose pose = vial_pose(mill, vial);
  const double ratio = mill.ratio_to == PlanetaryMill::RatioTo::disc ? mill.ratio : mill.ratio - 1;
  return turning(pose.origin, pose.axes.col(2), ratio * mill.speed, mill.ramp);
}

std::string vial_name(int vial) { return "vial_" + std::to_string(vial + 1); }

std::vector<Frame> frames_of(const PlanetaryMill& mill) {
  check(mill);
  std::vector<Frame> frames = {
      {"disc", -1, mill.axes == PlanetaryMill::Axes::fixed ? disc_motion(mill) : Motion(Rotating{mill.centre, mill.axis.normalized(), 0})}};
  for (int k = 0; k < mill.vials; ++k) frames.push_back({vial_name(k), 0, vial_motion(mill, k)});
  return frames;
}

std::vector<Wall> walls_of(const PlanetaryMill& mill, Index first_frame) {
  check(mill);
  const double radius = 0.5 * mill.vial_diameter, end = 0.5 * mill.vial_length;
  std::vector<Wall> walls;
  for (int k = 0; k < mill.vials; ++k) {
    const auto add = [&](const char* part, Surface surface) {
      Wall wall;
      wall.name = vial_name(k) + "." + part;
      wall.material = mill.material;
      wall.surface = std::move(surface);
      wall.frame = first_frame + 1 + k;
      wall.rest = vial_pose(mill, k);
      wall.pose = wall.rest;
      walls.push_back(std::move(wall));
    };
    if (mill.vessel) {
      add("vessel", *mill.vessel);
      continue;
    }
    using Side = Revolved::Side;
    add("shell", Revolved{radius, -end, radius, end, Side::inside});
    add("end_0", Revolved{radius, -end, 0, -end, Side::inside});
    add("end_1", Revolved{0, end, radius, end, Side::inside});
  }
  return walls;
}

Pose vial_pose(const PlanetaryMill& mill, int vial) {
  const Vec3 out = outward(mill, vial), axis = mill.axis.normalized();
  Pose pose;
  pose.origin = mill.centre + arm(mill) * out;
  const Vec3 own = std::cos(mill.tilt) * axis + std::sin(mill.tilt) * out;
  pose.axes.col(2) = own;
  pose.axes.col(0) = std::cos(mill.tilt) * out - std::sin(mill.tilt) * axis;
  pose.axes.col(1) = own.cross(pose.axes.col(0));
  return pose;
}

Pose disc_pose(const PlanetaryMill& mill, double time) {
  if (mill.axes == PlanetaryMill::Axes::disc) return {};
  return poses_at({{"disc", -1, disc_motion(mill)}}, time)[0];
}

Region inside_of(const PlanetaryMill& mill, int vial) {
  check(mill);
  return {CylinderRegion{0.5 * mill.vial_diameter, -0.5 * mill.vial_length, 0.5 * mill.vial_length}, vial_pose(mill, vial)};
}

double volume(const PlanetaryMill& mill) { return 0.25 * pi * mill.vial_diameter * mill.vial_diameter * mill.vial_length; }

double absolute_ratio(const PlanetaryMill& mill) { return mill.ratio_to == PlanetaryMill::RatioTo::disc ? 1 + mill.ratio : mill.ratio; }

double critical_ratio(const PlanetaryMill& mill, double ball_diameter) {
  require(ball_diameter >= 0 && ball_diameter < mill.vial_diameter, "A critical ratio needs a ball smaller than the vial.");
  return std::sqrt(mill.disc_diameter / (mill.vial_diameter - ball_diameter));
}

}  // namespace quern
