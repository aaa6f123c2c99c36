// A planetary mill: a disc that turns and carries vials, each of which turns about its own axis.
//
// At time 0 vial k (from 0) stands at the angle 2πk/n around the disc. Its own axes: z along its axis, x away from the disc's axis, y = z × x,
// origin in its middle. A positive speed turns right-handed about an axis.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include "mills/frame.hpp"
#include "src/particle/region.hpp"
#include "src/wall/walls.hpp"

namespace quern {

struct PlanetaryMill {
  enum class RatioTo { disc, fixed };  // against what the vials' speed is counted
  enum class Axes { fixed, disc };     // in which the motion is computed
  double disc_diameter = 0;            // of the circle on which the middles of the vials travel [m]
  double vial_diameter = 0;            // inside [m]
  double vial_length = 0;              // inside [m]
  int vials = 1;
  double speed = 0;                    // of the disc [rad/s]
  double ratio = 0;                    // speed of the vials over that of the disc; negative: the other way round
  RatioTo ratio_to = RatioTo::disc;
  double ramp = 0;                     // time from rest to full speed, linear, disc and vials together [s]
  double tilt = 0;                     // of the vials' axes from the disc's, outward; π/2: vials lie like spokes [rad]
  Vec3 centre = Vec3::Zero();          // of the disc, between the middles of the vials [m]
  Vec3 axis = Vec3::UnitZ();           // of the disc; need not be unit
  std::uint8_t material = 0;
  Axes axes = Axes::fixed;
  std::optional<Mesh> vessel;          // the inside of a vial in its own axes, instead of the cylinder
};

// Throws InputError with one sentence on the first thing that cannot be: sizes ≤ 0, vials that meet, …
void check(const PlanetaryMill& mill);

// Turns of the disc in the fixed frame and of the vials in the disc's; the axis is the disc's, or the first vial's at time 0.
Motion disc_motion(const PlanetaryMill& mill);
Motion vial_motion(const PlanetaryMill& mill, int vial);

// The motion frames, "disc" and in it "vial_1", "vial_2" …; computed in the disc's axes the disc stands still.
std::vector<Frame> frames_of(const PlanetaryMill& mill);
std::string vial_name(int vial);

// "vial_1.shell", "vial_1.end_0", "vial_1.end_1" (or "vial_1.vessel"), and so on. `first_frame`: the index that the disc's frame gets.
std::vector<Wall> walls_of(const PlanetaryMill& mill, Index first_frame);

// The vial's own axes at time 0, when the disc's axes are the fixed ones.
Pose vial_pose(const PlanetaryMill& mill, int vial);
// The disc's axes in those of the run at a time [s]: where the vials stand still but for their own turning.
Pose disc_pose(const PlanetaryMill& mill, double time);
Region inside_of(const PlanetaryMill& mill, int vial);
// Of one vial [m³].
double volume(const PlanetaryMill& mill);

// The speed of the vials against the fixed frame over that of the disc, for axes that are parallel.
double absolute_ratio(const PlanetaryMill& mill);
// The |absolute_ratio| above which a ball of diameter d stays on the shell even at its point nearest to the disc's axis, without gravity:
// there the pull l ω² that holds it on its circle must exceed that of the disc, R Ω²; so √(R/l) with l = (D − d)/2, exact for one ball.
double critical_ratio(const PlanetaryMill& mill, double ball_diameter);

}  // namespace quern
