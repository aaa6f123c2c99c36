#include "src/diagnose/investigation.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace quern {
namespace {

constexpr double second_look = 0.05;        // what is left of the winner asks whether a second effect acts
constexpr double beyond_doubt = 1e-8;       // what is left of it is no little
constexpr double left_level = 0.001;        // what is left of it refutes it
constexpr double alike_odds = 3.0;          // ln of odds within which a rival is not ruled out
// Before any data: that nothing is missing, that one known effect is, that something unknown is, that two are.
constexpr double prior_none = 0.45, prior_one = 0.40, prior_unknown = 0.12, prior_two = 0.03;

}  // namespace

double Investigation::effects_count() const {
  std::set<std::string> names;
  for (const Candidate& c : candidates_) names.insert(c.effect);
  return std::max<double>(1, static_cast<double>(names.size()));
}

double Investigation::log_prior(const Candidate& c) const {
  if (c.free_form) return std::log(prior_unknown / std::max<double>(1, static_cast<double>(free_forms_)));
  double forms = 0;
  for (const Candidate& other : candidates_) forms += other.effect == c.effect ? 1 : 0;
  // Stokes' law far beyond its Reynolds numbers would be a wonder.
  const double wonder = c.effect != "viscous_drag" ? 0 : reynolds_ > 5e4 ? 15 : reynolds_ > 1e3 ? 2 : 0;
  return std::log(prior_one / effects_count() / std::max(1.0, forms)) - wonder;
}

double Investigation::strangeness(const Fit& fit) {
  constexpr double usual = 0.05;
  double sum = 0;
  for (std::size_t k = 0; k < fit.moved.size(); ++k)
    if (fit.moved[k].path.front() == "instrument" && fit.moved[k].path.back() == "gain") {
      const double off = std::log(fit.shared[k]) / usual;
      sum += 0.5 * off * off;
    }
  return sum;
}

void Investigation::weigh() {
  double most = std::log(prior_none);
  const auto weight = [&](const Tried& t) { return -0.5 * t.bic - strangeness(t.fit) + (t.effects.size() > 1 ? std::log(prior_two / effects_count()) : log_prior(t.candidate)); };
  for (const Tried& t : d_.ranking) most = std::max(most, weight(t));
  double sum = prior_none * std::exp(-most);
  for (Tried& t : d_.ranking) t.probability = std::exp(weight(t) - most), sum += t.probability;
  for (Tried& t : d_.ranking) t.probability /= sum;
  std::stable_sort(d_.ranking.begin(), d_.ranking.end(), [](const Tried& a, const Tried& b) { return a.probability > b.probability; });
}

void Investigation::hold_out(Tried& tried) {
  if (split_.select.empty() || split_.fit.empty() || !tried.held_out_runs.empty()) return;
  const FitOptions options = noise_given();
  if (!select_baseline_) {
    const Fit part = comparison_.fit(free_, {}, split_.fit, &d_.baseline, options);
    select_baseline_ = comparison_.carry_over(part, split_.select);
  }
  const Fit part = comparison_.fit(tried.fit.moved, tried.fit.settings, split_.fit, &tried.fit, options);
  const Fit there = comparison_.carry_over(part, split_.select);
  note("held out: " + tried.effects.front(), there);
  tried.held_out = comparison_.misfit(there, there.noise);
  tried.held_out_runs = comparison_.log_likelihoods(there, there.noise);
  tried.held_out_gain = std::accumulate(tried.held_out_runs.begin(), tried.held_out_runs.end(), 0.0) - comparison_.log_likelihood(*select_baseline_, there.noise);
}

bool Investigation::tells_more(Tried& more, Tried& less) {
  hold_out(more), hold_out(less);
  const std::size_t runs = more.held_out_runs.size();
  if (runs == 0 || less.held_out_runs.size() != runs) return more.bic < less.bic - 6;
  double sum = 0, square = 0;
  for (std::size_t r = 0; r < runs; ++r) {
    const double one = more.held_out_runs[r] - less.held_out_runs[r];
    sum += one, square += one * one;
  }
  const double n = static_cast<double>(runs), spread = runs > 2 ? std::sqrt(std::max(0.0, square - sum * sum / n) * n / (n - 1)) : 0;
  return sum > std::max(2.0, 2 * spread);
}

