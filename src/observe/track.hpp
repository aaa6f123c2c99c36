// Place, velocity and spin of chosen particles against time.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct TrackPoint {
  double time = 0;  // [s]
  Index id = 0;
  Triple<double> position{}, velocity{}, spin{};  // [m], [m/s], [rad/s]
  template <class Archive>
  void archive(Archive& a) {
    a(time, id, position.x, position.y, position.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z);
  }
};

struct Track {
  std::vector<TrackPoint> points;
  double next = 0;  // when the next sample is due [s]

  void see(const Simulation& simulation, const ObserverSettings& settings);
  // Writes down where they are now, if that is not done already.
  void finish(const Simulation& simulation, const ObserverSettings& settings);
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a) {
    a(points, next);
  }
};

}  // namespace quern
