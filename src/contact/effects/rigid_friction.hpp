// Coulomb's friction without a spring (tangential_compliance 0): the bodies stick by the force that stops their sliding, up to the limit.
// Each step adds the half of what would stop it in that step, of spheres that slide and turn (2/7 m*), so that sticking is firm: a
// steady pull is held without creep. The tangential memory keeps the force.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

template <class T>
QUERN_INLINE void stick(const Approach<T>& a, const T& limit, TangentialSpring<T>& spring, ContactForce<T>& force) {
  const double rate = a.time_step > 0 ? 0.5 * 2 / 7 / a.time_step : 0;
  const Triple<T> before = square_root(spring.restoring) * spring.stretch;
  const Triple<T> trial = before - T(rate) * a.effective_mass * a.tangential_velocity;
  const T scale = lesser(T(1.0), limit / greater(length(trial), T(1e-100)));
  force.tangential = scale * trial;
  const Triple<T> velocity = a.tangential_velocity + T(0.5 * a.time_step * 3.5) * a.inverse_mass * (force.tangential - before);
  force.tangential_loss = spring.energy - T(a.time_step) * dot(force.tangential, velocity);
  spring = {force.tangential, T(0.0), T(1.0)};
}

}  // namespace quern
