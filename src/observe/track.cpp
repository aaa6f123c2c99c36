#include "src/observe/track.hpp"

#include <cmath>

namespace quern {

void Track::see(const Simulation& s, const ObserverSettings& settings) {
  const double now = s.clock.time();
  if (now < next - 0.5 * s.clock.time_step) return;
  next = settings.track_interval > 0 ? settings.track_interval * (std::floor((now + 0.5 * s.clock.time_step) / settings.track_interval) + 1) : 0;
  finish(s, settings);
}

void Track::finish(const Simulation& s, const ObserverSettings& settings) {
  const double now = s.clock.time();
  if (!points.empty() && points.back().time == now) return;
  for (const Index id : settings.track) {
    for (std::size_t k = 0; k < s.particles.id.size(); ++k) {
      if (s.particles.id[k] != id) continue;
      points.push_back({now, id, xyz(s.particles.position[k]), xyz(s.particles.velocity[k]), xyz(s.particles.spin[k])});
      break;
    }
  }
}

std::vector<Table> Track::tables() const {
  Column time{"t", "s", "", {}, {}}, id{"particle", "1", "id: order of insertion, from 0", {}, {}};
  Column x{"x", "m", "", {}, {}}, y{"y", "m", "", {}, {}}, z{"z", "m", "", {}, {}};
  Column vx{"vx", "m/s", "", {}, {}}, vy{"vy", "m/s", "", {}, {}}, vz{"vz", "m/s", "", {}, {}};
  Column wx{"wx", "rad/s", "", {}, {}}, wy{"wy", "rad/s", "", {}, {}}, wz{"wz", "rad/s", "", {}, {}};
  for (const TrackPoint& p : points) {
    time.values.push_back(p.time), id.values.push_back(p.id);
    x.values.push_back(p.position.x), y.values.push_back(p.position.y), z.values.push_back(p.position.z);
    vx.values.push_back(p.velocity.x), vy.values.push_back(p.velocity.y), vz.values.push_back(p.velocity.z);
    wx.values.push_back(p.spin.x), wy.values.push_back(p.spin.y), wz.values.push_back(p.spin.z);
  }
  return {{"track", "place, velocity and spin of chosen particles", {time, id, x, y, z, vx, vy, vz, wx, wy, wz}}};
}

}  // namespace quern
