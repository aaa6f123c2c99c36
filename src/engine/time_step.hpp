// The largest sound time step (physics §9) and what sets it.
#pragma once
#include <string>
#include "src/engine/simulation.hpp"

namespace quern {

struct TimeStepLimit {
  double limit = 0;        // no case may ask for more, unless it says it is unsafe [s]
  double recommended = 0;  // what a case gets that asks for nothing [s]
  std::string reason;      // what sets the limit, in words: the criterion, the pair and the particle
};

// Least over all species and pair laws present:
//   Hertzian laws: `fraction` (0.1 … 0.3) of the Rayleigh time t_R = π R √(ρ/G) / (0.1631 ν + 0.8766); the limit is 0.3 t_R
//   all laws:      a twentieth of the shortest head-on collision at `speed` [m/s] through the law itself; a fortieth is recommended
//   damped laws:   a fifth of m*/c, the time in which the dashpot alone stops the approach; a fifteenth is recommended
//   linear laws:   0.2 √(m/k) of the lightest particle (S0 eq. 14)
//   bonds:         √(m/Σk) and √(I/Σk_rot) of each grain over its bonds (S2 eq. 1.14–1.15): 0.4 of the least; 0.2 is recommended. A
//                  velocity Verlet step becomes unstable at √2 of it, where all of a grain's neighbours move against it.
//   fields:        a fifth of the time in which a drag or a tabulated force changes the motion (m/(dF/dv), or √(m/(dF/dx))) of the
//                  smallest ball at `speed`; a twentieth is recommended. The step becomes unstable at the whole of it.
TimeStepLimit time_step_limit(const Simulation& simulation, double speed, double fraction = 0.2);

double rayleigh_time(double radius, const Material& material);

}  // namespace quern
