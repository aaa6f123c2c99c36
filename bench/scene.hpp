// The first two works of the benchmark, built straight on the library. All codes get these numbers.
#pragma once
#include "bench/options.hpp"
#include "bench/state.hpp"
#include "src/engine/simulation.hpp"

namespace bench {

inline constexpr double ball_diameter = 10e-3;   // [m]
inline constexpr double density = 7800;          // [kg/m³]
inline constexpr double young = 1e8;             // [Pa]
inline constexpr double poisson = 0.3;
inline constexpr double restitution = 0.6;
inline constexpr double friction = 0.5;
inline constexpr double time_step = 4.8e-5;      // [s]
inline constexpr double drum_diameter = 0.5;     // [m]
inline constexpr double drum_filling = 0.4;
inline constexpr double speed_fraction = 0.7;    // of the critical speed
inline constexpr double bed_width = 0.3;         // [m], both ways

// Length at which so many balls fill the drum as wanted (bulk porosity 0.4) [m].
double drum_length(std::int64_t balls);
// 0.7 √(2 g / (D − d)) [rad/s].
double drum_speed();

// Balls that touch nothing yet. Throws quern::InputError if they do not fit.
State packed_state(const Options& options);
// The drum's state several times along its axis, positions changed by a few nanometres so that the copies go their own ways.
State repeated(const State& state, std::int64_t copies);

// A simulation that begins with this state; started.
quern::Simulation make_scene(const Options& options, const State& state);
State state_of(const quern::Simulation& simulation, const State& like);

// Threads and instruction set. Throws InputError if this processor lacks the latter.
void use_machine(const Options& options, quern::Simulation& simulation);

}  // namespace bench
