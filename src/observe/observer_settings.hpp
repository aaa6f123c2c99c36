// What the observers of a run watch, and how. Plain numbers, filled from the case; nothing here depends on its format.
#pragma once
#include <optional>
#include <vector>
#include "mills/planetary.hpp"
#include "src/base/vec.hpp"
#include "src/observe/instrument.hpp"

namespace quern {

// The axis of a mill, about which torque and angles are taken.
struct MillAxis {
  Vec3 centre = Vec3::Zero();   // a point of the axis, halfway along the mill [m]
  Vec3 axis = Vec3::UnitY();    // unit
  double speed = 0;             // right-handed about the axis [rad/s]; its sign is the sense of rotation
  double radius = 0;            // inside the shell, lifters not subtracted [m]
  double length = 0;            // inside, or the period of a periodic mill [m]
  double lifter_height = 0;     // [m]
};

// What the drive must give beside what the charge takes.
struct DriveLoss {
  double bearing_torque = 0;    // at any speed and filling [N m]
  double gear_loss = 0;         // as a part of the power that the gears hand on
  bool any() const { return bearing_torque > 0 || gear_loss > 0; }
};

// A straight line in the mill's cross-section along which the mean velocity is read off: through `point`, along `direction`.
struct ProfileLine {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();  // unit
};

// A wall whose way and force are recorded, and the direction in which it moves.
struct LoadedWall {
  int wall = 0;
  Vec3 along = Vec3::UnitZ();  // unit
};

// A plane through which mass passes, and the way out.
struct OutletPlane {
  Vec3 point = Vec3::Zero();
  Vec3 direction = -Vec3::UnitZ();  // unit
};

struct ObserverSettings {
  // Averages begin at this time [s]; negative: where the power series is found to be steady (see block_average.hpp).
  double start_time = -1;

  std::optional<MillAxis> mill;       // without it: no torque, no angles; forces and spectra only
  DriveLoss drive;                    // of `mill`
  std::optional<PlanetaryMill> planetary;  // whose disc is the first of the frames; then there is no `mill`
  std::vector<int> driven_walls;      // whose torque makes the power; empty: every wall that a frame moves
  std::vector<int> shell_walls;       // whose summed force is the force on the shell; empty: as driven_walls

  bool power = true;
  double power_interval = 0.01;       // torque and power are averaged over this long [s]
  bool shell_force = true;
  double force_interval = 1e-3;       // [s]; half its inverse is the highest frequency seen
  double band_from = 20, band_to = 150;  // of the shell force's spectrum [Hz]

  bool spectrum = true;               // of collisions; needs Simulation::start(true)
  int bins_per_decade = 10;
  double long_contact = 0;            // contacts that last longer are counted apart [s]; 0: 1000 time steps
  double convergence_interval = 0;    // between looks at how well the spectrum is known [s]; 0: none
  double stop_at_interval = 0;        // half-width over value of the 95 % intervals of E_i and of the collision rate at which the run has sampled enough; 0: not asked for
  double stop_at_bin_interval = 0;    // the same of every bin that carries at least 1 % of E_i; 0: not asked for

  bool charge = true;                 // polar fields, angles, heights; needs `mill`
  double charge_interval = 0;         // between samples of the paths, every fourth of the fields too [s]; 0: 1/360 of a revolution, at least 50 time steps
  int angle_cells = 120;
  int radius_cells = 20;
  std::vector<int> track;             // ids of particles whose place, velocity and spin are written against time
  double track_interval = 0;          // [s]; 0: every step
  std::optional<InstrumentSettings> signal;  // instruments whose view of the first particle is written, at the track's interval; none: it is not
  bool contact_history = false;       // every contact, force and overlap against time, each step; needs Simulation::start(true); for few particles

  bool fragments = true;              // damage, fragments, failures; where there are bonds
  double fragment_interval = 0;       // between rows of the damage [s]; 0: 200 time steps
  std::optional<Vec3> impact_direction;  // with which the directions of cracks are compared; none: of the bodies' velocity at the start, else down
  std::vector<LoadedWall> loading;    // walls that load a specimen; headline numbers are those of the first
  double loading_interval = 0;        // forces are averaged over this long [s]; 0: every step
  bool strain = false;                // of the specimen's middle half
  std::vector<Vec3> gauges;           // places on the specimen [m]

  std::optional<OutletPlane> discharge;  // whose passing mass is recorded
  double discharge_interval = 0;      // between rows of that mass [s]

  std::optional<ProfileLine> velocity_line;  // none: through the mill's centre, perpendicular to the free surface
};

}  // namespace quern
