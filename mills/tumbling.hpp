// A tumbling ball mill: its frames, walls, inside and critical speed from a few numbers.
//
// The mill's own axes: z along the mill axis, origin at the middle of its length, y up as far as the axis allows, x = y × z.
// With the default axis, the world's y, and gravity along −z: own x = −world x, own y = world z, own z = world y. A positive speed
// turns right-handed about the axis.
#pragma once
#include <string>
#include <vector>
#include "mills/frame.hpp"
#include "src/base/domain.hpp"
#include "src/particle/packing.hpp"
#include "src/wall/walls.hpp"

namespace quern {

// Bars along the mill on the inside of its shell, evenly spread, the first at own +x.
struct Lifters {
  enum class Shape {
    rectangular,  // width × height
    trapezoid,    // width at the shell; both faces at face_angle to the shell's tangent
    bar           // upright faces, crowned by a half round of diameter `width`; height ≥ width/2
  };
  int count = 0;
  double height = 0;                       // above the shell [m]
  double width = 0;                        // at the shell [m]
  double face_angle = 1.5707963267948966;  // trapezoid: between face and shell, π/2 is upright [rad]
  Shape shape = Shape::rectangular;
};

struct TumblingMill {
  enum class Ends { walls, periodic };
  std::string name = "mill";
  double diameter = 0;  // inside the shell [m]
  double length = 0;    // inside [m]
  double speed = 0;     // [rad/s]; see speed_at_fraction
  double ramp = 0;      // time from rest to `speed`, linear [s]
  Lifters lifters;
  Ends ends = Ends::walls;     // periodic: the axis must lie along x, y or z
  Vec3 centre = Vec3::Zero();  // the middle of the mill, in the fixed frame [m]
  Vec3 axis = Vec3::UnitY();   // need not be unit
  std::uint8_t material = 0;
};

// The angular speed at which a ball of diameter d stays on the shell of a mill of diameter D: √(2g/(D − d)) [rad/s]; in turns per
// second (1/2π)√(2g/(D − d)). Throws InputError unless 0 ≤ d < D.
double critical_speed(double mill_diameter, double ball_diameter, double gravity = 9.81);
double speed_at_fraction(double fraction, double mill_diameter, double ball_diameter, double gravity = 9.81);  // [rad/s]

// Throws InputError with one sentence on the first thing that cannot be: sizes ≤ 0, lifters that fill the mill or each other, …
void check(const TumblingMill& mill);

Pose pose_of(const TumblingMill& mill);
// The turning frame that carries the walls.
Frame frame_of(const TumblingMill& mill);
// "<name>.shell", with walls at the ends "<name>.end_0" and "<name>.end_1", with lifters "<name>.lifters" (one mesh of all). Their
// rest pose and pose are the mill's at time 0. `frame`: the index that frame_of's frame gets.
std::vector<Wall> walls_of(const TumblingMill& mill, Index frame);
// Closed prisms along the mill in its own axes, sunk a little into the shell and reaching beyond its ends.
Mesh lifter_mesh(const TumblingMill& mill);
// The inside of the shell between the ends; lifters are not taken off.
Region inside_of(const TumblingMill& mill);
// π/4 D² L: of which a filling is a fraction; by custom lifters are not taken off [m³].
double volume(const TumblingMill& mill);
// Periodic along the mill axis if its ends are; otherwise open.
Domain domain_of(const TumblingMill& mill);
// The number of balls whose bulk volume is nearest to filling · volume(mill).
std::int64_t balls_for_filling(const TumblingMill& mill, double filling, const SizeDistribution& sizes);

}  // namespace quern
