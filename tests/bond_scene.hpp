// Bonded grains for tests.
#pragma once
#include <numbers>
#include "tests/scene.hpp"

namespace scene {

inline constexpr double spacing = 0.01;  // of the centres, L_0 [m]

inline BondMaterial cement(double young = 1e9, double shear_modulus = 3e8, double damping = 0) {
  BondMaterial m;
  m.name = "cement";
  m.young = young;
  m.shear_modulus = shear_modulus;
  m.damping = {damping, damping, damping, damping};
  return m;
}

// Grains that leave a gap between them, so that bonds act alone.
inline Simulation bonded_space(const BondMaterial& bond, double time_step) {
  Simulation s = free_space(glass(), linear(1e6, 0.7, 0.3), time_step);
  s.bonds.materials = {bond};
  return s;
}

inline Index add_grain(Simulation& s, const Vec3& centre) { return add_ball(s, triple(centre), 0.45 * spacing, {0, 0, 0}); }

// Makes a particle's mass and inertia endless.
inline void clamp(Simulation& s, Index id) {
  const std::size_t k = row_of(s, id);
  s.particles.acceleration[k].w = s.particles.angular_acceleration[k].w = 0;
  s.particles.velocity[k].w = 1e30;
  s.particles.spin[k].w = 1e30;
}

// A constant load on a particle, as velocity Verlet has it: call after start() with no step taken, then after each step.
inline void pull(Simulation& s, Index id, const Vec3& force, const Vec3& torque, bool stepped) {
  const std::size_t k = row_of(s, id);
  Particles& p = s.particles;
  const Vec3 a = p.acceleration[k].w * force, b = p.angular_acceleration[k].w * torque;
  add(p.acceleration[k], a);
  add(p.angular_acceleration[k], b);
  if (!stepped) return;
  add(p.velocity[k], Vec3(0.5 * s.clock.time_step * a));
  add(p.spin[k], Vec3(0.5 * s.clock.time_step * b));
}

inline void slow_all(Simulation& s, double rate) {
  const double factor = 1 - rate * s.clock.time_step;
  for (std::vector<Quad>* rows : {&s.particles.velocity, &s.particles.spin})
    for (Quad& q : *rows) q.x *= factor, q.y *= factor, q.z *= factor;
}

// Energy with which a bond fails in tension [J].
inline double failure_energy(const Bond& b) {
  return 0.5 * b.tensile_strength * b.tensile_strength / b.normal_stiffness * std::numbers::pi * b.radius * b.radius;
}

}  // namespace scene
