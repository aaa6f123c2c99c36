// Collisions of pairs with effects.
#pragma once
#include "tests/scene.hpp"

namespace effect_scene {

using namespace quern;

constexpr double radius = 0.005;
inline double ball_mass() { return 4.18879020478639 * scene::glass().density * radius * radius * radius; }

// A glass ball about to hit a floor of glass.
inline Simulation above_floor(const PairLaw& pair, double speed, double time_step, double gap_steps = 2.7) {
  Simulation s = scene::free_space(scene::glass(), pair, time_step);
  scene::add_floor(s);
  scene::add_ball(s, {0, 0, radius + gap_steps * speed * time_step + pair.extras.reach(radius, radius)}, radius, {0, 0, -speed});
  return s;
}

struct Bounce {
  double restitution, peak_force, least_force, peak_overlap, closure, loss;
};

// The whole of a head-on collision with the floor, in `divisions` steps.
inline Bounce bounce(const PairLaw& pair, double speed, double divisions = 400) {
  Simulation s = above_floor(pair, speed, collide_head_on(pair, radius, ball_mass(), speed).duration / divisions);
  s.start(false);
  const double before = scene::kinetic_energy(s);
  Bounce b{};
  bool touched = false;
  for (int k = 0; k < 400 * divisions; ++k) {
    s.step();
    const bool touches = s.contacts.sums.wall_contacts > 0;
    touched |= touches;
    if (touched && !touches) break;
    b.peak_force = std::max(b.peak_force, -s.walls[0].force.z);
    b.least_force = std::min(b.least_force, -s.walls[0].force.z);
    b.peak_overlap = std::max(b.peak_overlap, radius - s.particles.position[0].z);
  }
  const double after = scene::kinetic_energy(s);
  b.restitution = s.particles.velocity[0].z / speed;
  b.closure = (before - after - s.ledger.dissipated() - s.ledger.elastic) / before;
  b.loss = before - after;
  return b;
}

inline double hertz_stiffness() { return 4.0 / 3.0 * effective_young(scene::glass(), scene::glass()) * std::sqrt(radius); }

inline std::string pack_of(const Simulation& s) {
  std::string bytes;
  for (const auto* rows : {&s.particles.position, &s.particles.velocity, &s.particles.spin})
    bytes.append(reinterpret_cast<const char*>(rows->data()), rows->size() * sizeof(Quad));
  return bytes;
}

}  // namespace effect_scene
