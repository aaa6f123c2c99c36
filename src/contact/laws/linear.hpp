// Linear spring and dashpot (physics: Cundall & Strack 1979; S0 eqs. 1–3, S1, S2).
//   F_n = k_n δ − c_n v_n, c_n = 2β√(m* k_n);  F_t = −(k_s ξ + c_s v_t), c_s = 2β√(m* k_s), |F_t| ≤ μ F_n.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

// The normal part of a linear contact with all its constants given.
template <class T>
QUERN_INLINE void spring_and_dashpot(const Approach<T>& a, const T& stiffness, const T& damping, NormalPart<T>& part) {
  part.elastic = stiffness * a.overlap;
  part.stiffness = stiffness;
  part.damping = damping;
  part.energy = T(0.5) * part.elastic * a.overlap;
}

struct Linear {
  static constexpr const char* name = "linear";
  double normal_stiffness = 0;      // k_n [N/m]
  double tangential_stiffness = 0;  // k_s [N/m]
  double damping_ratio = 0;         // β [-]
  double friction = 0;              // μ [-]

  double exponent() const { return 1; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    part.shared = square_root(a.effective_mass);
    spring_and_dashpot(a, T(normal_stiffness), T(2 * damping_ratio * std::sqrt(normal_stiffness)) * part.shared, part);
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>& part, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    const double stiffness = tangential_stiffness / compliance;
    take(hold(a, a.tangential_velocity, T(stiffness), T(1.0), T(2 * damping_ratio * std::sqrt(stiffness)) * part.shared, T(friction) * pressing, spring),
         T(1.0), force);
  }
};

}  // namespace quern