Tried* Investigation::best_single() {
  for (Tried& t : d_.ranking)
    if (!t.candidate.free_form && !t.candidate.rival && t.effects.size() == 1) return &t;
  return nullptr;
}

const Tried* Investigation::best_named() const {
  for (const Tried& t : d_.ranking)
    if (!t.candidate.free_form && !t.candidate.rival) return &t;
  return nullptr;
}

const Tried* Investigation::best_free() const {
  for (const Tried& t : d_.ranking)
    if (t.candidate.free_form) return &t;
  return nullptr;
}

double Investigation::probability_of(bool free_form) const {
  double sum = 0;
  for (const Tried& t : d_.ranking)
    if (!t.candidate.rival && t.candidate.free_form == free_form) sum += t.probability;
  return sum;
}

void Investigation::choose() {
  if (!still_refuted()) {
    d_.best = d_.baseline;
    return nothing_more();
  }
  if (d_.ranking.empty()) return unexplained(nullptr);
  const Tried* named = best_named();
  if (named == nullptr) return unexplained(best_free());
  if (experiment_.steps.soft()) {
    settle_softness(named->fit);
    named = best_named();
  }
  // What the best name leaves is told by simulations: once for each that comes to be the best.
  Remainder left;
  const auto look_at_best = [&] {
    named = best_named();
    left = remainder_of(*named);
    d_.remaining_p = left.p;
  };
  look_at_best();
  const auto better_free = [&] { return probability_of(true) > probability_of(false); };
  if (d_.remaining_p < second_look) {
    try_by_body();
    settle_noise();
    look_at_best();
  }
  if (d_.remaining_p < second_look || better_free()) {
    try_pairs();
    look_at_best();
  }
  for (std::size_t k = 0; k < std::min<std::size_t>(4, d_.ranking.size()); ++k) hold_out(d_.ranking[k]);
  named = best_named();
  if (named->bic > -2) return unexplained(best_free());
  // What one effect leaves may be too little to show in runs that were not fitted: then it is told, and nothing is built on it.
  bool little_left = false;
  if (Tried* single = best_single(); single != nullptr && (named->effects.size() > 1 || d_.remaining_p < left_level || better_free())) {
    constexpr double most_of_it = 0.9;
    double greatest = single->gain + (single == named ? left : remainder_of(*single)).gain;
    for (const Tried& t : d_.ranking) greatest = std::max(greatest, t.gain);
    bool more = single->gain < most_of_it * greatest || d_.remaining_p < beyond_doubt;
    for (std::size_t k = 0; k < std::min<std::size_t>(3, d_.ranking.size()) && !more; ++k) more = &d_.ranking[k] != single && tells_more(d_.ranking[k], *single);
    if (!more) little_left = true, named = single;
  }
  if (!little_left && (d_.remaining_p < left_level || better_free())) return unexplained(best_free());
  d_.verdict = Verdict::omitted_physics;
  d_.effects = named->effects;
  d_.form = named->candidate.form;
  d_.best = named->fit;
  tell_bodies(*named);
  look_alikes(*named);
  // A name that leaves something is a little less certain.
  if (little_left) {
    double alone = 0, all = 0;
    for (const Tried& t : d_.ranking)
      if (!t.candidate.free_form && t.effects.size() == 1) (t.effects == d_.effects ? alone : all) += t.probability;
    d_.confidence = alone > 0 ? (d_.remaining_p < left_level ? 0.5 : 0.85) * alone / (alone + all) : 0.3;
    d_.remarks.push_back("Something small is left that the noise does not explain; it does not help to tell runs that were not fitted.");
  } else if (d_.remaining_p < second_look) {
    d_.confidence *= d_.remaining_p < family_level ? 0.6 : 0.85;
  }
}

