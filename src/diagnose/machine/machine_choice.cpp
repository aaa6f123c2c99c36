#include "src/diagnose/machine/machine_investigation.hpp"
#include <Eigen/QR>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include "src/diagnose/catalogue.hpp"

namespace quern {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr const char* smooth_changes = "smooth changes of each channel with the conditions";

}  // namespace

Explanation MachineInvestigation::explain_by(const std::vector<const MachineCandidate*>& which, int rounds, const std::vector<VectorXd>& also) {
  Explanation e;
  std::vector<MachineParameter> parameters = free_;
  for (const MachineCandidate* c : which) {
    parameters.push_back(c->parameter);
    e.effects.push_back(c->effect);
    e.form += (e.form.empty() || c->form.empty() ? "" : ", ") + c->form;
    e.rival |= c->rival;
  }
  const auto n = static_cast<Row>(parameters.size()), f = static_cast<Row>(free_.size());
  std::vector<VectorXd> from = also;
  for (const double strength : {0.02, 0.3, 1.0}) {
    VectorXd z = VectorXd::Zero(n);
    z.head(f) = baseline_.z;
    z.tail(n - f).setConstant(strength);
    from.push_back(z);
    if (which.size() == 1 && which.front()->parameter.lower < which.front()->parameter.null && which.front()->parameter.upper > which.front()->parameter.null) {
      z.tail(n - f).setConstant(-strength);
      from.push_back(z);
    }
  }
  const std::string what = fmt::format("{}", fmt::join(e.effects, " and "));
  e.fit = settled(parameters, from, what, rounds);
  rate(e);
  return e;
}

void MachineInvestigation::rate(Explanation& e) const {
  e.gain = e.fit.log_likelihood - baseline_.log_likelihood;
  e.bic = -2 * e.gain + static_cast<double>(e.fit.moved.size() - free_.size()) * std::log(std::max(2.0, static_cast<double>(numbers_)));
}

double MachineInvestigation::free_form_bic() const {
  const WhiteRest w = whitened(baseline_);
  const std::vector<Filter> all = filters_about(baseline_, w);
  MatrixXd columns(w.rest.size(), static_cast<Row>(all.size() - candidates_.size()));
  for (Row k = 0; k < columns.cols(); ++k) columns.col(k) = all[candidates_.size() + static_cast<std::size_t>(k)].unit;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  const double gain = w.rest.squaredNorm() - (w.rest - columns * qr.solve(w.rest)).squaredNorm();
  return -gain + static_cast<double>(qr.rank()) * std::log(std::max(2.0, static_cast<double>(w.rest.size())));
}

void MachineInvestigation::weigh() {
  std::map<std::string, int> forms;
  std::set<std::string> names;
  for (const MachineCandidate& c : candidates_) ++forms[c.effect], names.insert(c.effect);
  const double count = std::max<double>(1, static_cast<double>(names.size()));
  const auto weight = [&](const Explanation& e) {
    const double prior = e.free_form ? std::log(prior_unknown) : e.effects.size() > 1 ? std::log(prior_two / (count * (count - 1) / 2)) : std::log(prior_one / count / forms[e.effects.front()]);
    double strange = 0;
    for (std::size_t k = 0; k < e.fit.moved.size() && !e.free_form; ++k)  // instruments are calibrated: wrong by some hundredths, not by half
      if (e.fit.moved[k].acts == MachineParameter::Acts::gain) strange += 0.5 * std::pow(std::log(std::max(1e-3, e.fit.value(k))) / 0.05, 2);
    return -0.5 * e.bic - strange + prior;
  };
  double most = std::log(prior_none);
  for (const Explanation& e : tried_) most = std::max(most, weight(e));
  double sum = prior_none * std::exp(-most);
  for (Explanation& e : tried_) e.probability = std::exp(weight(e) - most), sum += e.probability;
  for (Explanation& e : tried_) e.probability /= sum;
  std::stable_sort(tried_.begin(), tried_.end(), [](const Explanation& a, const Explanation& b) { return a.probability > b.probability; });
}

Explanation* MachineInvestigation::best_named() {
  for (Explanation& e : tried_)
    if (!e.free_form && !e.rival) return &e;
  return nullptr;
}

void MachineInvestigation::hold_out(Explanation& e) const {
  if (select_.empty() || fit_.empty() || e.free_form) return;
  const auto told_of = [&](const std::vector<MachineParameter>& parameters, const VectorXd& from) {
    const MachineFit part = model_.fit(parameters, fit_, {from}, 1e3);
    return model_.tell(parameters, part.z, select_);
  };
  const MachineTold with = told_of(e.fit.moved, e.fit.z), without = told_of(free_, baseline_.z);
  e.held_out = model_.misfit(with);
  e.held_out_gain = model_.log_likelihood(with) - model_.log_likelihood(without);
}

double MachineInvestigation::chance_of_gain() const {
  double most = 0;
  int count = 0;
  for (const Explanation& e : tried_)
    if (!e.rival && !e.free_form && e.effects.size() == 1) most = std::max(most, e.gain), ++count;
  return std::min(1.0, count * normal_above(std::sqrt(2 * most)));
}

void MachineInvestigation::explain() {
  tried_.clear();
  for (const MachineCandidate& c : candidates_)
    if (!c.parameter.simulated() || c.parameter.dimension >= 0) tried_.push_back(explain_by({&c}, 0));
  weigh();
  // Filters look from where the calibration has come to rest; an explanation may lie far from there.
  if (std::min(d_.adequacy_p, chance_of_gain()) > family_level) return nothing_more();
  refine_best(3);
  d_.adequacy_p = std::min(d_.adequacy_p, chance_of_gain());
  if (d_.adequacy_p > family_level) return nothing_more();
  const auto look = [&] {
    const Explanation* named = best_named();
    d_.remaining_p = named != nullptr ? left_over(named->fit) : 0;
  };
  look();
  if (d_.remaining_p < family_level) {
    try_pairs();
    look();
  }
  Explanation smooth;
  smooth.effects = {"unknown"}, smooth.form = smooth_changes, smooth.free_form = true;
  smooth.fit = baseline_, smooth.bic = free_form_bic();
  tried_.push_back(smooth);
  weigh();
  for (std::size_t k = 0; k < std::min<std::size_t>(4, tried_.size()); ++k) hold_out(tried_[k]);
  choose();
}

