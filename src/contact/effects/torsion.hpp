// Friction about the normal: a moment that opposes ω_n, the difference of spins along n, up to μ_t R* F_n. It sticks without a spring:
// each step adds the half of what would stop the turning of m* R*² 2/5 in that step, which is no more than the bodies' own inertia.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Torsion {
  double coefficient = 0;  // μ_t [-]; 0: off

  // `moment` on body i about n is that of the last step and leaves as this one's. Returns the energy lost [J].
  template <class T>
  QUERN_INLINE T operator()(const Approach<T>& a, const T& pressing, const T& turning, T& moment) const {
    const T inertia = T(0.4) * a.effective_mass * a.effective_radius * a.effective_radius;
    const T limit = T(coefficient) * a.effective_radius * pressing;
    const T before = moment;
    const double rate = a.time_step > 0 ? 0.5 / a.time_step : 0;
    moment = greater(-limit, lesser(limit, moment - T(rate) * inertia * turning));
    return -T(a.time_step) * moment * (turning + T(0.5 * a.time_step) * (moment - before) / inertia);
  }
};

}  // namespace quern
