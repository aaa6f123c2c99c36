#include "mills/stirred.hpp"
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/wall/mesh_shapes.hpp"

namespace quern {
namespace {

constexpr double pi = 3.141592653589793;
// A polygon's corners lie on the circle that it stands for: its sides fall short of it by 0.03 % of the radius with so many.
constexpr int facets = 120;
constexpr int small_facets = 24;  // of holes and pins

void require(bool holds, const std::string& message) {
  if (!holds) throw InputError(message);
}

bool positive(double value) { return std::isfinite(value) && value > 0; }

// Where discs or rows of pins stand along the axis.
struct Places {
  double first, spacing;
  double operator()(int k) const { return first + k * spacing; }
};

Places places(double asked_spacing, double asked_first, int count, double length) {
  const double spacing = asked_spacing > 0 ? asked_spacing : length / (count + 1);
  return {asked_first > 0 ? asked_first - 0.5 * length : -0.5 * (count - 1) * spacing, spacing};
}

Places disc_places(const StirredMill& mill) { return places(mill.discs.spacing, mill.discs.first, mill.discs.count, mill.length); }
Places pin_places(const StirredMill& mill) { return places(mill.pins.spacing, mill.pins.first, mill.pins.rows, mill.length); }

double shaft_start(const StirredMill& mill) { return mill.clearance > 0 ? -0.5 * mill.length + mill.clearance : -0.5 * mill.length; }

double pin_twist(const StirrerPins& pins) { return pins.twist < 0 ? pi / pins.per_row : pins.twist; }

void check_discs(const StirredMill& mill) {
  const StirrerDiscs& discs = mill.discs;
  require(positive(discs.diameter) && positive(discs.thickness), "The discs of a stirrer need a diameter and a thickness above 0 m.");
  require(discs.diameter > mill.shaft_diameter && discs.diameter < mill.diameter,
          "The discs of a stirrer must be wider than its shaft and narrower than the vessel.");
  const Places at = disc_places(mill);
  require(discs.count == 1 || at.spacing > discs.thickness, "The discs of the stirrer meet: space them farther apart or make them thinner.");
  require(at(0) - 0.5 * discs.thickness > shaft_start(mill) && at(discs.count - 1) + 0.5 * discs.thickness < 0.5 * mill.length,
          "The discs of the stirrer reach beyond its shaft or the vessel: space them closer.");
  require(discs.holes >= 0, "The number of holes must be 0 or more.");
  if (discs.holes == 0) return;
  require(positive(discs.hole_diameter) && positive(discs.hole_circle), "The holes of discs need a diameter and a circle above 0 m.");
  require(discs.hole_circle - discs.hole_diameter > mill.shaft_diameter && discs.hole_circle + discs.hole_diameter < discs.diameter,
          "The holes of the discs reach to the shaft or to the rim: make them smaller or move their circle.");
  require(discs.holes == 1 || discs.hole_circle * std::sin(pi / discs.holes) > discs.hole_diameter,
          "The holes of the discs meet: make them fewer or smaller.");
}

void check_pins(const StirredMill& mill) {
  const StirrerPins& pins = mill.pins;
  require(pins.per_row >= 1, "A row of pins needs at least one.");
  require(positive(pins.diameter) && positive(pins.tip_circle), "The pins of a stirrer need a diameter and a tip circle above 0 m.");
  require(pins.tip_circle > mill.shaft_diameter && pins.tip_circle < mill.diameter,
          "The tips of a stirrer's pins must lie outside its shaft and inside the vessel.");
  require(pins.diameter < mill.shaft_diameter, "The pins of a stirrer must be thinner than its shaft.");
  require(pins.per_row == 1 || mill.shaft_diameter * std::sin(pi / std::max(2, pins.per_row)) > pins.diameter,
          "The pins of a row meet at the shaft: make them fewer or thinner.");
  const Places at = pin_places(mill);
  require(pins.rows == 1 || at.spacing > pins.diameter, "The rows of pins meet: space them farther apart or make the pins thinner.");
  require(at(0) - 0.5 * pins.diameter > shaft_start(mill) && at(pins.rows - 1) + 0.5 * pins.diameter < 0.5 * mill.length,
          "The rows of pins reach beyond the shaft or the vessel: space them closer.");
}

}  // namespace

void check(const StirredMill& mill) {
  require(positive(mill.diameter) && positive(mill.length), "The vessel of a stirred mill must have a diameter and a length above 0 m.");
  require(std::isfinite(mill.speed), "The speed of a mill must be a finite number.");
  require(std::isfinite(mill.ramp) && mill.ramp >= 0, "The ramp of a mill's speed must be 0 s or more.");
  require(mill.axis.allFinite() && mill.axis.norm() > 0 && mill.centre.allFinite(),
          "The axis and centre of a mill must be finite, and the axis not zero.");
  if (mill.stirrer) return;
  require(positive(mill.shaft_diameter) && mill.shaft_diameter < mill.diameter,
          "The shaft of a stirred mill must have a diameter above 0 m and below the vessel's.");
  require(mill.clearance >= 0 && mill.clearance < mill.length, "The clearance below the shaft must be 0 m or more and less than the vessel's length.");
  require(mill.discs.count >= 0 && mill.pins.rows >= 0, "The numbers of discs and of rows of pins must be 0 or more.");
  if (mill.discs.count > 0) check_discs(mill);
  if (mill.pins.rows > 0) check_pins(mill);
}

Pose pose_of(const StirredMill& mill) {
  Pose pose;
  pose.origin = mill.centre;
  const Vec3 axis = mill.axis.normalized();
  const Vec3 x = std::abs(axis.x()) < 0.9 ? (Vec3::UnitX() - axis.x() * axis).normalized() : (Vec3::UnitY() - axis.y() * axis).normalized();
  pose.axes.col(0) = x;
  pose.axes.col(1) = axis.cross(x);
  pose.axes.col(2) = axis;
  return pose;
}

Frame frame_of(const StirredMill& mill) {
  check(mill);
  return {"stirrer", -1, turning(mill.centre, mill.axis.normalized(), mill.speed, mill.ramp)};
}

Mesh stirrer_mesh(const StirredMill& mill) {
  check(mill);
  if (mill.stirrer) return *mill.stirrer;
  const double beyond = 0.02 * mill.length, shaft_radius = 0.5 * mill.shaft_diameter;
  Mesh mesh = plate(circle(shaft_radius, {0, 0}, facets), {}, mill.clearance > 0 ? shaft_start(mill) : -0.5 * mill.length - beyond,
                    0.5 * mill.length + beyond);
  const StirrerDiscs& discs = mill.discs;
  std::vector<Outline> holes;
  for (int k = 0; k < discs.holes && discs.count > 0; ++k) {
    const double angle = 2 * pi * k / discs.holes;
    holes.push_back(circle(0.5 * discs.hole_diameter, {0.5 * discs.hole_circle * std::cos(angle), 0.5 * discs.hole_circle * std::sin(angle)}, small_facets));
  }
  for (int k = 0; k < discs.count; ++k) {
    const double z = disc_places(mill)(k);
    mesh = joined(mesh, plate(circle(0.5 * discs.diameter, {0, 0}, facets), holes, z - 0.5 * discs.thickness, z + 0.5 * discs.thickness));
  }
  const StirrerPins& pins = mill.pins;
  for (int row = 0; row < pins.rows; ++row) {
    for (int k = 0; k < pins.per_row; ++k) {
      const double angle = 2 * pi * k / pins.per_row + row * pin_twist(pins);
      Pose pin;  // its own z along its length; it begins at the shaft's axis
      pin.axes.col(2) = Vec3(std::cos(angle), std::sin(angle), 0);
      pin.axes.col(0) = Vec3::UnitZ();
      pin.axes.col(1) = pin.axes.col(2).cross(pin.axes.col(0));
      pin.origin = Vec3(0, 0, pin_places(mill)(row));
      mesh = joined(mesh, moved(plate(circle(0.5 * pins.diameter, {0, 0}, small_facets), {}, 0, 0.5 * pins.tip_circle), pin));
    }
  }
  return mesh;
}

std::vector<Wall> walls_of(const StirredMill& mill, Index frame) {
  check(mill);
  const double radius = 0.5 * mill.diameter, end = 0.5 * mill.length;
  std::vector<Wall> walls;
  const auto add = [&](const char* name, Surface surface, std::uint8_t material, Index carrier) {
    Wall wall;
    wall.name = name;
    wall.material = material;
    wall.surface = std::move(surface);
    wall.frame = carrier;
    wall.rest = pose_of(mill);
    wall.pose = wall.rest;
    walls.push_back(std::move(wall));
  };
  using Side = Revolved::Side;
  if (mill.vessel) {
    add("vessel", *mill.vessel, mill.vessel_material, -1);
  } else {
    add("vessel.shell", Revolved{radius, -end, radius, end, Side::inside}, mill.vessel_material, -1);
    add("vessel.end_0", Revolved{radius, -end, 0, -end, Side::inside}, mill.vessel_material, -1);
    add("vessel.end_1", Revolved{0, end, radius, end, Side::inside}, mill.vessel_material, -1);
  }
  add("stirrer", stirrer_mesh(mill), mill.stirrer_material, frame);
  return walls;
}

Region inside_of(const StirredMill& mill) {
  check(mill);
  return {CylinderRegion{0.5 * mill.diameter, -0.5 * mill.length, 0.5 * mill.length}, pose_of(mill)};
}

double volume(const StirredMill& mill) {
  const auto disc = [](double diameter) { return 0.25 * pi * diameter * diameter; };
  const double vessel = disc(mill.diameter) * mill.length;
  if (mill.stirrer) return vessel;
  double stirrer = disc(mill.shaft_diameter) * (0.5 * mill.length - shaft_start(mill));
  const StirrerDiscs& discs = mill.discs;
  stirrer += discs.count * discs.thickness * (disc(discs.diameter) - disc(mill.shaft_diameter) - discs.holes * disc(discs.hole_diameter));
  const StirrerPins& pins = mill.pins;
  stirrer += pins.rows * pins.per_row * disc(pins.diameter) * 0.5 * (pins.tip_circle - mill.shaft_diameter);
  return vessel - stirrer;
}

const Mesh& stirrer_of(const std::vector<Wall>& walls) {
  const auto found = std::find_if(walls.begin(), walls.end(), [](const Wall& wall) { return wall.name == "stirrer"; });
  require(found != walls.end(), "There is no stirrer among the walls.");
  return std::get<Mesh>(found->surface);
}

double tip_radius(const Mesh& stirrer) {
  double farthest = 0;
  for (const Vec3& v : stirrer.vertices) farthest = std::max(farthest, std::hypot(v.x(), v.y()));
  return farthest;
}

}  // namespace quern
