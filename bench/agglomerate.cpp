#include "bench/agglomerate.hpp"
#include <cmath>
#include "bench/scene.hpp"
#include "src/contact/restitution.hpp"
#include "src/particle/packing.hpp"

namespace bench {

using namespace quern;

State agglomerate_state(std::int64_t grains) {
  State state;
  state.diameter = grain_diameter;
  state.density = grain_density;
  const double radius = 0.5 * grain_diameter * std::cbrt(static_cast<double>(grains) / 0.54) + 0.25 * grain_diameter;
  PackingRequest request;
  request.region.shape = SphereRegion{radius};
  Portion portion;
  portion.sizes = SizeDistribution::mono(grain_diameter);
  portion.count = grains;
  request.portions = {portion};
  const Packing packing = pack_dense(request, {});
  double lowest = 1e300;
  for (const Vec3& x : packing.position) lowest = std::min(lowest, x.z());
  const Vec3 shift(0, 0, 0.51 * grain_diameter - lowest);
  for (const Vec3& x : packing.position) state.balls.push_back({x + shift, Vec3(0, 0, -impact_speed), Vec3::Zero()});
  state.lower = Vec3(-2 * radius, -2 * radius, -grain_diameter);
  state.upper = Vec3(2 * radius, 2 * radius, 2 * radius + 2 * grain_diameter);
  return state;
}

Simulation make_agglomerate(const Options& options, const State& state, double& gap) {
  Simulation s;
  const Material stone{"grain", state.density, grain_young, poisson};
  s.materials = {stone};
  s.species = {{"grain", 0}};
  s.pair_laws = {{HertzMindlin{effective_young(stone, stone), effective_shear(stone, stone), hertz_damping_ratio(restitution), friction}, {}, {}}};
  s.pair_kind = {0};
  s.gravity = Vec3(0, 0, -9.81);
  s.clock.time_step = agglomerate_time_step;
  Wall wall;
  wall.name = "floor";
  wall.surface = Plane{};
  s.walls = {wall};
  for (const Ball& ball : state.balls) {
    const auto row = static_cast<std::size_t>(s.particles.add_sphere(triple(ball.position), 0.5 * state.diameter, state.density, 0, 0));
    set(s.particles.velocity[row], ball.velocity);
  }
  BondMaterial cement;
  cement.name = "cement";
  cement.young = bond_young;
  cement.shear_modulus = bond_shear_modulus;
  cement.damping = {bond_damping, bond_damping, bond_damping, bond_damping};
  cement.strength.tensile = bond_tensile_strength;
  cement.strength.shear = bond_shear_strength;
  const double wanted = bonds_per_grain * static_cast<double>(state.balls.size());
  double low = 0, high = 0.5 * state.diameter;
  for (int k = 0; k < 20; ++k) {
    gap = 0.5 * (low + high);
    s.bonds = {};
    s.bonds.materials = {cement};
    (static_cast<double>(bond_particles_nearer_than(s.bonds, s.particles, s.domain, gap, 0, 1)) < wanted ? low : high) = gap;
  }
  use_machine(options, s);
  s.start(false);
  return s;
}

}  // namespace bench
