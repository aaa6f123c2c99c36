// One contact with effects, in their fixed order (docs/effects.md):
//   1 the rod's end gives way   2 yield   3 the law's curve, powder, power, hardening   4 adhesion   5 the table   6 damping: the law's,
//   scaled for speed and powder, and the viscoelastic   7 never more attractive than 5 without damping, unless 4 holds them
//   8 the bridge and the film pull and push beside the solids   9 friction, rolling and torsion under the force of the solids
// The loss along the normal is what the energy balance of the contact leaves: energy before − energy now − work on the bodies, by the
// trapezoidal rule, so that what snaps, breaks or yields is counted when it does.
#pragma once
#include "src/contact/effects/rigid_friction.hpp"
#include "src/contact/extras.hpp"

namespace quern {

template <class T>
struct EffectForce {
  ContactForce<T> contact;  // `normal` may be negative
  T pressing;               // of the solids on each other, for friction and rolling [N]
  T torsion, torsion_loss;  // moment about n on body i [N m]; [J]
  T lead;                   // as in Approach, for the rolling spring
};

// `a.overlap` is negative where there is a gap; `turning` is the difference of spins along n.
template <class Law, class T>
QUERN_INLINE void act_with_effects(const Law& law, const Extras& x, const Approach<T>& a, const T& turning, Remembered<T>& m, TangentialSpring<T>& spring,
                                   EffectForce<T>& result) {
  const T zero(0.0), one(1.0), dt(a.time_step);
  const T closing = -a.normal_velocity, radius = a.effective_radius;
  ContactForce<T>& force = result.contact;

  // 1: where the solids are
  T indentation = a.overlap - m.rod_end;
  typename Adhesion::Bond<T> bond{};
  const auto meets = a.overlap > zero;
  T solid = select(meets, one, zero);
  if (x.adhesion.work > 0) {
    bond = x.adhesion(indentation, closing * dt, radius);
    solid = select(meets, one, select(bond.strained > T(Adhesion::neck), select(m.touching > zero, one, zero), zero));
  }
  const auto together = solid > zero;
  const auto fresh = m.touching < T(1e-200);
  if (x.restitution.exponent != 0) {
    if (any(meets & fresh)) {
      const T scale = each(closing, [&](double speed) { return x.restitution.damping_scale(speed); });
      m.touching = select(fresh, scale, m.touching);
    }
  } else {
    m.touching = one;
  }
  const T bridged = select(together, one, select(fresh, select(m.age < zero, one, zero), one));
  m.touching = select(together, m.touching, zero);
  const T lead = select(meets & fresh, a.lead, T(0.5 * a.time_step));  // by which springs advance
  m.age = select(together, select(fresh, lead, greater(zero, m.age) + dt), zero);
  const T pressed = select(together, greater(zero, indentation), zero);

  // 2 and 3: the solids' curve
  m.greatest = select(together, greater(m.greatest, pressed), zero);
  Approach<T> at = a;
  at.lead = lead;
  typename Plastic::Reading<T> reading{pressed, one, one};
  if (x.plastic.on()) reading = x.plastic(pressed, m.greatest, radius);
  at.overlap = reading.overlap;
  at.contact_radius = square_root(radius * reading.overlap);
  NormalPart<T> part;
  law.normal(at, part);
  x.stiffening(at.overlap, law.exponent(), part);
  T elastic = reading.scale * part.elastic;
  T energy = reading.scale * part.energy / reading.slope;
  T stiffness = reading.scale * reading.slope * part.stiffness;

  // 4 and 5
  T pull_off = zero;
  if (x.adhesion.work > 0) {
    elastic += bond.force;
    energy += bond.energy;
    stiffness = greater(zero, stiffness + bond.stiffness);
    pull_off = T(1.5 * Adhesion::pi * x.adhesion.work) * radius;
    // The dashpot belongs to the face that is in contact, which the neck widens.
    Approach<T> wide = at;
    wide.overlap = bond.radius * bond.radius / radius;
    wide.contact_radius = bond.radius;
    NormalPart<T> face;
    law.normal(wide, face);
    part.damping = face.damping, part.shared = face.shared;
  }
  const T floor = x.adhesion.work > 0 ? T(-1e300) : T(lesser(zero, elastic));
  if (x.table.on()) {
    elastic += x.table(pressed, closing, m.age);
    if (x.table.stores()) energy += x.table.integral(pressed);
  }

  // 6, 7 and the rod
  const T damping = T(x.stiffening.damping_scale()) * m.touching * part.damping + T(x.viscoelastic_time) * stiffness;
  T normal = elastic + damping * closing;
  const double half = 0.5 * a.time_step;
  if (x.wave_admittance > 0) normal = normal / (one + T(x.wave_admittance) * (damping + T(half) * stiffness));
  normal = select(together, greater(floor, normal), zero);
  energy = select(together, energy, zero);
  T closing_of_solids = closing;
  if (x.wave_admittance > 0) {
    const T give = T(half * x.wave_admittance) * normal;
    energy -= select(together, give * (elastic - T(0.5) * stiffness * give), zero);
    m.rod_end = select(together, m.rod_end + give + T(a.ahead * x.wave_admittance) * normal, zero);
    closing_of_solids = closing - T(x.wave_admittance) * normal;
  } else {
    m.rod_end = zero;
  }
  result.pressing = select(together, greater(zero, normal + pull_off), zero);

  // 8
  T total = normal;
  const T gap = greater(zero, -a.overlap);
  if (x.bridge.volume > 0) {
    const auto pull = x.bridge(gap, radius);
    const T holds = select(gap < pull.rupture, bridged, zero);
    total += holds * pull.force;
    energy += holds * pull.energy;
    m.age = select(together, m.age, -holds);
  }
  if (x.lubrication.viscosity > 0) total += x.lubrication(gap, radius) * closing;

  // The ledger
  const T velocity = a.normal_velocity + T(0.5 * a.time_step * a.time_step) * a.inverse_mass * stiffness * closing_of_solids;
  force.normal = total;
  force.normal_loss = m.energy - energy - T(half) * (m.force * m.velocity + total * velocity);
  force.normal_stiffness = stiffness;
  m.energy = energy;
  m.force = total;
  m.velocity = velocity;

  // 9
  const auto only_together = [&](const Triple<T>& s) { return Triple<T>{select(together, s.x, zero), select(together, s.y, zero), select(together, s.z, zero)}; };
  spring.stretch = only_together(spring.stretch);
  const T now = greater(at.overlap, T(1e-60));
  at.earlier = lesser(one, greater(zero, now - reading.slope * closing_of_solids * dt) / now);
  if (x.tangential_compliance == 0) {
    stick(at, T(law.friction) * result.pressing, spring, force);
    force.stiffening = at.earlier;
  } else {
    if (x.adhesion.work > 0) {
      at.contact_radius = bond.radius;
      at.earlier = bond.stiffening;
    }
    law.tangential(at, part, result.pressing, x.tangential_compliance, spring, force);
  }
  spring.stretch = only_together(spring.stretch);
  force.elastic_energy = energy + spring.energy;
  result.lead = lead;
  result.torsion = result.torsion_loss = zero;
  if (x.torsion.coefficient > 0) {
    result.torsion_loss = x.torsion(a, result.pressing, turning, m.torsion);
    result.torsion = m.torsion;
  } else {
    m.torsion = zero;
  }
}

}  // namespace quern
