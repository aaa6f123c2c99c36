// What was recorded of a machine or of breakage: readings under conditions. Mill curves, collision spectra and breakage curves, alone or together.
#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace quern {

// A quantity that a recording may show, and the headline number of a run that tells it ("" for rates, which come from the spectrum).
struct MachineChannel {
  const char *name, *unit, *headline;
  bool share = false;  // of a whole: 0 … 1
};
inline constexpr std::array machine_channels = {
    MachineChannel{"power", "W", "power"},
    MachineChannel{"torque", "N m", "torque"},
    MachineChannel{"shoulder", "deg", "shoulder_angle"},
    MachineChannel{"toe", "deg", "toe_angle"},
    MachineChannel{"rate", "1/s", ""},
    MachineChannel{"damage_ratio", "1", "damage_ratio", true},
    MachineChannel{"largest_fragment_fraction", "1", "largest_fragment_fraction", true},
};
const MachineChannel& machine_channel(const std::string& name);

// The conditions that have names of their own, besides keys of the case, with their SI units.
struct MachineConditionName {
  const char *name, *unit, *meaning;
};
inline constexpr std::array machine_condition_names = {
    MachineConditionName{"speed", "rad/s", "of the mill: mill.speed"},
    MachineConditionName{"speed_fraction", "1", "of the critical speed: mill.speed_fraction"},
    MachineConditionName{"filling", "1", "mill.filling"},
    MachineConditionName{"ball_diameter", "m", "of the only species"},
    MachineConditionName{"impact_speed", "m/s", "of the only thing that is inserted"},
    MachineConditionName{"campaign_time", "s", "mill.campaign_time"},
};

// "1" where it has none of its own.
const char* unit_of_machine_condition(const std::string& name);

struct Reading {
  std::string channel;
  double value = 0;       // in the channel's unit
  double deviation = 0;   // standard deviation; 0: not told
  double energy = 0;      // of a rate: middle of its bin [J]
  std::string pair;       // of a rate, where the recording tells it: "steel-steel"
};

// All that was read under one condition.
struct MachineRow {
  std::string label, where;                  // where: file and line of its first row
  std::optional<bool> held_out;
  std::map<std::string, double> conditions;  // by name, SI
  std::vector<Reading> readings;
};

struct MachineRecording {
  std::vector<std::string> files;
  std::vector<MachineRow> rows;
};

// Whether a file is a recording of this kind, by its header: a column of one of these channels and no time.
bool is_machine_recording(const std::string& file);

// Several files are taken as one recording of one machine; repeats are rows of the same conditions.
// Throws InputError: file, line, column, what was found, what is allowed.
MachineRecording read_machine_recordings(const std::vector<std::string>& files);

}  // namespace quern
