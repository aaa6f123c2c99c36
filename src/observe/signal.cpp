#include "src/observe/signal.hpp"
#include <algorithm>
#include <array>
#include <limits>
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

ShownReading shown_by(const Channel& channel, const InstrumentSettings& instruments) {
  return {channel.reading, channel.axis, instruments.of(channel.name, channel.quantity)};
}

}  // namespace

void Signal::begin(const Simulation& s, const InstrumentSettings& instruments) {
  wall = nearest_wall(s);
  for (std::size_t k = 0; k < count_of(wall); ++k) shown.push_back(shown_by(channels[k], instruments));
  values.resize(shown.size());
}

void Signal::see(const Simulation& s, const ObserverSettings& settings) {
  const double interval = settings.track_interval;
  const bool first = !last;
  if (first) begin(s, *settings.signal);
  const BodyState now = body_state(s, wall < 0 ? nullptr : &s.walls[static_cast<std::size_t>(wall)]);
  const double late = 1e-6 * s.clock.time_step;  // of rounding alone
  std::vector<double> happened, seen;
  std::size_t rows = std::numeric_limits<std::size_t>::max();
  for (std::size_t k = 0; k < shown.size(); ++k) {
    // What is shown at t happened at t − shift.
    const double shift = shown[k].shift();
    happened.clear();
    const auto next = [&] { return interval * static_cast<double>(values[k].size() + happened.size()) - shift; };
    if (interval > 0)
      while (next() <= now.time + late) happened.push_back(std::min(next(), now.time));
    else
      happened.push_back(now.time);
    seen.resize(happened.size());
    if (first) {
      shown[k].begin(now, happened.empty() ? now.time : happened.front());
      std::transform(happened.begin(), happened.end(), seen.begin(), [&](double time) { return shown[k].before(now, time); });
    } else {
      shown[k].read(*last, now, happened, seen.data());
    }
    values[k].insert(values[k].end(), seen.begin(), seen.end());
    rows = std::min(rows, values[k].size());
  }
  while (times.size() < rows) times.push_back(interval > 0 ? interval * static_cast<double>(times.size()) : now.time + settings.signal->clock_shift);
  last = now;
}

bool Signal::sound(const Simulation& s, const ObserverSettings& settings) const {
  if (!last) return wall == -1 && shown.empty() && times.empty() && values.empty();
  if (wall < -1 || wall >= static_cast<int>(s.walls.size()) || shown.size() != count_of(wall) || values.size() != shown.size()) return false;
  for (std::size_t k = 0; k < shown.size(); ++k)
    if (values[k].size() < times.size() || !shown[k].same_kind(shown_by(channels[k], *settings.signal))) return false;
  return true;
}

std::vector<Table> Signal::tables() const {
  Table table{"signal", "what the instruments of the case show of the first particle", {{"t", "s", "by the clock of the instruments", times, {}}}};
  for (std::size_t k = 0; k < values.size(); ++k) {
    // A column whose clock is earlier has come farther.
    std::vector<double> common(values[k].begin(), values[k].begin() + static_cast<std::ptrdiff_t>(times.size()));
    table.columns.push_back({channels[k].name, channels[k].unit, channels[k].description, std::move(common), {}});
  }
  return {table};
}

}  // namespace quern
