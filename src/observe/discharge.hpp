// The mass that passes through a plane, such as the outlet of a hopper.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

// A particle counts where its centre is. What comes back counts back.
struct Discharge {
  std::vector<double> time;  // ends of the intervals [s]
  std::vector<double> mass;  // beyond the plane then, less that at the start [kg]
  double first_mass = 0, began_at = 0, next = 0;
  bool began = false;

  void see(const Simulation& simulation, const ObserverSettings& settings);
  std::vector<Headline> headlines(const ObserverSettings& settings) const;
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a) {
    a(time, mass, first_mass, began_at, next, began);
  }

 private:
  std::vector<double> rates() const;  // means of each interval [kg/s]
};

}  // namespace quern
