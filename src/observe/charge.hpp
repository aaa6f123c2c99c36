// The charge of a mill, looked at as seat.hpp says: fields on a polar grid averaged over time, and from them angles, porosity and profiles; heights of fall.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include "src/engine/simulation.hpp"
#include "src/observe/seat.hpp"
#include "src/observe/table.hpp"
#include "src/observe/time_blocks.hpp"

namespace quern {

// The polar grid over the cross-section: `radius_cells` rings of equal width, `angle_cells` sectors; cell = ring · angle_cells + sector.
struct PolarGrid {
  double radius = 0, length = 0;  // of the mill [m]
  int radius_cells = 20, angle_cells = 120;

  std::size_t cells() const { return static_cast<std::size_t>(radius_cells) * static_cast<std::size_t>(angle_cells); }
  int ring_of(double r) const { return std::min(radius_cells - 1, static_cast<int>(r / radius * radius_cells)); }
  int sector_of(double angle) const { return static_cast<int>(angle / 360 * angle_cells) % angle_cells; }
  std::size_t cell(int ring, int sector) const { return static_cast<std::size_t>(ring) * static_cast<std::size_t>(angle_cells) + static_cast<std::size_t>(sector); }
  double ring_radius(int ring) const { return (ring + 0.5) * radius / radius_cells; }   // middle [m]
  double sector_angle(int sector) const { return (sector + 0.5) * 360 / angle_cells; }  // middle [degrees]
  double volume(int ring) const;                                                        // of a cell [m³]
  template <class Archive>
  void archive(Archive& a) {
    a(radius, length, radius_cells, angle_cells);
  }
};

// Impact energy next to the shell by strength: per energy bin (ten per decade) the sum and its first moments over the angle.
struct ImpactBin {
  double energy = 0, cosine = 0, sine = 0;  // [J]
  template <class Archive>
  void archive(Archive& a) {
    a(energy, cosine, sine);
  }
};

struct ChargeSums {
  double samples = 0;                       // of the fields
  std::vector<double> volume;               // of particles in each cell, summed over samples [m³]
  std::vector<double> flow_ahead, flow_up;  // volume times velocity [m³ m/s]
  std::vector<double> layer;                // volume of the particles next to the shell and not in free flight, by sector [m³]
  double followed = 0, flown = 0;           // volume of all particles, and of those on flights that count as falls, summed over the samples of paths [m³]
  double held = 0, held_turn = 0;           // of those counted in `layer`: volume [m³], volume times angular speed about the axis [m³ rad/s]
  std::vector<double> leaving;              // net volume that left that layer inwards, by sector [m³]
  std::vector<ImpactBin> impacts;
  double rises = 0, rise_sum = 0;           // ranges of height within a revolution: number, sum [m]
  double falls = 0, fall_sum = 0, fall_max = 0;  // free flights: number, sum and largest of their drops [m]
  void add(const ChargeSums& later);
  template <class Archive>
  void archive(Archive& a) {
    a(samples, volume, flow_ahead, flow_up, layer, followed, flown, held, held_turn, leaving, impacts, rises, rise_sum, falls, fall_sum, fall_max);
  }
};

// What one particle did lately; by id.
struct BallTrack {
  double lowest = 0, highest = 0;  // in this revolution [m]
  double apex = 0, last = 0;       // of this flight, and the height at the last sample [m]
  double held_angle = 0;           // where it last was next to the shell and not in free flight [degrees]
  std::int32_t flight_samples = 0; // of this flight
  std::uint8_t known = 0, in_layer = 0, flying = 0, whole_flight = 0;
  template <class Archive>
  void archive(Archive& a) {
    a(lowest, highest, apex, last, held_angle, flight_samples, known, in_layer, flying, whole_flight);
  }
};

// What the averaged charge looks like. Angles in the convention of angles.hpp; empty where the charge has none (at rest in a heap that
// covers no shell, or centrifuging all around).
struct ChargeShape {
  std::optional<double> toe, shoulder, departure, impact, repose;  // [degrees]
  std::optional<double> porosity;                                  // of the bed's inside [-]
  double bed_fraction = 0;                                         // solid fraction of the bed [-]
};

struct Charge {
  PolarGrid grid;
  TimeBlocks<ChargeSums> blocks;
  std::vector<BallTrack> balls;    // by id
  double layer_from = 0;           // centres farther out belong to the layer next to the shell [m]
  double mean_diameter = 0;        // weighted by volume [m]
  double next_sample = 0, next_revolution = 0;  // [s]
  double interval = 0;             // between samples [s]
  double shell_speed = 0;          // [rad/s]
  std::int64_t sampled = 0;        // every fourth sample goes into the fields as well
  std::array<double, 2> line_point{0, 0}, line_direction{0, 1};  // of the velocity profile: horizontal, vertical [m]
  bool began = false;

  // Samples the particles when a sample is due, and takes this step's collisions.
  void see(const Simulation& simulation, const ObserverSettings& settings);

  // Whether these sums have the lengths that the grid asks for.
  bool fits(const ChargeSums& sums) const;
  // The shape seen in some sums.
  ChargeShape shape(const ChargeSums& sums) const;
  // Mean velocity (ahead, up) and solid fraction at a place of the cross-section, linear between cells.
  std::array<double, 3> field_at(const ChargeSums& sums, double radius, double angle) const;

  // `from` [s]: begin of the steady state.
  std::vector<Headline> headlines(double from) const;
  std::vector<Table> tables(const ObserverSettings& settings, double from) const;

  template <class Archive>
  void archive(Archive& a) {
    a(grid, blocks, balls, layer_from, mean_diameter, next_sample, next_revolution, interval, shell_speed, sampled, line_point[0], line_point[1], line_direction[0], line_direction[1], began);
  }

 private:
  void begin(const Simulation& simulation, const ObserverSettings& settings, const Seat& seat);
  ChargeSums empty_sums() const;
  void sample(const Simulation& simulation, const Seat& seat, ChargeSums& sums);
  void follow(const Simulation& simulation, const Seat& seat, ChargeSums& sums);
  void end_revolution(ChargeSums& sums);
  void take_impacts(const Simulation& simulation, const Seat& seat, ChargeSums& sums) const;
};

// Where a profile over the sectors of a full turn, read from its densest part, falls below half of its level: the level is the mean weighted
// by the profile itself. Returns {towards smaller angles, towards larger angles} [degrees]; none if it never falls or is empty.
std::optional<std::array<double, 2>> half_level_angles(const std::vector<double>& profile);

}  // namespace quern
