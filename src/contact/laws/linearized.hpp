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

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    return springs_and_dashpots(a, spring, T(normal_stiffness), T(normal_damping), T(tangential_stiffness),
                                T(normal_damping * std::sqrt(tangential_stiffness / normal_stiffness)), friction);
  }
};

}  // namespace quern
