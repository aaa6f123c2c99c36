// A quadratic spring without damping: F_n = k δ²; Coulomb friction on a spring of fixed stiffness.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Quadratic {
  static constexpr const char* name = "quadratic";
  double stiffness = 0;             // k [N/m²]
  double tangential_stiffness = 0;  // k_s [N/m]
  double friction = 0;              // μ [-]

  double exponent() const { return 2; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    part.elastic = T(stiffness) * a.overlap * a.overlap;
    part.stiffness = T(2 * stiffness) * a.overlap;
    part.damping = T(0.0);
    part.energy = part.elastic * a.overlap / T(3.0);
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>&, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    take(hold(a, a.tangential_velocity, T(tangential_stiffness / compliance), T(1.0), T(0.0), T(friction) * pressing, spring), T(1.0), force);
  }
};

}  // namespace quern
