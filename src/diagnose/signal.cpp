#include "src/diagnose/signal.hpp"
#include <algorithm>
#include <cmath>
#include "src/engine/free_flight.hpp"

namespace quern {
namespace {

// Through value and slope at both ends of a step.
double hermite(double y0, double slope0, double y1, double slope1, double step, double s) {
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * y0 + s * s * (1 + 2 * r) * y1 + step * s * r * (r * slope0 - s * slope1);
}

// The channel's value at a part s (0 … 1) of the way between two states.
double value_of(Channel channel, const BodyState& a, const BodyState& b, double s) {
  const double step = b.time - a.time;
  const int axis = axis_of(channel);
  if (channel < Channel::vx) return hermite(a.position[axis], a.velocity[axis], b.position[axis], b.velocity[axis], step, s);
  if (channel < Channel::wx) return hermite(a.velocity[axis], a.acceleration[axis], b.velocity[axis], b.acceleration[axis], step, s);
  if (channel < Channel::force) return hermite(a.spin[axis], a.spin_rate[axis], b.spin[axis], b.spin_rate[axis], step, s);
  if (channel == Channel::displacement) return -hermite(a.gap, a.gap_rate, b.gap, b.gap_rate, step, s);
  return (1 - s) * a.force + s * b.force;
}

// Before the simulation began: straight on at the first velocity, without a force.
double value_before(Channel channel, const BodyState& first, double earlier) {
  const int axis = axis_of(channel);
  if (channel < Channel::vx) return first.position[axis] - earlier * first.velocity[axis];
  if (channel < Channel::wx) return first.velocity[axis];
  if (channel < Channel::force) return first.spin[axis];
  if (channel == Channel::displacement) return -first.gap + earlier * first.gap_rate;
  return 0;
}

// A lag's answer after a time h to an input that goes from u0 to u1 meanwhile.
double lagged_after(double lagged, double u0, double u1, double h, double lag) {
  if (!(h > 0)) return lagged;
  const double slope = (u1 - u0) / h;
  return u1 - lag * slope + (lagged - u0 + lag * slope) * std::exp(-h / lag);
}

}  // namespace

BodyState body_state(const Simulation& s, const Wall* wall) {
  BodyState state;
  state.time = s.clock.time();
  state.position = vec(s.particles.position[0]), state.velocity = vec(s.particles.velocity[0]);
  state.acceleration = vec(s.particles.acceleration[0]);
  state.spin = vec(s.particles.spin[0]), state.spin_rate = vec(s.particles.angular_acceleration[0]);
  if (wall == nullptr) return state;
  const double radius = s.particles.position[0].w;
  state.gap = gap_to(*wall, state.position, radius, 10 * radius);
  Vec3 normal = wall->pose.axes.col(2);
  if (!std::holds_alternative<Plane>(wall->surface)) {
    Touch touches[most_touches];
    normal = touch_wall(*wall, state.position, 1.5 * radius, touches) > 0 ? touches[0].normal : Vec3::Zero().eval();
  }
  state.gap_rate = state.velocity.dot(normal), state.gap_acceleration = state.acceleration.dot(normal);
  state.force = -vec(wall->force).dot(normal);
  return state;
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

SignalReader::SignalReader(const RecordedRun& run, const InstrumentSettings& settings, double start) : offset_(start + settings.clock_shift) {
  for (const Series& series : run.series) {
    shown_.push_back({&series, settings.of(name_of(series.channel), quantity_of(series.channel))});
    values_.emplace_back(series.value.size(), std::nan(""));
  }
}

void SignalReader::begin(const BodyState& first) {
  for (std::size_t k = 0; k < shown_.size(); ++k) {
    Shown& one = shown_[k];
    one.lagged = one.instrument.scaled(value_of(one.series->channel, first, first, 0));
    while (one.next < one.series->t.size() && one.series->t[one.next] - offset_ <= first.time) {
      const double earlier = first.time - (one.series->t[one.next] - offset_);
      values_[k][one.next++] = one.instrument.cut(one.instrument.scaled(value_before(one.series->channel, first, earlier)));
    }
  }
}

bool SignalReader::see(const BodyState& before, const BodyState& now) {
  bool more = false;
  for (std::size_t k = 0; k < shown_.size(); ++k) {
    read(shown_[k], values_[k], before, now);
    more |= shown_[k].next < shown_[k].series->t.size();
  }
  return more;
}

void SignalReader::read(Shown& one, std::vector<double>& values, const BodyState& before, const BodyState& now) {
  const Series& series = *one.series;
  const double step = now.time - before.time;
  const auto scaled = [&](double s) { return one.instrument.scaled(value_of(series.channel, before, now, s)); };
  if (!(one.instrument.lag > 0)) {
    for (; one.next < series.t.size() && series.t[one.next] - offset_ <= now.time; ++one.next)
      values[one.next] = one.instrument.cut(scaled((series.t[one.next] - offset_ - before.time) / step));
    return;
  }
  // The lag takes its input as straight over each piece.
  const int pieces = std::clamp(static_cast<int>(4 * step / one.instrument.lag), 1, 64);
  for (int piece = 0; piece < pieces; ++piece) {
    const double from = piece / static_cast<double>(pieces), to = (piece + 1) / static_cast<double>(pieces);
    const double u0 = scaled(from), u1 = scaled(to), h = step / pieces;
    for (; one.next < series.t.size(); ++one.next) {
      const double since = series.t[one.next] - offset_ - before.time - from * step;
      if (since > h * (1 + 1e-12)) break;
      const double u = u0 + (u1 - u0) * since / h;
      values[one.next] = one.instrument.cut(lagged_after(one.lagged, u0, u, since, one.instrument.lag));
    }
    one.lagged = lagged_after(one.lagged, u0, u1, h, one.instrument.lag);
  }
}

}  // namespace quern
