// Torque and power of the driven walls, and what each wall feels.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/block_average.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"
#include "src/observe/time_blocks.hpp"

namespace quern {

// What one wall felt, summed over time: mean = sum / seconds.
struct WallHistory {
  double seconds = 0;
  Triple<double> force{};   // of the particles on it [N s]
  double torque = 0;        // of the particles on it about the mill's axis [N m s]
  double work = 0;          // done by it on the particles [J]
  double peak_force = 0;    // [N]
  void add(const WallHistory& later);
  template <class Archive>
  void archive(Archive& a) {
    a(seconds, force.x, force.y, force.z, torque, work, peak_force);
  }
};

struct WallHistories {
  std::vector<WallHistory> walls;
  void add(const WallHistories& later);
  template <class Archive>
  void archive(Archive& a) {
    a(walls);
  }
};

// Torque is what the drive must give, positive in the sense of rotation; power is torque times angular speed, wall by wall. In
// a planetary mill: about the disc's axis, and about each vial's own; power is the sum of the two, each torque times the speed of its own drive.
struct TorquePower {
  // Averages over the intervals that end at `time`.
  std::vector<double> time;          // [s]
  std::vector<double> torque;        // [N m]
  std::vector<double> power;         // [W]
  std::vector<double> vial_torque;   // planetary mill: of the drive on the vials about their own axes, `torque` being about the disc's [N m]
  std::vector<double> vial_power;    // planetary mill: its part of `power` [W]
  std::vector<double> wall_power;    // by the ledger: work of all walls [W]
  std::vector<double> ledger_power;    // by the ledger: energy dissipated [W]
  TimeBlocks<WallHistories> walls;
  std::vector<std::string> wall_names;

  // The interval that is being filled, and the ledger where it began.
  double seconds = 0, torque_sum = 0, work_sum = 0, vial_torque_sum = 0, vial_work_sum = 0, last_wall_work = 0, last_taken_up = 0;
  bool began = false;

  void see(const Simulation& simulation, const ObserverSettings& settings);

  // The first sample of the steady state: given by settings.start_time or found in the power (steady_start).
  std::size_t steady_index(const ObserverSettings& settings) const;
  double steady_time(const ObserverSettings& settings) const;  // where that sample's interval begins [s]
  std::vector<Headline> headlines(const ObserverSettings& settings) const;
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a) {
    a(time, torque, power, vial_torque, vial_power, wall_power, ledger_power, walls, wall_names, seconds, torque_sum, work_sum, vial_torque_sum, vial_work_sum, last_wall_work, last_taken_up, began);
  }
};

// The walls whose torque makes the power: those listed, or all that a frame moves.
bool is_driven(const Simulation& simulation, const std::vector<int>& listed, std::size_t wall);

}  // namespace quern
