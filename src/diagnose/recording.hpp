// src/diagnose — recordings, their comparison with the simulation, where they differ, the catalogue of effects, the evidence for each, the amended
// case. No force of its own.
//
// What was recorded: runs, each of one or more channels against time, and the conditions under which it was made.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace quern {

enum class Channel : std::uint8_t { x, y, z, vx, vy, vz, wx, wy, wz, force, displacement, impact };
inline constexpr std::size_t channel_count = 12;

const char* name_of(Channel channel);       // as in the header of a recording
const char* unit_of(Channel channel);       // SI
const char* quantity_of(Channel channel);   // position, velocity, spin, force, displacement, impact
inline int axis_of(Channel channel) { return static_cast<int>(channel) % 3; }  // of x … wz

// One channel of one run, in SI units, ascending in time. Of `impact`: t is the number of the impact, counted from 1, and value its instant.
struct Series {
  Channel channel;
  std::vector<double> t, value;
  std::vector<double> deviation;  // standard deviation of each value; empty: unknown
  std::vector<double> rate;       // of change about each value: what a clock that trembles turns into noise
  std::vector<double> leap;       // by half of which each value may be on either side of a leap; empty: none is known
};

struct RecordedRun {
  std::string label, where;                  // where: file and line of its first row
  std::optional<bool> held_out;
  std::map<std::string, double> conditions;  // by name, SI
  std::vector<Series> series;

  double first_time() const;  // of its trajectory or contact [s]
  double last_time() const;
  const Series* find(Channel channel) const;
};

enum class RecordingKind { trajectory, contact, impacts };

struct Recording {
  RecordingKind kind = RecordingKind::trajectory;
  std::vector<std::string> files;
  std::vector<RecordedRun> runs;
  std::vector<std::string> remarks;  // plain sentences: what was left out or converted
};

// Reads recordings of contacts (t, force, displacement), of trajectories (t, x … wz, qw … qz) and of impact times (impact, t). Several
// files are taken as one recording of one kind. Throws InputError: file, line, column, what was found, what is allowed.
Recording read_recordings(const std::vector<std::string>& files);

// The names that a column of a condition may have, besides a key of the case, with their SI units.
struct ConditionName {
  const char *name, *unit, *meaning;
};
inline constexpr std::array condition_names = {
    ConditionName{"mass", "kg", "of the body"},
    ConditionName{"diameter", "m", "of the body"},
    ConditionName{"density", "kg/m3", "of the body"},
    ConditionName{"impact_speed", "m/s", "with which the body meets the nearest wall at t = 0"},
    ConditionName{"impact_angle", "rad", "of that velocity from the wall's normal, towards x"},
    ConditionName{"drop_height", "m", "from the wall to the body's surface, at rest at t = 0"},
    ConditionName{"x0", "m", "at the start"},
    ConditionName{"y0", "m", "at the start"},
    ConditionName{"z0", "m", "at the start"},
    ConditionName{"vx0", "m/s", "at the start"},
    ConditionName{"vy0", "m/s", "at the start"},
    ConditionName{"vz0", "m/s", "at the start"},
    ConditionName{"wx0", "rad/s", "at the start"},
    ConditionName{"wy0", "rad/s", "at the start"},
    ConditionName{"wz0", "rad/s", "at the start"},
};

// The channels that were recorded, by number.
std::vector<std::size_t> channels_of(const Recording& recording);

// The finest difference that a channel shows: below it nothing is noise.
double resolution_of(const Recording& recording, Channel channel);

}  // namespace quern
