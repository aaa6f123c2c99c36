// A stirred mill: a vessel that stands still and a stirrer that turns in it, a shaft with discs or with pins.
//
// The mill's own axes: z along its axis from the start of the vessel to its end, origin at the middle of its length. Discs and rows of pins are
// numbered from the start. A positive speed turns right-handed about the axis.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>
#include "mills/frame.hpp"
#include "src/particle/region.hpp"
#include "src/wall/walls.hpp"

namespace quern {

// Flat discs on the shaft, square to it.
struct StirrerDiscs {
  int count = 0;
  double diameter = 0;   // [m]
  double thickness = 0;  // [m]
  double spacing = 0;    // of their middles [m]; 0: length / (count + 1)
  double first = 0;      // from the start of the vessel to the middle of the first [m]; 0: all of them about the middle of the vessel
  int holes = 0;         // through each disc, evenly spread, the first of them at own +x
  double hole_diameter = 0;  // [m]
  double hole_circle = 0;    // diameter of the circle on which their middles lie [m]
};

// Round pins that stand out of the shaft, in rows.
struct StirrerPins {
  int rows = 0;
  int per_row = 2;        // evenly spread
  double diameter = 0;    // [m]
  double tip_circle = 0;  // diameter of the circle on which their tips travel [m]
  double spacing = 0;     // of the rows [m]; 0: length / (rows + 1)
  double first = 0;       // from the start of the vessel to the first row [m]; 0: all of them about the middle of the vessel
  double twist = -1;      // by which each row is turned against the one before [rad]; negative: half of the angle between pins
};

struct StirredMill {
  double diameter = 0;       // inside the vessel [m]
  double length = 0;         // inside [m]
  double speed = 0;          // of the stirrer [rad/s]
  double ramp = 0;           // time from rest to full speed, linear [s]
  double shaft_diameter = 0; // [m]
  double clearance = 0;      // from the start of the vessel to the shaft's flat end [m]; 0: the shaft passes through both ends
  StirrerDiscs discs;
  StirrerPins pins;
  Vec3 centre = Vec3::Zero();  // the middle of the vessel [m]
  Vec3 axis = Vec3::UnitZ();   // upwards: a mill that stands; sideways: one that lies; need not be unit
  std::uint8_t vessel_material = 0, stirrer_material = 0;
  std::optional<Mesh> stirrer;  // instead of shaft, discs and pins, in the mill's own axes
  std::optional<Mesh> vessel;   // the inside of the vessel in the mill's own axes, instead of the cylinder
};

// Throws InputError with one sentence on the first thing that cannot be: sizes ≤ 0, discs that meet or touch the vessel, …
void check(const StirredMill& mill);

Pose pose_of(const StirredMill& mill);
// "stirrer", which carries the wall of that name.
Frame frame_of(const StirredMill& mill);
// "vessel.shell", "vessel.end_0", "vessel.end_1" (or "vessel") and "stirrer". `frame`: the index that the stirrer's frame gets.
std::vector<Wall> walls_of(const StirredMill& mill, Index frame);
// Shaft, discs and pins as closed bodies that are sunk into each other, in the mill's own axes.
Mesh stirrer_mesh(const StirredMill& mill);
// Inside of the vessel; the stirrer is not taken off.
Region inside_of(const StirredMill& mill);
// Free for the charge: the vessel less shaft, discs and pins (nothing is taken off for a stirrer that is read from a file) [m³].
double volume(const StirredMill& mill);
// The stirrer among the walls of a stirred mill.
const Mesh& stirrer_of(const std::vector<Wall>& walls);
// The radius of the part of a stirrer that is farthest from the axis [m].
double tip_radius(const Mesh& stirrer);

}  // namespace quern