void Investigation::tell_bodies(const Tried& winner) {
  std::vector<std::string> with, without;
  for (std::size_t k = 0; k < winner.fit.moved.size(); ++k) {
    const Parameter& p = winner.fit.moved[k];
    if (p.runs.empty()) continue;
    const bool needed = std::abs(winner.fit.shared[k] - p.value) > 2.6 * winner.fit.deviation(k) && winner.fit.shared[k] > p.lower;
    (needed ? with : without).push_back(p.name.substr(p.name.find('@') + 1));
  }
  if (!with.empty()) d_.remarks.push_back(fmt::format("Needed by {}{}.", fmt::join(with, ", "), without.empty() ? "" : fmt::format("; not seen in {}", fmt::join(without, ", "))));
}

void Investigation::look_alikes(const Tried& winner) {
  double own = 0;
  std::map<std::string, double> others;
  const std::set<std::string> names(winner.effects.begin(), winner.effects.end());
  for (const Tried& t : d_.ranking) {
    if (t.candidate.free_form || t.candidate.rival) continue;
    if (std::set<std::string>(t.effects.begin(), t.effects.end()) == names) {
      own += t.probability;
      continue;
    }
    // As many effects, of which all but one are the same.
    std::vector<std::string> instead;
    for (const std::string& effect : t.effects)
      if (names.count(effect) == 0) instead.push_back(effect);
    if (t.effects.size() == winner.effects.size() && instead.size() == 1) others[instead.front()] += t.probability;
  }
  d_.confidence = own;
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [name, probability] : others)
    if (probability > own * std::exp(-alike_odds)) order.push_back({-probability, name});
  std::sort(order.begin(), order.end());
  for (const auto& [probability, name] : order) d_.indistinguishable.push_back(name);
  for (const Tried& t : d_.ranking)
    if (t.candidate.rival && t.probability > winner.probability * std::exp(-alike_odds))
      d_.remarks.push_back(fmt::format("{} ({}) would do as well; the case calls it known.", t.candidate.effect, t.candidate.form));
  const auto tried_as = [&](const std::string& effect) {
    return std::find_if(d_.ranking.begin(), d_.ranking.end(), [&](const Tried& t) { return t.effects == std::vector<std::string>{effect}; });
  };
  if (const auto linear = tried_as("viscous_drag"); d_.effects == std::vector<std::string>{"air_drag"} && linear != d_.ranking.end() && reynolds_ > 1e3)
    d_.remarks.push_back(fmt::format("A drag that is linear in the speed fits {} (ln of likelihood {:+.1f}); at Reynolds numbers of {:.0e} that would speak of the recording's scale, not of Stokes.",
                                     linear->gain > winner.gain ? "better" : "worse", linear->gain - winner.gain, reynolds_));
  if (winner.candidate.form.find("beside") != std::string::npos)
    d_.remarks.push_back("The scale of the recording bends as well, in the same way for all runs; for one body alone that and the effect could not be told apart.");
  if (const auto gravity = tried_as("gravity"); gravity != d_.ranking.end())
    d_.remarks.push_back(fmt::format("Setting gravity free instead would leave {:.1f} of ln likelihood unexplained (g = {:.3g} m/s²).", winner.gain - gravity->gain, gravity->fit.shared.back()));
  if (!d_.indistinguishable.empty())
    if (const EffectEntry* entry = find_effect(d_.effects.front()))
      d_.advice = fmt::format("To part {} from {}: {}.", d_.effects.front(), fmt::format("{}", fmt::join(d_.indistinguishable, ", ")), entry->experiment);
}

void Investigation::unexplained(const Tried* free) {
  d_.verdict = Verdict::unexplained;
  d_.effects.clear();
  if (free != nullptr) d_.best = free->fit, d_.form = free->candidate.form;
  double named = 0;
  for (const Tried& t : d_.ranking)
    if (!t.candidate.free_form && !t.candidate.rival) named = std::max(named, t.probability);
  d_.confidence = std::clamp(1 - named * std::min(1.0, d_.remaining_p / left_level), 0.5, 0.97);
  if (const Tried* best = best_named())
    d_.remarks.push_back(fmt::format("The nearest known effect, {}, leaves structure that noise would leave with a probability of {:.2g}.", fmt::join(best->effects, " with "), d_.remaining_p));
}

}  // namespace quern
