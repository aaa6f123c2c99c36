// From where the charge of a mill is looked at.
//
// A tumbling mill's charge: from the fixed frame, with gravity pulling down. A planetary mill's: from the axes of its disc, in which the vials
// turn on the spot, and all vials laid over the first; the pull of the disc points down, so 12 o'clock is the point of the shell that is
// nearest to the disc's axis, and the sense of rotation is that of the vials on the disc.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/angles.hpp"

namespace quern {

// The axis about which the charge turns; of a planetary mill that of its first vial at time 0, as long as all vials together.
MillAxis charge_axis(const ObserverSettings& settings);

struct Seat {
  MillView view;
  double pull = 0;                         // gravity, or that of the disc at the middle of a vial [m/s²]
  const PlanetaryMill* planetary = nullptr;
  Pose disc;                               // its axes in those of the run, now
  std::optional<TurningFrame::Now> field;  // of a run in the axes of the disc, now

  // None without a mill, and where nothing pulls across the axis.
  static std::optional<Seat> of(const ObserverSettings& settings, const Simulation& simulation);
  // What the run has at `place` [m] with `velocity` [m/s], as seen from here; a planetary mill's second vial and the others over the first.
  Vec3 seen(const Vec3& place) const;
  Vec3 seen_velocity(const Vec3& place, const Vec3& velocity) const;
  // Contact forces are far above a tenth of the weight, drag of the air is far below it.
  bool in_free_flight(const Simulation& simulation, Index i) const;

 private:
  // From the vial that holds a place, given in the axes of the disc, to the first.
  Mat3 to_first_vial(const Vec3& in_disc) const;
};

// The first vial's particles and walls as they stand in the axes of the disc, with velocities against it. Of no use but to be looked at.
Simulation first_vial(const Simulation& simulation, const PlanetaryMill& mill);

}  // namespace quern
