// Rolling resistance (physics §3): the moment on body i that opposes the relative rolling velocity of two bodies.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

enum class RollingModel { none, constant_torque, elastic_plastic };

// constant_torque: M = −μ_r R* F_n ω̂_roll (S2 eq. 1.2; never comes to rest).
// elastic_plastic: spring, dashpot and yield moment μ_r R* F_n (Ai et al. 2011, model C): k_r = 2.25 k_n μ_r² R*²,
//                  C_r = 2 η √(k_r I*), with I* = 7/5 m* R*², two equal spheres about their contact.
struct Rolling {
  RollingModel model = RollingModel::none;
  double coefficient = 0;    // μ_r [-]
  double damping_ratio = 0.3;  // η [-]

  // `rolling_velocity` is ω_i − ω_j without its part along n [rad/s]. Returns the moment on i [N m] and the energy lost [J].
  template <class T>
  QUERN_INLINE HeldForce<T> operator()(const Approach<T>& a, const ContactForce<T>& force, const Triple<T>& rolling_velocity,
                                       TangentialSpring<T>& spring) const {
    const T limit = T(coefficient) * a.effective_radius * force.normal;
    if (model == RollingModel::constant_torque) {
      const T scale = limit / greater(length(rolling_velocity), T(1e-12));
      const Triple<T> moment = (-scale) * rolling_velocity;
      return {moment, -T(a.time_step) * dot(moment, rolling_velocity)};
    }
    const T radius_squared = a.effective_radius * a.effective_radius;
    const T stiffness = T(2.25 * coefficient * coefficient) * force.normal_stiffness * radius_squared;
    const T damping = T(2 * damping_ratio) * square_root(stiffness * T(1.4) * a.effective_mass * radius_squared);
    return hold(a, rolling_velocity, stiffness, force.stiffening, damping, limit, spring);
  }
};

}  // namespace quern
