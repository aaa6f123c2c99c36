// The power law fitted to a steel ball on a load cell (physics: S0 eqs. 12–13): F_n = k δ^r − q δ^s v_n; r = 1.6, s = 0.8 for steel.
// Tangential as in the linear law, its damping in proportion to the normal one: c_s = q δ^s √(k_s/k_t(δ)), k_t(δ) = r k δ^{r−1}.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct PowerLaw {
  static constexpr const char* name = "power_law";
  double stiffness = 0;             // k [N/m^r]
  double stiffness_exponent = 1.6;  // r [-]
  double damping = 0;               // q [N s/m^(s+1)]
  double damping_exponent = 0.8;    // s [-]
  double tangential_stiffness = 0;  // k_s [N/m]
  double friction = 0;              // μ [-]

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    ContactForce<T> force{};
    const T elastic = T(stiffness) * power(a.overlap, stiffness_exponent);
    const T normal_damping = T(damping) * power(a.overlap, damping_exponent);
    const T tangent = T(stiffness_exponent) * elastic / greater(a.overlap, T(1e-300));
    push(a, elastic, tangent, normal_damping, force);
    const HeldForce<T> held =
        hold(a, a.tangential_velocity, T(tangential_stiffness), T(1.0),
             normal_damping * square_root(T(tangential_stiffness) / greater(tangent, T(1e-300))), T(friction) * force.normal, spring);
    force.tangential = held.force;
    force.tangential_loss = held.loss;
    force.stiffening = power(a.earlier, 2 * (stiffness_exponent - 1));
    force.elastic_energy = elastic * a.overlap / T(stiffness_exponent + 1) + spring.energy;
    return force;
  }
};

}  // namespace quern
