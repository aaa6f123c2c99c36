// The linear equivalent of a power law (physics: S0 §4): k' and q' from S0 eqs. 23–24 (see linearize.hpp).
//   F_n = k' δ − q' v_n;  tangential as in the linear law with q'.
#pragma once
#include "src/contact/laws/linear.hpp"

namespace quern {

struct Linearized {
  static constexpr const char* name = "linearized";
  double normal_stiffness = 0;      // k' [N/m]
  double normal_damping = 0;        // q' [kg/s]
  double tangential_stiffness = 0;  // k_s [N/m]
  double friction = 0;              // μ [-]

  double exponent() const { return 1; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    spring_and_dashpot(a, T(normal_stiffness), T(normal_damping), part);
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>&, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    const double stiffness = tangential_stiffness / compliance;
    take(hold(a, a.tangential_velocity, T(stiffness), T(1.0), T(normal_damping * std::sqrt(stiffness / normal_stiffness)), T(friction) * pressing, spring),
         T(1.0), force);
  }
};

}  // namespace quern
