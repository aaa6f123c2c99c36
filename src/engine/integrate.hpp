// Velocity Verlet with a predicted velocity (physics §1): second order also where forces depend on velocity.
//   advance:  x += v dt + a dt²/2,  v ← v + a dt   (the prediction that the forces see)
//   correct:  v += (a_new − a) dt/2                 (= v + (a + a_new) dt/2)
// Without velocity-dependent forces this is velocity Verlet to the bit of its rounding; momentum is kept by construction.
#pragma once
#include "src/particle/particles.hpp"

namespace quern {

// Moves rows [first, last) and clears their force and torque; returns the largest distance moved [m].
inline double advance(Particles& p, Index first, Index last, double dt) {
  double largest = 0;
  bool broken = false;
  for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
    Quad &x = p.position[i], &v = p.velocity[i], &w = p.spin[i];
    const Quad &a = p.acceleration[i], &b = p.angular_acceleration[i];
    const double half = 0.5 * dt;
    const Triple<double> step = {dt * (v.x + half * a.x), dt * (v.y + half * a.y), dt * (v.z + half * a.z)};
    x.x += step.x, x.y += step.y, x.z += step.z;
    v.x += dt * a.x, v.y += dt * a.y, v.z += dt * a.z;
    w.x += dt * b.x, w.y += dt * b.y, w.z += dt * b.z;
    p.force[i] = {};
    p.torque[i] = {};
    const double squared = dot(step, step);
    largest = squared > largest ? squared : largest;
    broken |= !(squared < 1e300);
  }
  return broken ? NAN : std::sqrt(largest);
}

// Turns forces into accelerations and completes the velocities.
inline void correct(Particles& p, Index first, Index last, double dt, const Triple<double>& gravity) {
  const double half = 0.5 * dt;
  for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
    Quad &v = p.velocity[i], &w = p.spin[i], &a = p.acceleration[i], &b = p.angular_acceleration[i];
    const Quad &f = p.force[i], &t = p.torque[i];
    const double per_mass = 1 / v.w, per_inertia = 1 / w.w;
    const Quad a_new = {f.x * per_mass + gravity.x, f.y * per_mass + gravity.y, f.z * per_mass + gravity.z, 0};
    const Quad b_new = {t.x * per_inertia, t.y * per_inertia, t.z * per_inertia, 0};
    v.x += half * (a_new.x - a.x), v.y += half * (a_new.y - a.y), v.z += half * (a_new.z - a.z);
    w.x += half * (b_new.x - b.x), w.y += half * (b_new.y - b.y), w.z += half * (b_new.z - b.z);
    a = a_new;
    b = b_new;
  }
}

}  // namespace quern
