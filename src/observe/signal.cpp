#include "src/observe/signal.hpp"
#include <algorithm>
#include <array>
#include <string>

namespace quern {
namespace {

struct Channel {
  const char *name, *quantity, *unit, *description;
  BodyReading reading;
  int axis;
};
constexpr std::array channels = {
    Channel{"x", "position", "m", "", BodyReading::position, 0},
    Channel{"y", "position", "m", "", BodyReading::position, 1},
    Channel{"z", "position", "m", "", BodyReading::position, 2},
    Channel{"vx", "velocity", "m/s", "", BodyReading::velocity, 0},
    Channel{"vy", "velocity", "m/s", "", BodyReading::velocity, 1},
    Channel{"vz", "velocity", "m/s", "", BodyReading::velocity, 2},
    Channel{"wx", "spin", "rad/s", "", BodyReading::spin, 0},
    Channel{"wy", "spin", "rad/s", "", BodyReading::spin, 1},
    Channel{"wz", "spin", "rad/s", "", BodyReading::spin, 2},
    Channel{"force", "force", "N", "on the wall that was nearest at the start, along its normal, pushing it", BodyReading::force, 0},
    Channel{"displacement", "displacement", "m", "of the particle's surface into that wall", BodyReading::displacement, 0},
};

// The last two are told by a wall.
std::size_t count_of(int wall) { return wall < 0 ? channels.size() - 2 : channels.size(); }

}  // namespace

void Signal::begin(const Simulation& s, const InstrumentSettings& instruments) {
  wall = nearest_wall(s);
  for (std::size_t k = 0; k < count_of(wall); ++k) shown.emplace_back(channels[k].reading, channels[k].axis, instruments.of(channels[k].name, channels[k].quantity));
  values.resize(shown.size());
}

void Signal::see(const Simulation& s, const ObserverSettings& settings) {
  const double shift = settings.signal->clock_shift, interval = settings.track_interval;
  const bool first = !last;
  if (first) begin(s, *settings.signal);
  const BodyState now = body_state(s, wall < 0 ? nullptr : &s.walls[static_cast<std::size_t>(wall)]);
  // What is shown at t happened at t − shift.
  const double late = 1e-6 * s.clock.time_step;  // of rounding alone
  std::vector<double> happened;
  if (interval > 0) {
    for (double t = interval * static_cast<double>(times.size()); t - shift <= now.time + late; t = interval * static_cast<double>(times.size())) {
      times.push_back(t);
      happened.push_back(std::min(t - shift, now.time));
    }
  } else {
    times.push_back(now.time + shift);
    happened.push_back(now.time);
  }
  std::vector<double> seen(happened.size());
  for (std::size_t k = 0; k < shown.size(); ++k) {
    if (first) {
      shown[k].begin(now);
      std::transform(happened.begin(), happened.end(), seen.begin(), [&](double time) { return shown[k].before(now, time); });
    } else {
      shown[k].read(*last, now, happened, seen.data());
    }
    values[k].insert(values[k].end(), seen.begin(), seen.end());
  }
  last = now;
}

std::vector<Table> Signal::tables() const {
  Table table{"signal", "what the instruments of the case show of the first particle", {{"t", "s", "by the clock of the instruments", times, {}}}};
  for (std::size_t k = 0; k < values.size(); ++k) table.columns.push_back({channels[k].name, channels[k].unit, channels[k].description, values[k], {}});
  return {table};
}

}  // namespace quern
