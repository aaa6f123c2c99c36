// The third work of the benchmark: a sphere of bonded grains that hits a wall, and breaks.
#pragma once
#include "bench/options.hpp"
#include "bench/state.hpp"
#include "src/engine/simulation.hpp"

namespace bench {

inline constexpr double grain_diameter = 2e-3;      // [m]
inline constexpr double grain_density = 2500;       // [kg/m³]
inline constexpr double grain_young = 1e9;          // [Pa]; Poisson's ratio, restitution and friction as in the other works
inline constexpr double bonds_per_grain = 3.4;
inline constexpr double bond_young = 1e9;           // [Pa]
inline constexpr double bond_shear_modulus = 4e8;   // [Pa]
inline constexpr double bond_tensile_strength = 5e6;  // [Pa]
inline constexpr double bond_shear_strength = 8e6;  // [Pa]
inline constexpr double bond_damping = 0.05;        // of critical
inline constexpr double impact_speed = 7.7;         // [m/s]
inline constexpr double agglomerate_time_step = 2e-7;  // [s]

// A dense sphere of grains, just above the wall z = 0 and on its way down.
State agglomerate_state(std::int64_t grains);
// Its simulation, bonded and started; `gap` [m] becomes that within which pairs are bonded for the wanted number of bonds.
quern::Simulation make_agglomerate(const Options& options, const State& state, double& gap);

}  // namespace bench
