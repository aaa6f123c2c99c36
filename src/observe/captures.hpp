// Captures: a particle held between two larger bodies at once, two balls or a ball and a wall, where powder breaks.
//
// Two contacts of one particle with larger bodies that overlap in time are a capture; it is counted when the later of them ends, and its energy
// is what both of them dissipated. Contacts that were counted so do not give their energy to a further capture. Captures are counted beside
// the pairs of the collision spectrum, in which their contacts stand as well.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"
#include "src/observe/time_blocks.hpp"

namespace quern {

struct CaptureBin {
  double count = 0, normal_loss = 0, tangential_loss = 0;  // [J]
  double loss() const { return normal_loss + tangential_loss; }
  void add(const CaptureBin& more);
};

// By the species of the larger bodies (255: a wall; ascending) and of the particle between them, and by energy bin.
struct CaptureSums {
  std::map<std::array<std::uint8_t, 3>, std::map<int, CaptureBin>> kinds;
  void add(const CaptureSums& later);
  CaptureBin total() const;
  template <class Archive>
  void archive(Archive& a) {
    a(kinds);
  }
};

// A contact with a larger body that has ended.
struct Release {
  Index body = 0;  // id, or −1 − wall
  std::uint8_t species = 255;
  double end = 0;                               // [s]
  double normal_loss = 0, tangential_loss = 0;  // [J]; 0 once they were counted
};

struct Captures {
  static constexpr double larger = 2;  // a body is larger than a particle if it has so many times its mass; walls are
  TimeBlocks<CaptureSums> blocks;
  std::map<Index, std::array<Release, 4>> releases;  // by id of the particle: its last ones, of different bodies
  std::vector<double> mass;                          // by id [kg]
  std::vector<std::uint8_t> kind;                    // by id: species
  std::vector<std::string> species;
  double until = 0;        // [s]
  double charge_mass = 0;  // [kg]
  int bins_per_decade = 10;
  bool began = false;

  // Begins at the first call at or after settings.start_time.
  void see(const Simulation& simulation, const ObserverSettings& settings);
  // From `start` [s] on, to the nearest span. Empty without captures.
  std::vector<Headline> headlines(double start) const;
  std::vector<Table> tables(double start) const;

  template <class Archive>
  void archive(Archive& a) {
    a(blocks, releases, mass, kind, species, until, charge_mass, bins_per_decade, began);
  }

 private:
  void begin(const Simulation& simulation, const ObserverSettings& settings);
  void take(const Collision& collision, CaptureSums& sums);
};

}  // namespace quern
