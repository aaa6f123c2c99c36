#include "mills/tumbling.hpp"
#include <cmath>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr double pi = 3.141592653589793;
constexpr int crown_facets = 12;

void require(bool holds, const std::string& message) {
  if (!holds) throw InputError(message);
}

bool positive(double value) { return std::isfinite(value) && value > 0; }

// How far beyond the ends the walls reach: balls at a joined end touch what lies beyond it.
double overhang(const TumblingMill& mill) { return mill.ends == TumblingMill::Ends::periodic ? 0.5 * mill.length : 0.0; }

struct Corner {
  double across, inward;  // along the shell's tangent and towards the axis, from the middle of the lifter's foot [m]
};

// The outline of a lifter above its foot, from one side of the foot to the other.
std::vector<Corner> outline(const Lifters& lifters) {
  const double half = 0.5 * lifters.width, height = lifters.height;
  switch (lifters.shape) {
    case Lifters::Shape::rectangular:
      return {{-half, height}, {half, height}};
    case Lifters::Shape::trapezoid: {
      const double top = half - height / std::tan(lifters.face_angle);
      return {{-half, 0}, {-top, height}, {top, height}, {half, 0}};
    }
    case Lifters::Shape::bar: {
      std::vector<Corner> corners;
      for (int k = 0; k <= crown_facets; ++k) {
        const double angle = pi * k / crown_facets;
        corners.push_back({-half * std::cos(angle), height - half + half * std::sin(angle)});
      }
      return corners;
    }
  }
  return {};
}

}  // namespace

double critical_speed(double mill_diameter, double ball_diameter, double gravity) {
  require(positive(mill_diameter) && ball_diameter >= 0 && ball_diameter < mill_diameter && gravity > 0,
          "A critical speed needs a ball smaller than the mill, and gravity.");
  return std::sqrt(2 * gravity / (mill_diameter - ball_diameter));
}

double speed_at_fraction(double fraction, double mill_diameter, double ball_diameter, double gravity) {
  return fraction * critical_speed(mill_diameter, ball_diameter, gravity);
}

void check(const TumblingMill& mill) {
  require(positive(mill.diameter), "The diameter of a mill must be above 0 m.");
  require(positive(mill.length), "The length of a mill must be above 0 m.");
  require(std::isfinite(mill.speed), "The speed of a mill must be a finite number.");
  require(std::isfinite(mill.ramp) && mill.ramp >= 0, "The ramp of a mill's speed must be 0 s or more.");
  require(mill.axis.allFinite() && mill.axis.norm() > 0 && mill.centre.allFinite(),
          "The axis and centre of a mill must be finite, and the axis not zero.");
  const Vec3 axis = mill.axis.normalized();
  require(mill.ends == TumblingMill::Ends::walls || axis.cwiseAbs().maxCoeff() > 1 - 1e-12,
          "A mill with periodic ends must have its axis along x, y or z.");
  const Lifters& lifters = mill.lifters;
  require(lifters.count >= 0, "The number of lifters must be 0 or more.");
  if (lifters.count == 0) return;
  require(positive(lifters.height) && lifters.height < 0.5 * mill.diameter,
          "The height of lifters must be above 0 m and below the mill's radius.");
  require(positive(lifters.width) && lifters.width < mill.diameter,
          "The width of lifters must be above 0 m and below the mill's diameter.");
  // Neighbours must neither meet at their feet nor, as the mill narrows inward, at their tops.
  const double share = pi / lifters.count;
  for (const Corner& corner : outline(lifters)) {
    require(std::atan2(std::abs(corner.across), 0.5 * mill.diameter - corner.inward) < share,
            "The lifters are so many or so wide that they meet.");
  }
  if (lifters.shape == Lifters::Shape::trapezoid) {
    require(lifters.face_angle > 0 && lifters.face_angle <= 0.5 * pi, "The face angle of lifters must be above 0 and at most 90 degrees.");
    require(lifters.width * std::tan(lifters.face_angle) > 2 * lifters.height,
            "The faces of the lifters meet below their height: widen them, lower them or raise the face angle.");
  }
  if (lifters.shape == Lifters::Shape::bar)
    require(lifters.height >= 0.5 * lifters.width, "A bar lifter must be at least half as high as wide.");
}

