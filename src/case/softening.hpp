// Whether softer contacts change what a case tells: the softer case, and its results beside those of the case as it is. Nothing here runs
// a simulation.
//
// Power, angles and spectra of a charge hardly know how stiff its contacts are as long as overlaps stay small (Lommen, Schott & Lodewijks
// 2014, Particuology 12:107, have two processes that do not and one that does); the time step does. So: measure, case by case.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>
#include "src/case/case.hpp"
#include "src/observe/difference.hpp"

namespace quern {

// Divides every Young's modulus and every given contact stiffness by `factor` and leaves each law's restitution at every speed
// as it is: dampings that a case gives as such shrink with the stiffness, q ∝ k^((1+s)/(r+1)) for k δ^r + q δ^s v.
void soften(Case& c, double factor);
// The overrides that do so.
std::vector<std::string> softened(const Case& c, double factor);

inline constexpr double soft_tolerance = 0.05;        // of its value, or radians of an angle, by which an output may differ and count as the same
inline constexpr double exact_tolerance = 0.01;       // the same for few bodies, whose runs repeat exactly
inline constexpr double greatest_sound_overlap = 0.05;  // over the radius; our choice: above, neighbours of one ball begin to feel each other through it

enum class SoftVerdict {
  moves, moves_little, same, unknown,  // as Verdict
  by_nature,                           // overlap, duration and peak force of contacts follow from the stiffness
  no_interval,                         // nothing tells how far chance alone moves it
};
std::string words_of(SoftVerdict verdict);

struct SoftRow {
  std::string key, unit, description;
  Estimate as_is, softer, difference;  // in `unit`
  double scale = 1;                    // what the tolerance is a fraction of, in `unit`
  double tolerance = soft_tolerance;   // of scale
  SoftVerdict verdict = SoftVerdict::unknown;
  double longer = 1;                   // times as long the run must be to tell, where unknown
};

struct SoftRun {
  double time_step = 0, limit = 0;  // [s]
  double steps = 0, wall_clock = 0;  // [1], [s]
  double closure = 0;               // of the energy ledger
  std::optional<double> overlap;    // greatest, over the radius
};

struct SoftReport {
  double factor = 1;
  bool exact = false;  // few bodies: no chance in the results
  SoftRun as_is, softer;
  std::vector<SoftRow> rows;
  std::vector<std::string> warnings;
};

// Fills rows, warnings and what the summaries tell of the runs, from the directories of the two finished runs; factor, exact and the steps are
// the caller's. Throws InputError where results are not there.
void compare(SoftReport& report, const std::string& as_is, const std::string& softer);

std::string softening_sentence(const SoftReport& report);  // what may be done, and what it costs
std::string softening_table(const SoftReport& report);     // for a terminal; outputs in groups by verdict
std::string softening_csv(const SoftReport& report);
std::string softening_json(const SoftReport& report);

}  // namespace quern
