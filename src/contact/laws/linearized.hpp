// The linear equivalent of a power law (physics: S0 §4): k' and q' from S0 eqs. 23–24 (see linearize.hpp).
//   F_n = k' δ − q' v_n;  tangential as in the linear law with q'.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Linearized {
  static constexpr const char* name = "linearized";
  double normal_stiffness = 0;      // k' [N/m]
  double normal_damping = 0;        // q' [kg/s]
  double tangential_stiffness = 0;  // k_s [N/m]
  double friction = 0;              // μ [-]

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    ContactForce<T> force{};
    const T elastic = T(normal_stiffness) * a.overlap;
    push(a, elastic, T(normal_stiffness), T(normal_damping), force);
    const HeldForce<T> held = hold(a, a.tangential_velocity, T(tangential_stiffness), T(1.0),
                                   T(normal_damping * std::sqrt(tangential_stiffness / normal_stiffness)), T(friction) * force.normal, spring);
    force.tangential = held.force;
    force.tangential_loss = held.loss;
    force.stiffening = T(1.0);
    force.elastic_energy = T(0.5) * elastic * a.overlap + spring.energy;
    return force;
  }
};

}  // namespace quern
