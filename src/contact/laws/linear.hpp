// Linear spring and dashpot (physics: Cundall & Strack 1979; S0 eqs. 1–3, S1, S2).
//   F_n = k_n δ − c_n v_n, c_n = 2β√(m* k_n);  F_t = −(k_s ξ + c_s v_t), c_s = 2β√(m* k_s), |F_t| ≤ μ F_n.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

// The linear contact with all its constants given: k_n, c_n along the normal; k_s, c_s along the tangent; μ.
template <class T>
QUERN_INLINE ContactForce<T> springs_and_dashpots(const Approach<T>& a, TangentialSpring<T>& spring, const T& normal_stiffness,
                                                  const T& normal_damping, const T& tangential_stiffness, const T& tangential_damping,
                                                  double friction) {
  ContactForce<T> force{};
  const T elastic = normal_stiffness * a.overlap;
  push(a, elastic, normal_stiffness, normal_damping, force);
  const HeldForce<T> held =
      hold(a, a.tangential_velocity, tangential_stiffness, T(1.0), tangential_damping, T(friction) * force.normal, spring);
  force.tangential = held.force;
  force.tangential_loss = held.loss;
  force.stiffening = T(1.0);
  force.elastic_energy = T(0.5) * elastic * a.overlap + spring.energy;
  return force;
}

struct Linear {
  static constexpr const char* name = "linear";
  double normal_stiffness = 0;      // k_n [N/m]
  double tangential_stiffness = 0;  // k_s [N/m]
  double damping_ratio = 0;         // β [-]
  double friction = 0;              // μ [-]

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    const T root_mass = square_root(a.effective_mass);
    return springs_and_dashpots(a, spring, T(normal_stiffness), T(2 * damping_ratio * std::sqrt(normal_stiffness)) * root_mass,
                                T(tangential_stiffness), T(2 * damping_ratio * std::sqrt(tangential_stiffness)) * root_mass, friction);
  }
};

}  // namespace quern
