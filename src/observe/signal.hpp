// What the instruments of a case show of its first particle, against time: what a recording of the run would hold.
#pragma once
#include <optional>
#include <vector>
#include "src/observe/observer_settings.hpp"
#include "src/observe/shown_reading.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct Signal {
  int wall = -1;                            // the nearest one at the start; −1: none
  std::optional<BodyState> last;            // at the last step
  std::vector<ShownReading> shown;          // by column
  std::vector<double> times;                // as shown by all columns [s]
  std::vector<std::vector<double>> values;  // by column

  void see(const Simulation& simulation, const ObserverSettings& settings);
  std::vector<Table> tables() const;
  // Whether what a checkpoint held fits the case.
  bool sound(const Simulation& simulation, const ObserverSettings& settings) const;

  template <class Archive>
  void archive(Archive& a) {
    a(wall, last, shown, times, values);
  }

 private:
  void begin(const Simulation& simulation, const InstrumentSettings& instruments);
};

}  // namespace quern
