// A quadratic spring without damping: F_n = k δ²; Coulomb friction on a spring of fixed stiffness.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Quadratic {
  static constexpr const char* name = "quadratic";
  double stiffness = 0;             // k [N/m²]
  double tangential_stiffness = 0;  // k_s [N/m]
  double friction = 0;              // μ [-]

  template <class T>
  QUERN_INLINE ContactForce<T> operator()(const Approach<T>& a, TangentialSpring<T>& spring) const {
    ContactForce<T> force{};
    const T elastic = T(stiffness) * a.overlap * a.overlap;
    push(a, elastic, T(2 * stiffness) * a.overlap, T(0.0), force);
    const HeldForce<T> held =
        hold(a, a.tangential_velocity, T(tangential_stiffness), T(1.0), T(0.0), T(friction) * force.normal, spring);
    force.tangential = held.force;
    force.tangential_loss = held.loss;
    force.stiffening = T(1.0);
    force.elastic_energy = elastic * a.overlap / T(3.0) + spring.energy;
    return force;
  }
};

}  // namespace quern
