#include "src/diagnose/machine/machine_investigation.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/random.hpp"
#include "src/diagnose/scores.hpp"

namespace quern {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MachineDiagnosis MachineInvestigation::run() {
  split();
  free_ = free_parameters(experiment_.base());
  for (MachineParameter& p : free_) model_.give_dimension(p);
  if (!enough_data()) return finish();
  design();
  calibrate();
  candidates_ = machine_candidates(experiment_);
  judge_baseline();
  // A body that breaks is simulated in a second: there the sharper question is always asked.
  if (experiment_.packings() == 1 && d_.adequacy_p > second_look) {
    nothing_more();
  } else {
    screen();
    judge_baseline();
    explain();
  }
  return finish();
}

void MachineInvestigation::split() {
  const auto& rows = experiment_.recording().rows;
  const bool told = std::any_of(rows.begin(), rows.end(), [](const MachineRow& row) { return row.held_out.has_value(); });
  std::vector<std::size_t> open;
  for (std::size_t r = 0; r < rows.size(); ++r) (told && rows[r].held_out.value_or(false) ? sealed_ : open).push_back(r);
  RandomStream random(options_.seed, 12);
  for (std::size_t k = open.size(); k > 1; --k) std::swap(open[k - 1], open[static_cast<std::size_t>(random.uniform() * static_cast<double>(k))]);
  // The ends of the curve come first, so that what is sealed lies between what was fitted.
  const std::string& leading = experiment_.leading_condition();
  if (!leading.empty() && open.size() >= 4) {
    const auto at = [&](std::size_t r) { return rows[r].conditions.count(leading) > 0 ? rows[r].conditions.at(leading) : 0.0; };
    const auto [least, most] = std::minmax_element(open.begin(), open.end(), [&](std::size_t a, std::size_t b) { return at(a) < at(b); });
    const double low = at(*least), high = at(*most);
    std::stable_partition(open.begin(), open.end(), [&](std::size_t r) { return at(r) == low || at(r) == high; });
  }
  if (!told && open.size() >= 4) {
    const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(experiment_.base().number("diagnose.held_out") * static_cast<double>(open.size()))));
    sealed_.assign(open.end() - static_cast<std::ptrdiff_t>(count), open.end());
    open.resize(open.size() - count);
  }
  const std::size_t selecting = open.size() >= 3 ? std::max<std::size_t>(1, open.size() / 3) : 0;
  select_.assign(open.end() - static_cast<std::ptrdiff_t>(selecting), open.end());
  fit_.assign(open.begin(), open.end() - static_cast<std::ptrdiff_t>(selecting));
  train_ = open;
  for (auto* part : {&sealed_, &select_, &fit_, &train_}) std::sort(part->begin(), part->end());
  for (const auto& [part, labels] : {std::pair(&fit_, &d_.fit_runs), std::pair(&select_, &d_.select_runs), std::pair(&sealed_, &d_.sealed_runs)})
    for (const std::size_t r : *part) labels->push_back(rows[r].label);
}

bool MachineInvestigation::enough_data() {
  for (const RecordedChannel& channel : experiment_.channels())
    for (const auto& site : channel.sites) numbers_ += std::find(train_.begin(), train_.end(), site.row) != train_.end();
  if (numbers_ >= free_.size() + 3) return true;
  d_.verdict = Verdict::insufficient_data;
  d_.confidence = 0.9;
  d_.remarks.push_back(fmt::format("{} numbers stand against {} that may be calibrated; at least three more are needed to tell noise from physics.", numbers_, free_.size()));
  return false;
}

std::vector<MachineModel::Request> MachineInvestigation::at_rows(const std::vector<std::size_t>& rows, const std::vector<MachineParameter>& parameters, const VectorXd& z) const {
  std::vector<MachineModel::Request> all;
  for (const std::size_t row : rows) all.push_back({row, parameters, z});
  return all;
}

void MachineInvestigation::nothing_more() {
  d_.best = baseline_;
  const auto n = static_cast<Row>(free_.size());
  double distance = 0;
  if (n > 0) distance = baseline_.z.dot(baseline_.covariance.ldlt().solve(baseline_.z));
  d_.verdict = n > 0 && chi_squared_above(distance, static_cast<int>(n)) < family_level ? Verdict::parameters_only : Verdict::nothing_missing;
  d_.confidence = (d_.verdict == Verdict::nothing_missing ? 0.65 : 0.5) + 0.2 * d_.adequacy_p;
}

