#include "mills/frame.hpp"

#include <algorithm>
#include <cmath>

namespace quern {
namespace {

// The pose of a frame that has turned by `angle` [rad] about an axis through `centre`, seen from its parent.
Pose turned(const Vec3& centre, const Vec3& axis, double angle, double speed) {
  Pose pose;
  pose.axes = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  pose.origin = centre - pose.axes * centre;
  pose.angular_velocity = speed * axis;
  pose.velocity = pose.angular_velocity.cross(pose.origin - centre);
  return pose;
}

double speed_at(const RotatingByTable& table, double time) {
  const auto& t = table.time;
  if (t.empty()) return 0;
  if (time <= t.front()) return table.speed.front();
  if (time >= t.back()) return table.speed.back();
  const auto k = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), time) - t.begin());
  return table.speed[k - 1] + (table.speed[k] - table.speed[k - 1]) * (time - t[k - 1]) / (t[k] - t[k - 1]);
}

// Integral of the speed from the table's first instant to `time`: trapezoids, exact for a speed linear between instants [rad].
double angle_since_first(const RotatingByTable& table, double time) {
  const auto& t = table.time;
  if (t.empty()) return 0;
  if (time <= t.front()) return table.speed.front() * (time - t.front());
  double angle = 0;
  for (std::size_t k = 1; k < t.size(); ++k) {
    if (time <= t[k]) return angle + 0.5 * (table.speed[k - 1] + speed_at(table, time)) * (time - t[k - 1]);
    angle += 0.5 * (table.speed[k - 1] + table.speed[k]) * (t[k] - t[k - 1]);
  }
  return angle + table.speed.back() * (time - t.back());
}

Pose moved(const Rotating& m, double time) { return turned(m.centre, m.axis, m.speed * time, m.speed); }

Pose moved(const RotatingByTable& m, double time) {
  return turned(m.centre, m.axis, angle_since_first(m, time) - angle_since_first(m, 0), speed_at(m, time));
}

Pose moved(const Translating& m, double time) {
  Pose pose;
  const bool rising = m.ramp > 0 && time < m.ramp;
  pose.origin = (rising ? time * std::max(time, 0.0) / (2 * m.ramp) : time - 0.5 * m.ramp) * m.velocity;
  pose.velocity = (rising ? std::max(time, 0.0) / m.ramp : 1.0) * m.velocity;
  return pose;
}

Pose moved(const Oscillating& m, double time) {
  const double rate = 2 * M_PI * m.frequency;
  Pose pose;
  pose.origin = (std::sin(rate * time + m.phase) - std::sin(m.phase)) * m.amplitude;
  pose.velocity = rate * std::cos(rate * time + m.phase) * m.amplitude;
  return pose;
}

}  // namespace

Motion turning(const Vec3& centre, const Vec3& axis, double speed, double ramp) {
  if (ramp == 0) return Rotating{centre, axis, speed};
  return RotatingByTable{centre, axis, {0, ramp}, {0, speed}};
}

std::vector<Pose> poses_at(const std::vector<Frame>& frames, double time) {
  std::vector<Pose> poses;
  poses.reserve(frames.size());
  for (const Frame& frame : frames) {
    const Pose in_parent = std::visit([time](const auto& motion) { return moved(motion, time); }, frame.motion);
    poses.push_back(frame.parent < 0 ? in_parent : carried(poses[static_cast<std::size_t>(frame.parent)], in_parent));
  }
  return poses;
}

Turn turn_at(const Motion& motion, double time) {
  if (const auto* m = std::get_if<Rotating>(&motion)) return {m->centre, m->axis, m->speed * time, m->speed};
  if (const auto* m = std::get_if<RotatingByTable>(&motion))
    return {m->centre, m->axis, angle_since_first(*m, time) - angle_since_first(*m, 0), speed_at(*m, time)};
  return {};
}

Pose carried(const Pose& frame, const Pose& rest) {
  Pose pose;
  pose.origin = frame.to_fixed(rest.origin);
  pose.axes = frame.axes * rest.axes;
  pose.velocity = frame.velocity_at(pose.origin) + frame.axes * rest.velocity;
  pose.angular_velocity = frame.angular_velocity + frame.axes * rest.angular_velocity;
  return pose;
}

}  // namespace quern
