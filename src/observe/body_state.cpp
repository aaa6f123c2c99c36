#include "src/observe/body_state.hpp"
#include <cmath>
#include "src/engine/free_flight.hpp"

namespace quern {
namespace {

// Searches put rows in another order.
std::size_t first_particle(const Particles& particles) {
  std::size_t row = 0;
  for (std::size_t k = 1; k < static_cast<std::size_t>(particles.owned) && particles.id[row] != 0; ++k)
    if (particles.id[k] < particles.id[row]) row = k;
  return row;
}

// Through value and slope at both ends of a step.
double hermite(double y0, double slope0, double y1, double slope1, double step, double s) {
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * y0 + s * s * (1 + 2 * r) * y1 + step * s * r * (r * slope0 - s * slope1);
}

}  // namespace

BodyState body_state(const Simulation& s, const Wall* wall) {
  const std::size_t row = first_particle(s.particles);
  BodyState state;
  state.time = s.clock.time();
  state.position = vec(s.particles.position[row]), state.velocity = vec(s.particles.velocity[row]);
  state.acceleration = vec(s.particles.acceleration[row]);
  state.spin = vec(s.particles.spin[row]), state.spin_rate = vec(s.particles.angular_acceleration[row]);
  if (wall == nullptr) return state;
  const double radius = s.particles.position[row].w;
  state.gap = gap_to(*wall, state.position, radius, 10 * radius);
  Vec3 normal = wall->pose.axes.col(2);
  if (!std::holds_alternative<Plane>(wall->surface)) {
    Touch touches[most_touches];
    normal = touch_wall(*wall, state.position, 1.5 * radius, touches) > 0 ? touches[0].normal : Vec3::Zero().eval();
  }
  state.gap_rate = (state.velocity - wall->pose.velocity_at(state.position)).dot(normal);
  state.force = -vec(wall->force).dot(normal);
  return state;
}

int nearest_wall(const Simulation& s) {
  const Quad& ball = s.particles.position[first_particle(s.particles)];
  int nearest = -1;
  double least = 1e300;
  for (std::size_t w = 0; w < s.walls.size(); ++w) {
    const double gap = std::abs(gap_to(s.walls[w], vec(ball), ball.w, 1e3 * ball.w));
    if (gap < least) least = gap, nearest = static_cast<int>(w);
  }
  return nearest;
}

double touch_time(const BodyState& a, const BodyState& b) {
  const double step = b.time - a.time;
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (hermite(a.gap, a.gap_rate, b.gap, b.gap_rate, step, middle) > 0 ? low : high) = middle;
  }
  return a.time + low * step;
}

double value_between(BodyReading reading, int axis, const BodyState& a, const BodyState& b, double s) {
  const double step = b.time - a.time;
  switch (reading) {
    case BodyReading::position: return hermite(a.position[axis], a.velocity[axis], b.position[axis], b.velocity[axis], step, s);
    case BodyReading::velocity: return hermite(a.velocity[axis], a.acceleration[axis], b.velocity[axis], b.acceleration[axis], step, s);
    case BodyReading::spin: return hermite(a.spin[axis], a.spin_rate[axis], b.spin[axis], b.spin_rate[axis], step, s);
    case BodyReading::displacement: return -hermite(a.gap, a.gap_rate, b.gap, b.gap_rate, step, s);
    case BodyReading::force: break;
  }
  return (1 - s) * a.force + s * b.force;
}

double value_before(BodyReading reading, int axis, const BodyState& first, double earlier) {
  switch (reading) {
    case BodyReading::position: return first.position[axis] - earlier * first.velocity[axis];
    case BodyReading::velocity: return first.velocity[axis];
    case BodyReading::spin: return first.spin[axis];
    case BodyReading::displacement: return -first.gap + earlier * first.gap_rate;
    case BodyReading::force: break;
  }
  return 0;
}

}  // namespace quern
