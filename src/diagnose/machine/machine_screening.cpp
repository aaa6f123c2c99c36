#include "src/diagnose/machine/machine_investigation.hpp"
#include <Eigen/QR>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/random.hpp"
#include "src/diagnose/scores.hpp"

namespace quern {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double normal_above(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

bool alike(const MachineParameter& a, const MachineParameter& b) { return a.key == b.key && a.moves.size() == b.moves.size(); }

WhiteRest MachineInvestigation::whitened(const MachineFit& fit) const {
  WhiteRest w;
  w.told = model_.tell(fit.moved, fit.z, train_);
  const MachineTold& told = w.told;
  w.factor.compute(told.covariance);
  MatrixXd slopes = MatrixXd::Zero(told.mean.size(), 0);
  if (!fit.moved.empty()) slopes = w.factor.matrixL().solve(model_.slopes(fit.moved, fit.z, train_));
  Eigen::ColPivHouseholderQR<MatrixXd> qr(slopes);
  qr.setThreshold(1e-6);
  const Row rank = slopes.cols() > 0 ? qr.rank() : 0;
  w.basis = MatrixXd(qr.householderQ() * MatrixXd::Identity(slopes.rows(), rank));
  const VectorXd white = w.factor.matrixL().solve(told.recorded - told.mean);
  w.rest = white - w.basis * (w.basis.transpose() * white);
  w.degrees = told.mean.size() - rank;
  return w;
}

std::vector<Filter> MachineInvestigation::filters_about(const MachineFit& fit, const WhiteRest& w) const {
  std::vector<Filter> all;
  const auto add = [&](const VectorXd& direction, bool one_sided) {
    const VectorXd left = w.left(direction);
    const double length = left.norm();
    all.push_back({length > 1e-6 ? VectorXd(left / length) : VectorXd::Zero(left.size()), length, one_sided});
  };
  const MachineTold& told = w.told;
  for (const MachineCandidate& c : candidates_) {
    const auto same = std::find_if(fit.moved.begin(), fit.moved.end(), [&](const MachineParameter& p) { return alike(p, c.parameter); });
    if (same != fit.moved.end() || (c.parameter.simulated() && c.parameter.dimension < 0)) {
      all.push_back({});
      continue;
    }
    std::vector<MachineParameter> with = fit.moved;
    with.push_back(c.parameter);
    VectorXd z(fit.z.size() + 1);
    z << fit.z, 1;
    const bool one_sided = std::min(std::abs(c.parameter.lower - c.parameter.null), std::abs(c.parameter.upper - c.parameter.null)) < 1e-12;
    add(model_.tell(with, z, train_).mean - told.mean, one_sided);
  }
  for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
    const RecordedChannel& channel = experiment_.channels()[c];
    for (Row power = 0; power < 2; ++power)
      for (Row v = 0; v < (power == 0 ? 1 : channel.coordinates.cols()); ++v) {
        VectorXd direction = VectorXd::Zero(told.mean.size());
        for (std::size_t k = 0; k < told.places.size(); ++k)
          if (told.places[k][0] == c) direction[static_cast<Row>(k)] = power == 0 ? 1 : channel.coordinates(static_cast<Row>(told.places[k][1]), v) - 0.5;
        add(direction, false);
      }
  }
  return all;
}

double MachineInvestigation::p_of(const Filter& f, const VectorXd& rest) {
  const double along = f.unit.dot(rest);
  return f.one_sided ? normal_above(along) : 2 * normal_above(std::abs(along));
}

double MachineInvestigation::left_over(const MachineFit& fit, std::vector<Filter>* filters) const {
  const WhiteRest w = whitened(fit);
  const std::vector<Filter> all = filters_about(fit, w);
  const auto least = [&](const VectorXd& rest) {
    double p = chi_squared_above(rest.squaredNorm(), static_cast<int>(w.degrees));
    for (const Filter& f : all)
      if (f.visible > 1e-6) p = std::min(p, p_of(f, rest));
    return p;
  };
  const double seen = least(w.rest);
  if (filters != nullptr) *filters = all;
  // Where a channel's noise is an estimate, it may be off: t-distributed rather than normal.
  double quiet = 0;
  for (std::size_t c = 0; c < experiment_.channels().size(); ++c) quiet += !model_.noise_known(c);
  RandomStream random(options_.seed, 13);
  constexpr int repetitions = 999;
  int as_small = 0;
  for (int k = 0; k < repetitions; ++k) {
    VectorXd noise(w.rest.size());
    for (Row i = 0; i < noise.size(); ++i) noise[i] = random.normal();
    if (quiet > 0) {
      double chi = 0;
      const int degrees = std::max(2, static_cast<int>(w.degrees) - 4);
      for (int i = 0; i < degrees; ++i) chi += std::pow(random.normal(), 2);
      noise *= std::sqrt(degrees / chi);
    }
    noise -= w.basis * (w.basis.transpose() * noise).eval();
    as_small += least(noise) <= seen;
  }
  // Beyond what drawings can tell: the smallest chance, times as many as were asked.
  const double told = static_cast<double>(as_small + 1) / (repetitions + 1);
  return as_small > 0 ? told : std::min(told, seen * static_cast<double>(all.size() + 1));
}

void MachineInvestigation::judge_baseline() {
  d_.adequacy_p = left_over(baseline_, &filters_);
  d_.detectable.clear();
  for (std::size_t k = 0; k < candidates_.size(); ++k)
    if (!candidates_[k].rival && filters_[k].visible > 1e-6)
      d_.detectable.push_back({candidates_[k].effect, candidates_[k].parameter.key, candidates_[k].parameter.unit, least_visible / filters_[k].visible * std::abs(candidates_[k].parameter.scale)});
}

void MachineInvestigation::screen() {
  for (MachineCandidate& c : candidates_) {
    if (!c.parameter.simulated()) continue;
    model_.give_dimension(c.parameter);
    std::vector<MachineParameter> with = free_;
    with.push_back(c.parameter);
    // About the case as it stands: what calibration has bent to make up for what is missing is no place to look from.
    VectorXd z = VectorXd::Zero(static_cast<Row>(with.size()));
    z[z.size() - 1] = 1;
    // What makes contacts so stiff that runs would take for ever is looked at more weakly.
    double effort = model_.effort({train_.front(), with, z});
    for (int weaker = 0; weaker < 3 && effort > most_effort; ++weaker) {
      c.parameter.scale *= 0.3, with.back() = c.parameter;
      effort = model_.effort({train_.front(), with, z});
    }
    if (effort > most_effort) {
      c.parameter.dimension = -1;
      d_.remarks.push_back(fmt::format("{} was not looked for: its runs would take more than {:.0f} times as long as those of the case.", c.effect, most_effort));
      continue;
    }
    if (!model_.run(at_rows(train_, with, z), c.effect)) d_.remarks.push_back(fmt::format("Runs with {} failed at {} = {:.3g}; what it would do is not known.", c.effect, c.parameter.key, c.parameter.at(1)));
  }
  // The case is known better by now.
  const auto n = static_cast<Row>(free_.size());
  auto from = starts(n);
  from.push_back(baseline_.z);
  baseline_ = settled(free_, from, "calibrated", 1);
}

}  // namespace quern