void MachineInvestigation::refine_best(std::size_t count) {
  for (int round = 0; round < 2; ++round) {
    std::size_t seen = 0;
    bool changed = false;
    for (std::size_t k = 0; k < tried_.size() && seen < count; ++k) {
      Explanation& e = tried_[k];
      if (e.free_form || (e.bic > tried_.front().bic + 12 && k > 0)) continue;
      ++seen;
      const std::size_t before = model_.runs_made();
      std::vector<const MachineCandidate*> which = candidates_of(e);
      Explanation again = explain_by(which, 2, {e.fit.z});
      changed |= model_.runs_made() != before;
      e = again;
    }
    if (!changed) break;
    // More runs tell more of the case, too.
    baseline_ = model_.fit(free_, train_, {baseline_.z, VectorXd::Zero(static_cast<Row>(free_.size()))}, 1e3);
    for (Explanation& e : tried_) {
      e.fit = model_.fit(e.fit.moved, train_, {e.fit.z}, 1e3);
      rate(e);
    }
    weigh();
  }
}

std::vector<const MachineCandidate*> MachineInvestigation::candidates_of(const Explanation& e) const {
  std::vector<const MachineCandidate*> which;
  for (std::size_t k = free_.size(); k < e.fit.moved.size(); ++k)
    for (const MachineCandidate& c : candidates_)
      if (alike(c.parameter, e.fit.moved[k])) which.push_back(&c);
  return which;
}

void MachineInvestigation::try_pairs() {
  std::vector<Explanation> leading(tried_.begin(), tried_.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(4, tried_.size())));
  std::vector<Explanation> pairs;
  std::set<std::set<std::string>> done;
  for (const Explanation& first : leading) {
    if (first.rival) continue;
    for (const MachineCandidate& second : candidates_) {
      const MachineCandidate* one = candidates_of(first).front();
      if (one->effect == second.effect || second.rival || (second.parameter.simulated() && second.parameter.dimension < 0)) continue;
      if (!done.insert({one->parameter.key, second.parameter.key}).second) continue;
      VectorXd z(first.fit.z.size() + 1);
      z << first.fit.z, 0.2;
      pairs.push_back(explain_by({one, &second}, 0, {z}));
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Explanation& a, const Explanation& b) { return a.bic < b.bic; });
  const double single = best_named() != nullptr ? best_named()->bic : 0;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, pairs.size()); ++k)
    if (pairs[k].bic < single - 2) tried_.push_back(explain_by(candidates_of(pairs[k]), 1, {pairs[k].fit.z}));
  weigh();
}

void MachineInvestigation::choose() {
  const Explanation* named = best_named();
  double free = 0, names = 0;
  for (const Explanation& e : tried_) (e.free_form ? free : names) += e.rival ? 0 : e.probability;
  if (named == nullptr || named->bic > -2 || d_.remaining_p < left_level || free > names) return unexplained(named);
  d_.verdict = Verdict::omitted_physics;
  d_.effects = named->effects, d_.form = named->form;
  d_.best = polished(named->fit);
  double own = 0;
  std::map<std::string, double> others;
  for (const Explanation& e : tried_) {
    if (e.free_form || e.rival) continue;
    if (e.effects == named->effects) own += e.probability;
    else if (e.effects.size() == 1 && named->effects.size() == 1) others[e.effects.front()] += e.probability;
  }
  d_.confidence = own;
  // A quantity that the case calls known, and that would do, leaves less to be sure of.
  for (const Explanation& e : tried_)
    if (e.rival) d_.confidence = std::min(d_.confidence, own / (own + e.probability));
  if (d_.remaining_p < family_level) d_.confidence *= 0.7;
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [name, probability] : others)
    if (probability > own * std::exp(-alike_odds)) order.push_back({-probability, name});
  std::sort(order.begin(), order.end());
  for (const auto& [probability, name] : order) d_.indistinguishable.push_back(name);
  for (const Explanation& e : tried_)
    if (e.rival && e.probability > named->probability * std::exp(-alike_odds)) d_.remarks.push_back(fmt::format("{} would do as well; the case calls it known.", e.form));
  if (const EffectEntry* entry = find_effect(d_.effects.front())) {
    d_.signature = entry->signature;
    if (!d_.indistinguishable.empty()) d_.advice = fmt::format("To part {} from {}: {}.", d_.effects.front(), fmt::join(d_.indistinguishable, ", "), entry->experiment);
  }
}

void MachineInvestigation::unexplained(const Explanation* named) {
  d_.verdict = Verdict::unexplained;
  d_.best = baseline_;
  d_.form = smooth_changes;
  double probability = named != nullptr ? named->probability : 0;
  d_.confidence = std::clamp(1 - probability * std::min(1.0, d_.remaining_p / left_level), 0.5, 0.97);
  if (named != nullptr)
    d_.remarks.push_back(fmt::format("The nearest known effect, {}, leaves structure that noise would leave with a probability of {:.2g}.", fmt::join(named->effects, " with "), d_.remaining_p));
  d_.remarks.push_back("What is left is in residuals.csv; a machine's curves do not tell the force behind it, and amended.toml is the calibrated case.");
}

}  // namespace quern
