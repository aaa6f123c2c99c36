#include "src/diagnose/machine/machine_investigation.hpp"
#include <Eigen/QR>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"

namespace quern {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void MachineInvestigation::design() {
  const auto n = static_cast<Row>(free_.size());
  std::vector<std::size_t> all = train_;
  all.insert(all.end(), sealed_.begin(), sealed_.end());
  std::sort(all.begin(), all.end());
  if (!model_.run(at_rows(all, free_, VectorXd::Zero(n)), "the case")) throw RunError("a run of the case failed; its log.txt in the folder runs tells why.");
  std::vector<MachineModel::Request> requests;
  for (Row k = 0; k < n; ++k) {
    const MachineParameter& p = free_[static_cast<std::size_t>(k)];
    for (const double step : {1.0, -1.0}) {
      VectorXd z = VectorXd::Zero(n);
      z[k] = step;
      if (p.at(step) < p.lower || p.at(step) > p.upper) z[k] = step < 0 ? 0.5 : 0.0;  // where there is no room, halfway on the other side
      if (z[k] == 0) continue;
      const auto some = at_rows(train_, free_, z);
      requests.insert(requests.end(), some.begin(), some.end());
    }
  }
  model_.run(requests, "free numbers one step away");
}

std::vector<VectorXd> MachineInvestigation::starts(Row n) const {
  std::vector<VectorXd> all = {VectorXd::Zero(n)};
  for (Row k = 0; k < n; ++k)
    for (const double step : {1.0, -1.0}) {
      VectorXd z = VectorXd::Zero(n);
      z[k] = step;
      all.push_back(z);
    }
  return all;
}

MachineFit MachineInvestigation::settled(const std::vector<MachineParameter>& parameters, std::vector<VectorXd> from, const std::string& what, int rounds) {
  MachineFit fit = model_.fit(parameters, train_, from, design_reach);
  double reach = design_reach;
  for (int round = 0; round < rounds && fit.sound; ++round) {
    constexpr double near = 0.2;
    if (model_.explored(fit, near * std::max(1.0, fit.z.size() > 0 ? fit.z.cwiseAbs().maxCoeff() : 1.0))) break;
    if (model_.effort({train_.front(), fit.moved, fit.z}) > 2 * most_effort || !model_.run(at_rows(train_, fit.moved, fit.z), what + " where it fits")) break;
    reach *= 2;
    from.push_back(fit.z);
    fit = model_.fit(parameters, train_, from, reach);
  }
  note(what, fit);
  return fit;
}

MachineFit MachineInvestigation::polished(const MachineFit& fit) {
  std::vector<MachineModel::Request> requests;
  for (std::size_t k = 0; k < fit.moved.size(); ++k) {
    const MachineParameter& p = fit.moved[k];
    if (!p.simulated()) continue;
    const auto i = static_cast<Row>(k);
    VectorXd z = fit.z;
    const double step = 0.5 * std::max(1.0, std::abs(z[i]));
    const double above = p.at(z[i] + step), below = p.at(z[i] - step);
    z[i] += above >= p.lower && above <= p.upper ? step : below >= p.lower && below <= p.upper ? -step : 0;
    if (z[i] != fit.z[i] && model_.effort({train_.front(), fit.moved, z}) < 2 * most_effort) {
      const auto some = at_rows(train_, fit.moved, z);
      requests.insert(requests.end(), some.begin(), some.end());
    }
  }
  model_.run(requests, "beside the best");
  MachineFit best = fit;
  for (int round = 0; round < 2; ++round) {
    best = model_.fit(fit.moved, train_, {best.z, fit.z}, 1e3);
    constexpr double near = 0.15;
    if (!best.sound || model_.explored(best, near * std::max(1.0, best.z.cwiseAbs().maxCoeff()))) break;
    model_.run(at_rows(train_, best.moved, best.z), "the best");
  }
  note("the best", best);
  return best.sound ? best : fit;
}

void MachineInvestigation::calibrate() {
  const auto n = static_cast<Row>(free_.size());
  for (int round = 0; round < 2; ++round) {
    baseline_ = settled(free_, starts(n), "calibrated", 3);
    if (!estimate_noise()) break;
  }
  d_.best = baseline_;
}

bool MachineInvestigation::estimate_noise() {
  bool any = false;
  const MachineTold told = model_.tell(baseline_.moved, baseline_.z, train_);
  for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
    if (model_.noise_known(c)) continue;
    const RecordedChannel& channel = experiment_.channels()[c];
    std::vector<Row> mine;
    for (std::size_t k = 0; k < told.places.size(); ++k)
      if (told.places[k][0] == c) mine.push_back(static_cast<Row>(k));
    const auto n = static_cast<Row>(mine.size());
    const Row d = channel.coordinates.cols(), terms = 1 + 2 * d;
    if (n < terms + 2) continue;
    MatrixXd curves(n, terms);
    VectorXd rest(n);
    for (Row i = 0; i < n; ++i) {
      const auto site = static_cast<Row>(told.places[static_cast<std::size_t>(mine[static_cast<std::size_t>(i)])][1]);
      curves(i, 0) = 1;
      for (Row v = 0; v < d; ++v) curves(i, 1 + v) = channel.coordinates(site, v), curves(i, 1 + d + v) = std::pow(channel.coordinates(site, v), 2);
      rest[i] = told.recorded[mine[static_cast<std::size_t>(i)]] - told.mean[mine[static_cast<std::size_t>(i)]];
    }
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(curves);
    const double squares = (rest - curves * qr.solve(rest)).squaredNorm();
    const double largest = told.recorded.cwiseAbs().maxCoeff();
    // The mean of log χ² lies below log of its mean: a few numbers tend to look quieter than they are.
    const auto left = static_cast<double>(n - qr.rank());
    model_.set_noise(c, std::max(channel.scale == Scale::logarithm ? 0.02 : 1e-3 * largest, std::sqrt(squares / std::max(1.0, left - 1))));
    any = true;
  }
  return any;
}

}  // namespace quern
