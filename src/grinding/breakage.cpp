#include "src/grinding/breakage.hpp"
#include <fmt/format.h>
#include <algorithm>

namespace quern {
namespace {

std::string joules(double energy) { return fmt::format("{:.4g} J/kg", energy); }

std::vector<Level> levels_of_runs(const BreakageStudy& study, std::optional<double> BreakageRun::*what) {
  std::vector<double> x, y;
  for (const BreakageRun& run : study.runs)
    if (run.*what) x.push_back(run.energy), y.push_back(*(run.*what));
  return levels_of(x, y);
}

std::vector<BreakageCount> counts_of(const BreakageStudy& study) {
  std::vector<const BreakageRun*> runs;
  for (const BreakageRun& run : study.runs)
    if (run.tested > 0) runs.push_back(&run);
  std::stable_sort(runs.begin(), runs.end(), [](const BreakageRun* a, const BreakageRun* b) { return a->energy < b->energy; });
  constexpr double rounding = 1e-9;
  std::vector<BreakageCount> counts;
  for (const BreakageRun* run : runs) {
    if (counts.empty() || run->energy > counts.back().energy * (1 + rounding)) counts.push_back({run->energy, 0, 0});
    counts.back().broken += run->broken, counts.back().tested += run->tested;
  }
  return counts;
}

void warn_of_misfit(const std::optional<double>& p, const std::string& what, std::vector<std::string>& remarks) {
  constexpr double doubtful = 0.01;
  if (p && *p < doubtful) remarks.push_back(fmt::format("{} misses its law by more than the scatter (p {:.2g}): the intervals do not hold what the law leaves out.", what, *p));
}

void study_damage(BreakageResult& result) {
  const std::vector<Level>& levels = result.damage;
  if (levels.empty()) {
    result.remarks.push_back("Damage: no column damage_ratio, so nothing is said of it.");
    return;
  }
  const auto most = std::max_element(levels.begin(), levels.end(), [](const Level& a, const Level& b) { return a.mean < b.mean; });
  if (most->mean <= 0) {
    result.last_unharmed = levels.back().x;
    result.remarks.push_back(fmt::format("Damage: no bond failed in any run; the threshold lies above {}.", joules(levels.back().x)));
    return;
  }
  // A mean of 0 of numbers that are none of them negative: every one is 0.
  for (const Level& level : levels)
    if (level.mean > 0) {
      result.first_harmed = level.x;
      break;
    } else {
      result.last_unharmed = level.x;
    }
  constexpr std::size_t for_law = 4, for_shape = 6;
  if (levels.size() < for_law) {
    result.remarks.push_back(fmt::format("Damage: {} energ{} cannot tell threshold, rise and plateau apart; {} are needed.", levels.size(), levels.size() == 1 ? "y" : "ies", for_law));
    return;
  }
  result.damage_fit = fit_saturation(levels, {true, levels.size() >= for_shape, 1, *result.first_harmed});
  const SaturationFit& fit = *result.damage_fit;
  if (!result.last_unharmed)
    result.remarks.push_back(fmt::format("Damage: even the least energy, {}, broke bonds; the fitted threshold is an extrapolation.", joules(levels.front().x)));
  constexpr double reached = 0.9;
  result.plateau_reached = fit.law.plateau > 0 && fit.law.at(levels.back().x) >= reached * fit.law.plateau;
  if (!result.plateau_reached)
    result.remarks.push_back(fmt::format("Damage: at the largest energy, {}, it has come to {:.0f} % of the fitted plateau only; the plateau is an extrapolation.", joules(levels.back().x),
                                         100 * fit.law.at(levels.back().x) / fit.law.plateau));
  if (fit.redrawn.empty()) result.remarks.push_back("Damage: without repeats and with as many parameters as energies there are no intervals; more seeds or speeds give them.");
  warn_of_misfit(fit.p_of_law, "Damage", result.remarks);
}

void study_probability(const BreakageStudy& study, BreakageResult& result) {
  const std::vector<BreakageCount>& counts = result.counts;
  const std::string broken = fmt::format("largest fragment below {:g} of the mass", study.broken_below);
  if (counts.empty()) {
    result.remarks.push_back("Probability of breakage: no column largest_fragment_fraction or broken of single bodies, so nothing is said of it.");
    return;
  }
  int tested = 0;
  for (const BreakageCount& c : counts) tested += c.tested;
  const BreakageCount &first = counts.front(), &last = counts.back();
  switch (evidence_of(counts)) {
    case BreakageEvidence::none_broke:
      result.remarks.push_back(fmt::format("Probability of breakage: none of {} bodies broke ({}). At {} it is at most {:.2g} (95 %); no law can be fitted.", tested, broken, joules(last.energy),
                                           proportion_interval(0, last.tested)[1]));
      return;
    case BreakageEvidence::all_broke:
      result.remarks.push_back(fmt::format("Probability of breakage: all of {} bodies broke ({}). At {} it is at least {:.2g} (95 %); no law can be fitted.", tested, broken, joules(first.energy),
                                           proportion_interval(first.tested, first.tested)[0]));
      return;
    case BreakageEvidence::one_level: {
      const Interval95 s = proportion_interval(first.broken, first.tested);
      result.remarks.push_back(fmt::format("Probability of breakage: {} of {} bodies broke ({}), {:.2g} to {:.2g} (95 %); one energy gives no law.", first.broken, first.tested, broken, s[0], s[1]));
      return;
    }
    case BreakageEvidence::step: {
      const auto next = std::find_if(counts.begin(), counts.end(), [](const BreakageCount& c) { return c.broken > 0; });
      const double from = next == counts.begin() ? 0 : std::prev(next)->energy;
      result.remarks.push_back(next->broken == next->tested
                                   ? fmt::format("Probability of breakage: every body is whole up to {} and broken from {} on ({}). How it rises between cannot be told; energies between them, or more seeds, would tell.",
                                                 joules(from), joules(next->energy), broken)
                                   : fmt::format("Probability of breakage: bodies broke and stayed whole at {} only ({}); how steep it is cannot be told.", joules(next->energy), broken));
      return;
    }
    case BreakageEvidence::enough: break;
  }
  result.vogel_peukert = fit_breakage(counts, BreakageLaw::vogel_peukert);
  result.weibull = fit_breakage(counts, BreakageLaw::weibull);
  warn_of_misfit(result.vogel_peukert->p_of_law, "Probability of breakage by Vogel & Peukert", result.remarks);
  warn_of_misfit(result.weibull->p_of_law, "Probability of breakage by Weibull", result.remarks);
  if (!(result.vogel_peukert->second_ci95[0] > 0))
    result.remarks.push_back(fmt::format("Probability of breakage: W_min is at most {}, and may be none.", joules(result.vogel_peukert->second_ci95[1])));
}

void study_t10(BreakageResult& result) {
  const std::vector<Level>& levels = result.t10;
  if (levels.empty()) {
    result.remarks.push_back("t10: not there; it needs the column t10, and grains smaller than a tenth of the body.");
    return;
  }
  if (std::all_of(levels.begin(), levels.end(), [](const Level& level) { return level.mean <= 0; })) {
    result.remarks.push_back(fmt::format("t10: nothing got finer than a tenth of the body, up to {}.", joules(levels.back().x)));
    return;
  }
  if (levels.size() < 2) {
    result.remarks.push_back("t10: one energy cannot tell A and b apart; two are needed.");
    return;
  }
  result.t10_fit = fit_saturation(levels, {});
  const SaturationFit& fit = *result.t10_fit;
  const auto plateau = fit.interval([](const SaturationLaw& law) { return law.plateau; });
  constexpr double known = 3;  // A to a factor
  result.t10_bends = plateau ? (*plateau)[1] < known * (*plateau)[0] : fit.law.plateau < 1;
  if (!result.t10_bends) result.remarks.push_back("t10: it rises nearly in proportion to the energy, so that only the slope A b is known; larger energies would tell A and b apart.");
  if (fit.redrawn.empty()) result.remarks.push_back("t10: without repeats and with two energies there are no intervals; more seeds or speeds give them.");
  warn_of_misfit(fit.p_of_law, "t10", result.remarks);
}

}  // namespace

BreakageResult study_breakage(const BreakageStudy& study) {
  BreakageResult result;
  result.remarks = study.remarks;
  result.damage = levels_of_runs(study, &BreakageRun::damage);
  result.t10 = levels_of_runs(study, &BreakageRun::t10);
  result.counts = counts_of(study);
  study_damage(result);
  study_probability(study, result);
  study_t10(result);
  return result;
}

}  // namespace quern
