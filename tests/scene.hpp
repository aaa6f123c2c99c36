// Small simulations for tests.
#pragma once
#include "src/contact/restitution.hpp"
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"

namespace scene {

using namespace quern;

inline Material glass() { return {"glass", 2500, 7e10, 0.22}; }

inline PairLaw hertz(const Material& a, const Material& b, double restitution, double friction) {
  return {HertzMindlin{effective_young(a, b), effective_shear(a, b), hertz_damping_ratio(restitution), friction}, {}};
}

inline PairLaw linear(double stiffness, double restitution, double friction) {
  return {Linear{stiffness, 2.0 / 7.0 * stiffness, linear_damping_ratio(restitution), friction}, {}};
}

// Free space, one material, one law, no gravity.
inline Simulation free_space(const Material& material, const PairLaw& law, double time_step) {
  Simulation s;
  s.materials = {material};
  s.species = {{"ball", 0}};
  s.pair_laws = {law};
  s.pair_kind = {0};
  s.gravity = Vec3::Zero();
  s.clock.time_step = time_step;
  return s;
}

inline Index add_ball(Simulation& s, const Triple<double>& centre, double radius, const Triple<double>& velocity, const Triple<double>& spin = {0, 0, 0}) {
  const Index i = s.particles.add_sphere(centre, radius, s.materials[0].density, 0, 0);
  const auto k = static_cast<std::size_t>(i);
  s.particles.velocity[k] = {velocity.x, velocity.y, velocity.z, s.particles.velocity[k].w};
  s.particles.spin[k] = {spin.x, spin.y, spin.z, s.particles.spin[k].w};
  return i;
}

// A wall that fills z < 0.
inline void add_floor(Simulation& s) {
  Wall wall;
  wall.name = "floor";
  wall.surface = Plane{};
  s.walls.push_back(wall);
}

// A slice of 0.06 m of an endless drum of 0.2 m across gravity, turning about y at `speed` [rad/s], and its axis for observers.
inline MillAxis add_drum(Simulation& s, double speed) {
  s.gravity = {0, 0, -9.81};
  s.domain.period[1] = 0.06;
  s.frames = {{"mill", -1, Rotating{Vec3(0, 0, 0), Vec3::UnitY(), speed}}};
  Wall shell;
  shell.name = "shell";
  shell.surface = Revolved{0.1, -0.05, 0.1, 0.05, Revolved::Side::inside};
  shell.frame = 0;
  shell.rest.axes = Eigen::AngleAxisd(-1.5707963267948966, Vec3::UnitX()).toRotationMatrix();
  s.walls = {shell};
  MillAxis mill;
  mill.speed = speed, mill.radius = 0.1, mill.length = 0.06;
  return mill;
}

inline std::size_t row_of(const Simulation& s, Index id) {
  for (std::size_t k = 0; k < s.particles.id.size(); ++k)
    if (s.particles.id[k] == id) return k;
  return 0;
}

inline double kinetic_energy(Simulation& s) {
  s.measure_energy();
  return s.ledger.kinetic;
}

// Steps until nothing touches any more, after something has.
inline void run_collision(Simulation& s, int most_steps = 2000000) {
  bool touched = false;
  for (int k = 0; k < most_steps; ++k) {
    s.step();
    const bool touches = s.contacts.sums.pair_contacts + s.contacts.sums.wall_contacts > 0;
    touched |= touches;
    if (touched && !touches) return;
  }
}

}  // namespace scene
