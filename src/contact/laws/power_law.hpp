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

  double exponent() const { return stiffness_exponent; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    part.elastic = T(stiffness) * power(a.overlap, stiffness_exponent);
    part.damping = T(damping) * power(a.overlap, damping_exponent);
    part.stiffness = T(stiffness_exponent) * part.elastic / greater(a.overlap, T(1e-300));
    part.energy = part.elastic * a.overlap / T(stiffness_exponent + 1);
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>& part, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    const double shear = tangential_stiffness / compliance;
    take(hold(a, a.tangential_velocity, T(shear), T(1.0), part.damping * square_root(T(shear) / greater(part.stiffness, T(1e-300))),
              T(friction) * pressing, spring),
         power(a.earlier, 2 * (stiffness_exponent - 1)), force);
  }
};

}  // namespace quern
