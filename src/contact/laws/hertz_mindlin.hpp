// Hertz normal force with Tsuji damping, Mindlin no-slip shear with Coulomb's limit (physics: Tsuji et al. 1992; S3, S4).
//   F_n = 4/3 E*√R* δ^{3/2} − 2√(5/6) β √(S_n m*) v_n, S_n = 2E*√(R*δ)
//   F_t = −(S_t ξ + 2√(5/6) β √(S_t m*) v_t), S_t = 8G*√(R*δ), |F_t| ≤ μ F_n
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct HertzMindlin {
  static constexpr const char* name = "hertz_mindlin";
  double effective_young = 0;  // E* [Pa]
  double effective_shear = 0;  // G* [Pa]
  double damping_ratio = 0;    // β [-]
  double friction = 0;         // μ [-]

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    ContactForce<T> force{};
    const T normal_stiffness = T(2 * effective_young) * a.contact_radius;
    const T tangential_stiffness = T(8 * effective_shear) * a.contact_radius;
    const T elastic = T(2.0 / 3.0) * normal_stiffness * a.overlap;
    const T root = T(2 * std::sqrt(5.0 / 6.0) * damping_ratio) * square_root(a.contact_radius * a.effective_mass);
    push(a, elastic, normal_stiffness, T(std::sqrt(2 * effective_young)) * root, force);
    force.stiffening = a.earlier;
    const HeldForce<T> held = hold(a, a.tangential_velocity, tangential_stiffness, force.stiffening,
                                   T(std::sqrt(8 * effective_shear)) * root, T(friction) * force.normal, spring);
    force.tangential = held.force;
    force.tangential_loss = held.loss;
    force.elastic_energy = T(0.4) * elastic * a.overlap + spring.energy;
    return force;
  }
};

}  // namespace quern
