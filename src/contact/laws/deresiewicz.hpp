// Hertz normal force with √δ damping and the simplified Mindlin–Deresiewicz shear (physics: S2 eqs. 1.3–1.4, its misprints mended).
//   F_n = 4/3 E*√R* δ^{3/2} − γ √(R*δ) v_n   (viscoelastic: restitution falls with speed)
//   F_t = −μ F_n [1 − (1 − s)^{3/2}] ξ/|ξ|, s = min(|ξ|, ξ_max)/ξ_max, ξ_max = μ(2−ν)/(2(1−ν)) δ
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct Deresiewicz {
  static constexpr const char* name = "deresiewicz";
  double effective_young = 0;    // E* [Pa]
  double damping_modulus = 0;    // γ [Pa s]
  double slip_ratio = 0;         // ξ_max/δ = μ(2−ν)/(2(1−ν)) [-]
  double friction = 0;           // μ [-]

  double exponent() const { return 1.5; }  // of the overlap in F_n

  template <class T>
  QUERN_INLINE void normal(const Approach<T>& a, NormalPart<T>& part) const {
    part.elastic = T(4.0 / 3.0 * effective_young) * a.contact_radius * a.overlap;
    part.stiffness = T(2 * effective_young) * a.contact_radius;
    part.damping = T(damping_modulus) * a.contact_radius;
    part.energy = T(0.4) * part.elastic * a.overlap;
  }

  template <class T>
  QUERN_INLINE void tangential(const Approach<T>& a, const NormalPart<T>&, const T& pressing, double compliance, TangentialSpring<T>& spring,
                               ContactForce<T>& force) const {
    const T tiny(1e-300), one(1.0), dt(a.time_step);
    // Where the overlap grew, the stretch shrinks until the stiffer contact gives the force it gave before: no energy is made.
    const T slip_now = greater(T(slip_ratio * compliance) * a.overlap, tiny);
    const T grown = a.earlier;
    const Triple<T> carried = square_root(spring.restoring) * spring.stretch;
    const T before = length(carried);
    const T used_before = lesser(one, before / greater(slip_now * grown, tiny));
    const T mobilized = (one - power(one - used_before, 1.5)) * grown * square_root(grown);
    const T shortened = slip_now * (one - power(one - mobilized, 2.0 / 3.0));
    const T shrink = select(before > tiny, lesser(one, shortened / greater(before, tiny)), one);

    const Triple<T> stretch = shrink * carried + a.lead * a.tangential_velocity;
    const T size = length(stretch);
    const T used = lesser(one, size / slip_now);
    const T rest = one - used;
    const T rest_root = square_root(rest);
    const T limit = T(friction) * pressing;
    const T scale = limit * (one - rest * rest_root) / greater(size, tiny);
    force.tangential = (-scale) * stretch;
    const T kept_scale = lesser(one, slip_now / greater(size, tiny));
    const Triple<T> kept = kept_scale * stretch;
    const T energy = limit * slip_now * (used - T(0.4) * (one - rest * rest * rest_root));
    force.tangential_loss = spring.energy - energy - dt * dot(force.tangential, a.tangential_velocity);
    spring = {kept + T(a.ahead) * a.tangential_velocity, energy};
    force.stiffening = grown;
  }
};

}  // namespace quern
