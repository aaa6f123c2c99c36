// What a testing machine records: the way of a platen and the force on it, what gauges on the specimen read, and how still it stands.
#pragma once
#include <array>
#include <cstddef>
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

// Sums over an interval of one wall, and its finished rows.
struct WallLoading {
  std::string name;
  double start = 0;                                // where the wall stood, along its motion [m]
  double displacement_sum = 0, force_sum = 0;      // [m s], [N s]
  std::vector<double> displacement, force;         // means of each interval [m], [N]

  template <class Archive>
  void archive(Archive& a) {
    a(name, start, displacement_sum, force_sum, displacement, force);
  }
};

// A bonded grain and where it was at the start.
struct RestingGrain {
  Index id = 0;
  Triple<double> place{};  // [m]

  template <class Archive>
  void archive(Archive& a) {
    a(id, place.x, place.y, place.z);
  }
};

// Force and displacement are along the wall's motion, positive where the wall pushes and moves forward. The grains that are bonded at the start
// are the specimen. Its strain is the slope of the displacements in its middle half over the places at the start, by least squares: what an
// extensometer reads, away from the platens. A gauge is the mean displacement of a grain and its twelve nearest.
struct Loading {
  std::vector<double> time;                     // ends of the intervals [s]
  std::vector<WallLoading> walls;
  std::vector<double> strain_along, strain_across;  // positive: longer [-]
  std::vector<double> gauge;                    // the first, less the mean of the others, along the motion of the first wall [m]
  std::vector<double> kinetic, bond_energy;     // [J]
  std::vector<double> broken;                   // bonds

  double seconds = 0;
  bool began = false;
  std::vector<RestingGrain> specimen, middle;   // all, and those of the middle half, by id
  std::vector<std::vector<RestingGrain>> gauges;

  void see(const Simulation& simulation, const ObserverSettings& settings);

  // The linear part: rows from the first that reaches 20 % of the peak to the first that reaches 60 % of it, before the peak.
  struct LinearPart {
    std::size_t from = 0, to = 0, peak = 0;  // to: one beyond the last
  };
  std::optional<LinearPart> linear_part() const;
  std::vector<Headline> headlines(const ObserverSettings& settings) const;
  std::vector<Table> tables(const ObserverSettings& settings) const;

  template <class Archive>
  void archive(Archive& a) {
    a(time, walls, strain_along, strain_across, gauge, kinetic, bond_energy, broken, seconds, began, specimen, middle, gauges);
  }

 private:
  void begin(const Simulation& simulation, const ObserverSettings& settings);
};

// Slope of y over x by least squares, where it meets y = 0, and its 95 % interval; correlated residuals widen it by √((1 + ρ)/(1 − ρ)).
struct Slope {
  double value = 0, zero = 0;
  std::array<double, 2> ci95{};
};
Slope slope_of(const double* x, const double* y, std::size_t count);

}  // namespace quern