void MachineInvestigation::locate() {
  MachineTold told = model_.tell(baseline_.moved, baseline_.z, train_);
  if (d_.verdict == Verdict::omitted_physics) {
    VectorXd without = d_.best.z;
    without.tail(without.size() - static_cast<Row>(free_.size())).setZero();
    const VectorXd with = model_.tell(d_.best.moved, d_.best.z, train_).mean;
    told = model_.tell(d_.best.moved, without, train_);
    told.recorded = with;
  }
  double most = 0;
  for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
    const RecordedChannel& channel = experiment_.channels()[c];
    const bool by_energy = channel.scale == Scale::logarithm;
    struct Point {
      double at, rest;
    };
    std::vector<Point> points;
    for (std::size_t k = 0; k < told.places.size(); ++k) {
      if (told.places[k][0] != c) continue;
      const auto& site = channel.sites[told.places[k][1]];
      const auto& conditions = experiment_.recording().rows[site.row].conditions;
      const double at = by_energy ? site.energy : experiment_.leading_condition().empty() ? 0 : conditions.at(experiment_.leading_condition());
      const auto i = static_cast<Row>(k);
      points.push_back({at, (told.recorded[i] - told.mean[i]) / std::sqrt(told.covariance(i, i))});
    }
    std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.at < b.at; });
    for (std::size_t first = 0; first < points.size(); ++first) {
      double sum = 0;
      for (std::size_t last = first; last < points.size(); ++last) {
        sum += points[last].rest;
        const double statistic = std::abs(sum) / std::sqrt(static_cast<double>(last - first + 1));
        if (statistic <= most) continue;
        most = statistic;
        const std::string unit = by_energy ? "J" : unit_of_machine_condition(experiment_.leading_condition());
        d_.where = {channel.label(), by_energy ? "energy" : experiment_.leading_condition(), unit, "", "", points[first].at, points[last].at, d_.adequacy_p, sum > 0 ? "above" : "below"};
      }
    }
  }
}

MachineDiagnosis MachineInvestigation::finish() {
  if (d_.verdict == Verdict::omitted_physics || d_.verdict == Verdict::unexplained) d_.confidence = as_experienced(d_.confidence, d_.effects.size() > 1);
  d_.runs = model_.runs_made();
  d_.baseline = baseline_;
  if (!baseline_.sound) return std::move(d_);
  const bool found = d_.verdict == Verdict::omitted_physics;
  if (!sealed_.empty()) {
    std::vector<MachineModel::Request> requests = at_rows(sealed_, baseline_.moved, baseline_.z);
    if (found) {
      const auto more = at_rows(sealed_, d_.best.moved, d_.best.z);
      requests.insert(requests.end(), more.begin(), more.end());
    }
    model_.run(requests, "sealed conditions");
  }
  d_.runs = model_.runs_made();
  const auto side_by_side = [&](const std::vector<std::size_t>& rows, bool sealed) {
    const MachineTold before = model_.tell(baseline_.moved, baseline_.z, rows), after = model_.tell(d_.best.moved, d_.best.z, rows);
    for (Row k = 0; k < before.mean.size(); ++k) {
      const auto simulated = [&](const MachineTold& told) { return std::sqrt(std::max(0.0, told.covariance(k, k) - told.noise[k] * told.noise[k])); };
      const auto [c, s] = before.places[static_cast<std::size_t>(k)];
      d_.residuals.push_back({c, s, before.recorded[k], before.noise[k], before.mean[k], simulated(before), after.mean[k], simulated(after), sealed});
    }
    return Before{model_.misfit(before), model_.misfit(after)};
  };
  d_.train = side_by_side(train_, false);
  if (!sealed_.empty()) {
    d_.sealed = side_by_side(sealed_, true);
    const double excess = d_.sealed->before * d_.sealed->before - 1, left = std::max(0.0, d_.sealed->after * d_.sealed->after - 1);
    d_.excess_removed = excess > 0 ? 1 - left / excess : 0;
    if (found && d_.sealed->after > std::max(1.3, d_.sealed->before)) {
      d_.confidence *= 0.5;
      d_.remarks.push_back("Under the sealed conditions it does not fit better: the name may be a stand-in for something else.");
    }
  }
  if (found || d_.verdict == Verdict::unexplained) locate();
  for (std::size_t k = 0; k < d_.best.moved.size(); ++k) {
    const MachineParameter& p = d_.best.moved[k];
    Estimate e;
    e.key = p.key, e.unit = p.unit, e.value = d_.best.value(k), e.deviation = d_.best.deviation(k), e.of_effect = k >= free_.size();
    if (!e.of_effect) e.nominal = p.null;
    d_.parameters.push_back(e);
  }
  std::stable_sort(d_.parameters.begin(), d_.parameters.end(), [](const Estimate& x, const Estimate& y) { return x.of_effect > y.of_effect; });
  for (const Explanation& e : tried_) d_.ranking.push_back({e.effects, e.form, e.held_out, e.held_out_gain, e.bic, e.probability, e.rival});
  return std::move(d_);
}

MachineDiagnosis diagnose_machine(const MachineExperiment& experiment, const CaseRunner& runner, const DiagnoseOptions& options) { return MachineInvestigation(experiment, runner, options).run(); }

}  // namespace quern
