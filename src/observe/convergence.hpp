// How the interval of the collision spectrum narrows with the time that was sampled, and when it is narrow enough.
//
// At fixed intervals of simulated time E_i, the collision rate and their 95 % intervals are written down, as they would stand in the summary
// of a run that ended there. Where the case wants intervals of a certain width, the run ends once they are as narrow. An interval that is looked
// at again and again is at some moment too narrow by chance (Glynn & Whitt 1992, Ann. Appl. Prob. 2:180): so it must have been sampled for ten
// revolutions, and the intervals must stay narrow while a fifth is added to what was sampled when they became so.
#pragma once
#include <string>
#include "src/observe/spectrum.hpp"

namespace quern {

struct Convergence {
  std::vector<double> time, sampled;                          // [s]
  std::vector<double> impact_rate, impact_half;               // E_i and the half-width of its interval [W]
  std::vector<double> collision_rate, collision_half;         // [1/s]
  std::vector<double> widest_bin;                             // half-width over rate
  double next = 1;                                            // number of the next look
  double narrow_since = -1, narrow_sampled = 0;               // when the intervals became narrow, and what was sampled by then [s]; −1: they are not
  bool reached = false;                                       // what the settings want

  static constexpr double least_spans = 200, hold = 0.2;

  bool due(const Simulation& simulation, const ObserverSettings& settings) const;
  // Looks at what has been sampled since `start` [s]; only when due.
  void look(const Simulation& simulation, const CollisionSpectrum& spectrum, double start, const ObserverSettings& settings);

  // A clause with what was reached; empty before the first look.
  std::string widths() const;
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a) {
    a(time, sampled, impact_rate, impact_half, collision_rate, collision_half, widest_bin, next, narrow_since, narrow_sampled, reached);
  }
};

}  // namespace quern
