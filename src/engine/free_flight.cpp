#include "src/engine/free_flight.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace quern {
namespace {

// How many steps until a way may be `gap` long, from rest or at a speed, under an acceleration.
std::int64_t steps_through(double gap, double speed, double acceleration, double time_step, std::int64_t most) {
  if (!(gap > 0)) return 1;
  const double bound = speed + std::sqrt(speed * speed + 2 * acceleration * gap);  // gap = speed t + acceleration t²/2
  const double steps = bound > 0 ? 2 * gap / bound / time_step : static_cast<double>(most);
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::min(steps, static_cast<double>(most))), 1, most);
}

}  // namespace

double gap_to(const Wall& wall, const Vec3& centre, double radius, double reach) {
  const Vec3 local = wall.pose.to_local(centre);
  if (std::holds_alternative<Plane>(wall.surface)) return local.z() - radius;
  if (const Revolved* revolved = std::get_if<Revolved>(&wall.surface)) return std::abs(revolved->touch(local).distance) - radius;
  Touch touches[most_touches];
  const int count = touch_wall(wall, centre, radius + reach, touches);
  double gap = reach;
  for (int k = 0; k < count; ++k) gap = std::min(gap, touches[k].distance - radius);
  return gap;
}

std::int64_t free_steps(const Simulation& s, std::int64_t most) {
  if (most <= 1 || s.domain.periodic() || !s.shapes.empty()) return 1;
  std::int64_t steps = most;
  const auto own = static_cast<std::size_t>(s.particles.owned);
  for (std::size_t i = 0; i < own; ++i) {
    const Vec3 x = vec(s.particles.position[i]), v = vec(s.particles.velocity[i]), a = 2 * vec(s.particles.acceleration[i]);
    const double radius = s.particles.position[i].w;
    for (const Wall& wall : s.walls) {
      if (wall.frame >= 0) return 1;
      if (std::holds_alternative<Plane>(wall.surface)) {
        // Only what goes towards a plane counts.
        const Vec3 normal = wall.pose.axes.col(2);
        const double gap = gap_to(wall, x, radius, 0) - s.contacts.reach;
        if (!(gap > 0)) return 1;
        steps = std::min(steps, steps_through(gap, std::max(0.0, -v.dot(normal)), a.norm(), s.clock.time_step, most));
      } else {
        const double gap = gap_to(wall, x, radius, 10 * radius) - s.contacts.reach;
        steps = std::min(steps, steps_through(gap, v.norm(), a.norm(), s.clock.time_step, most));
      }
    }
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 apart = x - vec(s.particles.position[j]);
      const double gap = apart.norm() - radius - s.particles.position[j].w - s.contacts.reach;
      steps = std::min(steps, steps_through(gap, (v - vec(s.particles.velocity[j])).norm(), a.norm() + 2 * vec(s.particles.acceleration[j]).norm(),
                                            s.clock.time_step, most));
    }
    if (steps == 1) return 1;
  }
  return steps;
}

}  // namespace quern
