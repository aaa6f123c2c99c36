// The whole of a breakage study: damage, probability of breakage and fineness of bodies against the specific energy of their impact.
#pragma once
#include <optional>
#include <string>
#include <vector>
#include "src/grinding/breakage_probability.hpp"
#include "src/grinding/saturation.hpp"

namespace quern {

// One run, or one row of a table: a body, or several of one energy, on a wall.
struct BreakageRun {
  double energy = 0;                  // ½ v² of the impact, per mass of the body [J/kg]
  std::optional<double> damage;       // bonds that failed over all that were made
  std::optional<double> t10;          // mass finer than a tenth of the body, over the whole
  int broken = 0, tested = 0;         // bodies; 0 tested: nothing is known
};

struct BreakageStudy {
  std::vector<BreakageRun> runs;
  double broken_below = 0.9;          // a body is broken if its largest fragment has less than this part of its mass
  std::optional<double> size;         // of the bodies [m]
  std::vector<std::string> remarks;   // plain sentences
};

struct BreakageResult {
  std::vector<Level> damage, t10;     // means and scatter at each energy
  std::vector<BreakageCount> counts;
  // The threshold as it was seen: the largest energy at which no run had any damage below the first with some, and that first one.
  std::optional<double> last_unharmed, first_harmed;
  std::optional<SaturationFit> damage_fit, t10_fit;
  std::optional<BreakageFit> vogel_peukert, weibull;
  bool plateau_reached = false;       // by the damage
  bool t10_bends = false;             // far enough that A can be told from b
  std::vector<std::string> remarks;
};

// Damage: P (1 − exp(−((W − W_0)/W_s)^m)), m fitted from six energies on and 1 with four or five. t10 = A (1 − exp(−b W)) (Narayanan & Whiten
// 1988, Trans. Inst. Min. Metall. C 97:115). Where runs cannot tell something it is left out and a remark says why.
BreakageResult study_breakage(const BreakageStudy& study);

}  // namespace quern
