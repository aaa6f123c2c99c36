// src/contact — neighbour search, contact points, contact laws (one header each), history and rolling.
//
// What a contact law sees and what it answers. T is double (one contact) or a SIMD pack (eight contacts at once).
#pragma once
#include "src/base/triple.hpp"

namespace quern {

// The kinematics of one contact between bodies i and j; the normal n points from j to i.
template <class T>
struct Approach {
  T overlap;                      // δ ≥ 0 [m]
  T normal_velocity;              // v_n = v_c·n [m/s]; negative while the bodies approach
  Triple<T> tangential_velocity;  // v_t = v_c − v_n n [m/s]
  T effective_radius;             // R* [m]
  T contact_radius;               // √(R* δ), of Hertz's contact area [m]
  T effective_mass;               // m* [kg]
  T inverse_mass;                 // 1/m* [1/kg]
  T earlier;                      // δ one step earlier over δ now, 0 … 1 (1 where it shrank) [-]
  double time_step;               // over which the force has acted when it is evaluated [s]
  T lead;                         // by which springs advance to now: half a step, or since first touch [s]
  double ahead;                   // by which springs advance beyond now: half the next step [s]
};

// An approach along the normal alone, of one contact, seen without its past.
inline Approach<double> head_on(double overlap, double normal_velocity, double effective_radius, double effective_mass, double time_step = 0) {
  return {overlap, normal_velocity, {0, 0, 0}, effective_radius, std::sqrt(effective_radius * overlap), effective_mass, 1 / effective_mass, 1, time_step, 0.5 * time_step, 0.5 * time_step};
}

// A spring in the contact plane (sliding) or about it (rolling), kept from step to step. `stretch` is stored half a step
// ahead of the force it gave (see hold), `energy` is what it stored when it gave that force. A kernel that turned the stretch along
// with its contact leaves it to the law to restore its length: one square root then serves for this and for the stiffening.
template <class T>
struct TangentialSpring {
  Triple<T> stretch{};      // ξ [m], or a rolling angle [rad]
  T energy{};               // [J]
  T restoring = T(1.0);     // square of the factor by which `stretch` must be multiplied [-]
};

// What a law says along the normal, before a force is made of it.
template <class T>
struct NormalPart {
  T elastic;    // F_e [N], a power of the overlap
  T stiffness;  // dF_e/dδ [N/m]
  T damping;    // c [kg/s]
  T energy;     // stored [J]
  T shared;     // what the law's tangential part wants of it
};

template <class T>
struct ContactForce {
  T normal;              // ≥ 0, along n on body i [N]
  Triple<T> tangential;  // on body i [N]
  T normal_stiffness;    // tangent stiffness of the elastic part [N/m]
  T stiffening;          // square of: that stiffness one step earlier over its present value, at most 1 [-]
  T elastic_energy;      // stored in the normal and the tangential spring [J]
  T normal_loss;         // dissipated along the normal in this step [J]
  T tangential_loss;     // dissipated by sliding and tangential damping in this step [J]
};

// Normal force from its elastic and its viscous part, never attractive: F_n = max(0, F_e − c v_n). `stiffness` is dF_e/dδ.
// The loss is the viscous force times the velocity that the step ends with, not the predicted one: the force's own change
// over the step corrects it, which keeps the ledger second order with a small constant.
template <class T>
QUERN_INLINE void push(const Approach<T>& a, const T& elastic, const T& stiffness, const T& damping, ContactForce<T>& force) {
  force.normal = greater(T(0.0), elastic - damping * a.normal_velocity);
  force.normal_stiffness = stiffness;
  const T correction = T(0.5 * a.time_step * a.time_step) * a.inverse_mass * (stiffness * a.normal_velocity + damping * a.inverse_mass * force.normal);
  force.normal_loss = (elastic - force.normal) * (a.normal_velocity - correction) * T(a.time_step);
}

template <class T>
struct HeldForce {
  Triple<T> force;
  T loss;
};

// A spring k with a dashpot c in one plane, limited in size (Cundall & Strack 1979): F = −(k ξ + c v), |F| ≤ limit.
// `stiffening` = (k(last step)/k(now))² ≤ 1: where k grows with the overlap the spring is shortened, so that stiffening alone
// raises neither its force nor its energy (Elata & Berryman 1996); this is what keeps oblique impacts from gaining energy.
//
// The stretch advances by half a step with the velocity before and half with the velocity after each force: the
// trapezoidal rule, which keeps velocity Verlet's second order.
template <class T>
QUERN_INLINE HeldForce<T> hold(const Approach<T>& a, const Triple<T>& velocity, const T& stiffness, const T& stiffening, const T& damping,
                               const T& limit, TangentialSpring<T>& spring) {
  const T dt(a.time_step);
  const Triple<T> stretch = square_root(stiffening * spring.restoring) * spring.stretch + a.lead * velocity;
  const Triple<T> trial = stiffness * stretch + damping * velocity;
  const T size = length(trial);
  const auto slides = size > limit;
  // One division for two reciprocals.
  const T some_size = greater(size, T(1e-100)), some_stiffness = greater(stiffness, T(1e-100));
  const T reciprocal = T(1.0) / (some_size * some_stiffness);
  const T scale = select(slides, limit * (reciprocal * some_stiffness), T(1.0));
  const Triple<T> force = (-scale) * trial;
  // A sliding spring keeps just the stretch that by itself carries the limit.
  const T softness = scale * (reciprocal * some_size);
  const Triple<T> slipped = softness * trial;
  const Triple<T> kept = {select(slides, slipped.x, stretch.x), select(slides, slipped.y, stretch.y), select(slides, slipped.z, stretch.z)};
  const T energy = T(0.5) * stiffness * dot(kept, kept);
  const T loss = spring.energy - energy - dt * dot(force, velocity);
  spring = {kept + T(a.ahead) * velocity, energy, T(1.0)};
  return {force, loss};
}

// A law is two functions. `normal` says what acts along the normal. `tangential` says what acts across it where the bodies are pressed
// together by `pressing` [N], its spring made softer by the factor `compliance`; it fills in the tangential force and loss and the
// stiffening. This makes one contact of them.
template <class Law, class T>
QUERN_INLINE ContactForce<T> act(const Law& law, const Approach<T>& a, TangentialSpring<T>& spring) {
  ContactForce<T> force{};
  NormalPart<T> part;
  law.normal(a, part);
  push(a, part.elastic, part.stiffness, part.damping, force);
  law.tangential(a, part, force.normal, 1.0, spring, force);
  force.elastic_energy = part.energy + spring.energy;
  return force;
}

// Fills in what `hold` answers.
template <class T>
QUERN_INLINE void take(const HeldForce<T>& held, const T& stiffening, ContactForce<T>& force) {
  force.tangential = held.force;
  force.tangential_loss = held.loss;
  force.stiffening = stiffening;
}

}  // namespace quern
