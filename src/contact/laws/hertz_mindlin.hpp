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

  double exponent() const { return 1.5; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    part.stiffness = T(2 * effective_young) * a.contact_radius;
    part.elastic = T(2.0 / 3.0) * part.stiffness * a.overlap;
    part.energy = T(0.4) * part.elastic * a.overlap;
    part.shared = T(2 * std::sqrt(5.0 / 6.0) * damping_ratio) * square_root(a.contact_radius * a.effective_mass);
    part.damping = T(std::sqrt(2 * effective_young)) * part.shared;
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>& part, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    const double shear = effective_shear / compliance;
    take(hold(a, a.tangential_velocity, T(8 * shear) * a.contact_radius, a.earlier, T(std::sqrt(8 * shear)) * part.shared, T(friction) * pressing, spring),
         a.earlier, force);
  }
};

}  // namespace quern
