// What particles feel in axes that turn: centrifugal, Coriolis and Euler forces, and the gravity that turns the other way.
//
// In axes with the angular velocity Ω about a fixed axis, r counted from it, a particle of velocity v and spin ω in these axes has
//   m a = F + m (R^T g − Ω×(Ω×r) − 2 Ω×v − dΩ/dt × r)
//   I dω/dt = M − I (Ω×ω + dΩ/dt)
// (Landau & Lifshitz, Mechanics, § 39; the second from the sum of the spins, for a sphere), where R turns these axes into the fixed ones.
#pragma once
#include <algorithm>
#include "mills/frame.hpp"
#include "src/field/load.hpp"

namespace quern {

struct TurningFrame {
  static constexpr const char* name = "turning_axes";
  Motion motion;                     // of these axes in the fixed frame, about a fixed axis: Rotating or RotatingByTable
  Vec3 gravity = Vec3::Zero();       // in the fixed frame; that of the simulation acts as if it turned with the axes [m/s²]

  // The field at one instant.
  struct Now {
    Vec3 centre, speed, acceleration, gravity;  // [m], [rad/s], [rad/s²]; what is missing of the gravity that turns [m/s²]

    FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad& spin) const {
      const double mass = velocity.w, inertia = spin.w;
      const Vec3 r = vec(position) - centre, v = vec(velocity), w = vec(spin);
      const Vec3 a = gravity - speed.cross(speed.cross(r)) - 2 * speed.cross(v) - acceleration.cross(r);
      return {mass * a, -inertia * (speed.cross(w) + acceleration)};
    }
  };
  double rate(double, double, double, double) const { return 0; }  // walls that turn with such speed limit the step by far before
  Now at(double time, double time_step) const {
    const Turn turn = turn_at(motion, time);
    // The mean over the step around this instant, so that steps lose nothing at the corner of a ramp.
    const double before = std::max(0.0, time - 0.5 * time_step), after = time + 0.5 * time_step;
    const double acceleration = (turn_at(motion, after).speed - turn_at(motion, before).speed) / (after - before);
    return {turn.centre, turn.speed * turn.axis, acceleration * turn.axis,
            Eigen::AngleAxisd(-turn.angle, turn.axis).toRotationMatrix() * gravity - gravity};
  }
};

}  // namespace quern