Pose pose_of(const TumblingMill& mill) {
  Pose pose;
  pose.origin = mill.centre;
  const Vec3 axis = mill.axis.normalized();
  const Vec3 up = std::abs(axis.z()) < 0.999 ? Vec3::UnitZ() : Vec3::UnitY();
  const Vec3 across = up.cross(axis).normalized();
  pose.axes.col(0) = across;
  pose.axes.col(1) = axis.cross(across);
  pose.axes.col(2) = axis;
  return pose;
}

Frame frame_of(const TumblingMill& mill) {
  check(mill);
  return {mill.name, -1, turning(mill.centre, mill.axis.normalized(), mill.speed, mill.ramp)};
}

Mesh lifter_mesh(const TumblingMill& mill) {
  check(mill);
  const Lifters& lifters = mill.lifters;
  const double radius = 0.5 * mill.diameter, end = 0.5 * mill.length + overhang(mill) + 0.02 * mill.length;
  // The foot is sunk until its flat underside lies outside the shell everywhere.
  std::vector<Corner> section = outline(lifters);
  const double sunk = 0.1 * lifters.height;
  section.insert(section.begin(), {-0.5 * lifters.width, -sunk});
  section.push_back({0.5 * lifters.width, -sunk});
  const auto corners = static_cast<Index>(section.size());
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;
  for (int k = 0; k < lifters.count; ++k) {
    const double angle = 2 * pi * k / lifters.count;
    const Vec3 outward(std::cos(angle), std::sin(angle), 0), across(-std::sin(angle), std::cos(angle), 0);
    const auto base = static_cast<Index>(vertices.size());
    for (double z : {-end, end}) {
      for (const Corner& c : section) vertices.push_back((radius - c.inward) * outward + c.across * across + z * Vec3::UnitZ());
    }
    for (Index c = 0; c < corners; ++c) {
      const Index next = (c + 1) % corners, low = base + c, low_next = base + next;
      triangles.push_back({low, low_next + corners, low_next});
      triangles.push_back({low, low + corners, low_next + corners});
    }
    for (Index c = 1; c + 1 < corners; ++c) {
      triangles.push_back({base, base + c, base + c + 1});
      triangles.push_back({base + corners, base + corners + c + 1, base + corners + c});
    }
  }
  return make_mesh(std::move(vertices), std::move(triangles));
}

std::vector<Wall> walls_of(const TumblingMill& mill, Index frame) {
  check(mill);
  const double radius = 0.5 * mill.diameter, end = 0.5 * mill.length, beyond = end + overhang(mill);
  std::vector<Wall> walls;
  const auto add = [&](const char* part, Surface surface) {
    Wall wall;
    wall.name = mill.name + "." + part;
    wall.material = mill.material;
    wall.surface = std::move(surface);
    wall.frame = frame;
    wall.rest = pose_of(mill);
    wall.pose = wall.rest;
    walls.push_back(std::move(wall));
  };
  using Side = Revolved::Side;
  add("shell", Revolved{radius, -beyond, radius, beyond, Side::inside});
  if (mill.ends == TumblingMill::Ends::walls) {
    // A disc's `inside` lies above it where it narrows and below it where it widens.
    add("end_0", Revolved{radius, -end, 0, -end, Side::inside});
    add("end_1", Revolved{0, end, radius, end, Side::inside});
  }
  if (mill.lifters.count > 0) add("lifters", lifter_mesh(mill));
  return walls;
}

Region inside_of(const TumblingMill& mill) {
  check(mill);
  return {CylinderRegion{0.5 * mill.diameter, -0.5 * mill.length, 0.5 * mill.length}, pose_of(mill)};
}

double volume(const TumblingMill& mill) { return 0.25 * pi * mill.diameter * mill.diameter * mill.length; }

Domain domain_of(const TumblingMill& mill) {
  check(mill);
  Domain domain;
  if (mill.ends == TumblingMill::Ends::periodic) {
    Eigen::Index k = 0;
    mill.axis.cwiseAbs().maxCoeff(&k);
    domain.lower[k] = mill.centre[k] - 0.5 * mill.length;
    domain.period[k] = mill.length;
  }
  return domain;
}

std::int64_t balls_for_filling(const TumblingMill& mill, double filling, const SizeDistribution& sizes) {
  require(std::isfinite(filling) && filling >= 0 && filling <= 1, "A filling must lie between 0 and 1.");
  return std::llround(filling * (1 - bulk_porosity) * volume(mill) / sizes.mean_volume());
}

}  // namespace quern
