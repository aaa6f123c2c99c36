#include "src/diagnose/machine/machine_model.hpp"
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/case/build.hpp"

namespace quern {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double steps_of(const Values& values) {
  const Case c = case_of(values);
  return c.duration / build_case(c).simulation.clock.time_step;
}

// The largest difference of two sets of parameters; `before` may be from when there were fewer of them.
double farthest_step(const VectorXd& before, const VectorXd& now) {
  double far = 0;
  for (Row p = 0; p < now.size(); ++p) far = std::max(far, std::abs((p < before.size() ? before[p] : 0) - now[p]));
  return far;
}

// Of runs that differ in their packing, and how much that makes.
Outcome mean_of(const std::vector<Outcome>& all) {
  if (all.size() == 1) return all.front();
  Outcome mean;
  mean.sound = std::all_of(all.begin(), all.end(), [](const Outcome& one) { return one.sound; });
  if (!mean.sound) return mean;
  const auto n = static_cast<double>(all.size());
  for (const auto& [name, ignored] : all.front().numbers) {
    double sum = 0, squares = 0;
    bool everywhere = true;
    for (const Outcome& one : all) {
      const auto found = one.numbers.find(name);
      everywhere &= found != one.numbers.end();
      if (everywhere) sum += found->second.value, squares += found->second.value * found->second.value;
    }
    // Where nothing breaks, or all does, packings do not differ; the emulator learns its scatter from all together.
    if (everywhere) mean.numbers[name] = {sum / n, std::sqrt(std::max(0.0, squares / n - sum * sum / n / n) / (n - 1))};
  }
  return mean;
}

}  // namespace

MachineModel::MachineModel(const MachineExperiment& experiment, CaseRunner runner) : experiment_(experiment), runner_(std::move(runner)) {
  for (const RecordedChannel& channel : experiment.channels()) {
    emulators_.emplace_back(channel.coordinates);
    double largest = 0;
    for (const auto& site : channel.sites) largest = std::max(largest, std::abs(site.value));
    constexpr double usual = 0.02;
    unknown_noise_.push_back(channel.scale == Scale::logarithm ? 0.1 : usual * std::max(largest, 1e-12));
  }
  for (std::size_t r = 0; r < experiment.recording().rows.size(); ++r) {
    const Values values = experiment.values_of(r, {});
    const Case c = case_of(values);
    steps_.push_back(steps_of(values));
    turns_.push_back(c.mill ? std::abs(c.mill->speed) : c.stirred ? std::abs(c.stirred->speed) : 0);
  }
}

double MachineModel::effort(const Request& request) const { return steps_of(experiment_.compared(request.row, alteration_of(request.parameters, request.z))) / steps_[request.row]; }

bool MachineModel::noise_known(std::size_t channel) const {
  const auto& sites = experiment_.channels()[channel].sites;
  return std::all_of(sites.begin(), sites.end(), [](const RecordedChannel::Site& site) { return site.deviation > 0; });
}

void MachineModel::give_dimension(MachineParameter& parameter) {
  if (!parameter.simulated()) return;
  std::string name;
  for (const Parameter& p : parameter.moves) name += p.name + " ";
  const auto found = std::find(dimensions_.begin(), dimensions_.end(), name);
  parameter.dimension = static_cast<int>(found - dimensions_.begin());
  if (found == dimensions_.end()) dimensions_.push_back(name);
}

VectorXd MachineModel::at(const std::vector<MachineParameter>& parameters, const VectorXd& z) const {
  VectorXd all = VectorXd::Zero(static_cast<Row>(dimensions_.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].simulated()) all[parameters[k].dimension] = z[static_cast<Row>(k)];
  return all;
}

Alteration MachineModel::alteration_of(const std::vector<MachineParameter>& parameters, const VectorXd& z) const {
  Alteration altered;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const MachineParameter& p = parameters[k];
    const double value = std::clamp(p.at(z[static_cast<Row>(k)]), p.lower, p.upper);
    if (!p.simulated() || (value == p.null && !p.settings.empty())) continue;
    altered.settings.insert(altered.settings.end(), p.settings.begin(), p.settings.end());
    for (const Parameter& one : p.moves) altered.changes.push_back({&one, value});
  }
  return altered;
}

bool MachineModel::run(const std::vector<Request>& requests, const std::string& why) {
  std::vector<WantedRun> wanted;
  std::vector<std::size_t> places;
  bool sound = true;
  const int packings = experiment_.packings();
  for (const Request& one : requests) {
    const VectorXd here = at(one.parameters, one.z);
    const auto before = std::find_if(runs_.begin(), runs_.end(), [&](const Made& m) {
      return m.row == one.row && farthest_step(m.at, here) < 1e-9;
    });
    if (before != runs_.end()) {
      sound &= before->outcome.sound;
      continue;
    }
    Values values = experiment_.compared(one.row, alteration_of(one.parameters, one.z));
    const std::string label = why + ", " + experiment_.recording().rows[one.row].label;
    const std::int64_t seed = values.whole("seed");
    for (int k = 0; k < packings; ++k) {
      values.put("seed", seed + k, "comparison");
      wanted.push_back({values, packings > 1 ? fmt::format("{}, packing {}", label, k + 1) : label});
    }
    runs_.push_back({one.row, here, {}});
    places.push_back(runs_.size() - 1);
  }
  if (wanted.empty()) return sound;
  const std::vector<Outcome> outcomes = runner_(wanted);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto first = outcomes.begin() + static_cast<std::ptrdiff_t>(k) * packings;
    runs_[places[k]].outcome = mean_of({first, first + packings});
    sound &= runs_[places[k]].outcome.sound;
  }
  made_ += wanted.size();
  learn();
  return sound;
}

void MachineModel::learn() {
  for (std::size_t c = 0; c < emulators_.size(); ++c) {
    const RecordedChannel& channel = experiment_.channels()[c];
    emulators_[c] = Emulator(channel.coordinates);
    for (std::size_t s = 0; s < channel.sites.size(); ++s) {
      struct Shown {
        const Eigen::VectorXd* at;
        double value, deviation;
      };
      std::vector<Shown> all;
      double variance = 0;
      for (const Made& made : runs_) {
        Shown one{&made.at, 0, 0};
        if (channel.sites[s].row != made.row || !experiment_.shown(made.outcome, channel, channel.sites[s], one.value, one.deviation)) continue;
        all.push_back(one), variance += one.deviation * one.deviation;
      }
      // Few packings say little of their scatter, all runs under one condition more.
      constexpr double least = 0.005;  // on the scale of shares
      if (experiment_.packings() > 1 && !all.empty())
        for (Shown& one : all) one.deviation = std::sqrt(variance / static_cast<double>(all.size()) + least * least);
      for (const Shown& one : all) emulators_[c].add(s, *one.at, one.value, one.deviation);
    }
    emulators_[c].learn();
  }
}

bool MachineModel::explored(const MachineFit& fit, double part) const {
  const VectorXd here = at(fit.moved, fit.z);
  return std::all_of(fit.rows.begin(), fit.rows.end(), [&](std::size_t row) {
    return std::any_of(runs_.begin(), runs_.end(), [&](const Made& m) {
      return m.row == row && farthest_step(m.at, here) <= part;
    });
  });
}

void MachineModel::act(const std::vector<MachineParameter>& parameters, const VectorXd& z, std::size_t channel, VectorXd& mean) const {
  const RecordedChannel& recorded = experiment_.channels()[channel];
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const MachineParameter& p = parameters[k];
    const double value = p.at(z[static_cast<Row>(k)]);
    const bool power = recorded.name == "power", drive = power || recorded.name == "torque";
    for (Row s = 0; s < mean.size(); ++s) {
      const double turn = turn_of(recorded.sites[static_cast<std::size_t>(s)].row);
      switch (p.acts) {
        case MachineParameter::Acts::simulated: break;
        case MachineParameter::Acts::bearing_torque: if (drive) mean[s] += power ? value * turn : value; break;
        case MachineParameter::Acts::gear_loss: if (drive) mean[s] *= 1 + value; break;
        case MachineParameter::Acts::offset: if (p.channel == recorded.label()) mean[s] = recorded.scaled(recorded.plain(mean[s]) + value); break;
        case MachineParameter::Acts::gain:
          if (p.channel == recorded.label()) mean[s] = recorded.scaled(recorded.plain(mean[s]) * value);
          break;
      }
    }
  }
}

MachineTold MachineModel::tell(const std::vector<MachineParameter>& parameters, const VectorXd& z, const std::vector<std::size_t>& rows) const {
  MachineTold all;
  const VectorXd here = at(parameters, z);
  std::vector<MatrixXd> blocks;
  std::vector<VectorXd> means;
  for (std::size_t c = 0; c < emulators_.size(); ++c) {
    const RecordedChannel& channel = experiment_.channels()[c];
    Emulator::Told told = emulators_[c].tell(here);
    act(parameters, z, c, told.mean);
    std::vector<Row> kept;
    for (std::size_t s = 0; s < channel.sites.size(); ++s)
      if (std::find(rows.begin(), rows.end(), channel.sites[s].row) != rows.end()) kept.push_back(static_cast<Row>(s)), all.places.push_back({c, s});
    const auto n = static_cast<Row>(kept.size());
    MatrixXd block(n, n);
    VectorXd mean(n);
    for (Row i = 0; i < n; ++i) {
      mean[i] = told.mean[kept[static_cast<std::size_t>(i)]];
      for (Row j = 0; j < n; ++j) block(i, j) = told.covariance(kept[static_cast<std::size_t>(i)], kept[static_cast<std::size_t>(j)]);
    }
    blocks.push_back(block), means.push_back(mean);
  }
  const auto total = static_cast<Row>(all.places.size());
  all.recorded.resize(total), all.mean.resize(total), all.noise.resize(total);
  all.covariance = MatrixXd::Zero(total, total);
  Row first = 0;
  for (std::size_t c = 0; c < blocks.size(); ++c) {
    const Row n = means[c].size();
    all.mean.segment(first, n) = means[c];
    all.covariance.block(first, first, n, n) = blocks[c];
    first += n;
  }
  for (Row k = 0; k < total; ++k) {
    const auto [c, s] = all.places[static_cast<std::size_t>(k)];
    const RecordedChannel::Site& site = experiment_.channels()[c].sites[s];
    all.recorded[k] = site.value;
    all.noise[k] = site.deviation > 0 ? site.deviation : unknown_noise_[c];
    all.covariance(k, k) += all.noise[k] * all.noise[k];
  }
  return all;
}

MatrixXd MachineModel::slopes(const std::vector<MachineParameter>& parameters, const VectorXd& z, const std::vector<std::size_t>& rows) const {
  MatrixXd all;
  constexpr double step = 0.02;
  for (Row k = 0; k < z.size(); ++k) {
    VectorXd up = z, down = z;
    up[k] += step, down[k] -= step;
    const VectorXd slope = (tell(parameters, up, rows).mean - tell(parameters, down, rows).mean) / (2 * step);
    if (k == 0) all.resize(slope.size(), z.size());
    all.col(k) = slope;
  }
  return all;
}

double MachineModel::log_likelihood(const MachineTold& told) const {
  const Eigen::LLT<MatrixXd> factor(told.covariance);
  if (factor.info() != Eigen::Success) return -1e300;
  const VectorXd rest = factor.matrixL().solve(told.recorded - told.mean);
  const MatrixXd lower = factor.matrixL();
  return -0.5 * rest.squaredNorm() - lower.diagonal().array().log().sum();
}

double MachineModel::misfit(const MachineTold& told) const {
  double sum = 0;
  for (Row k = 0; k < told.mean.size(); ++k) sum += std::pow(told.recorded[k] - told.mean[k], 2) / told.covariance(k, k);
  return told.mean.size() > 0 ? std::sqrt(sum / static_cast<double>(told.mean.size())) : 0;
}

MachineFit MachineModel::fit(const std::vector<MachineParameter>& parameters, const std::vector<std::size_t>& rows, const std::vector<VectorXd>& starts, double farthest) const {
  MachineFit best;
  best.moved = parameters, best.rows = rows;
  const auto n = static_cast<Row>(parameters.size());
  VectorXd lower(n), upper(n);
  for (Row k = 0; k < n; ++k) {
    const MachineParameter& p = parameters[static_cast<std::size_t>(k)];
    const double a = (p.lower - p.null) / p.scale, b = (p.upper - p.null) / p.scale, reach = p.simulated() ? farthest : 1e9;
    lower[k] = std::max(std::min(a, b), -reach), upper[k] = std::min(std::max(a, b), reach);
  }
  const auto inside = [&](const VectorXd& z) { return VectorXd(z.cwiseMax(lower).cwiseMin(upper)); };
  for (const VectorXd& start : starts) {
    VectorXd z = inside(start);
    MachineTold told = tell(parameters, z, rows);
    double likelihood = log_likelihood(told), damping = 1e-3;
    MatrixXd information = MatrixXd::Identity(n, n);
    constexpr int most_iterations = 40;
    for (int iteration = 0; iteration < most_iterations && n > 0; ++iteration) {
      const Eigen::LLT<MatrixXd> factor(told.covariance);
      const MatrixXd j = factor.matrixL().solve(slopes(parameters, z, rows));
      const VectorXd rest = factor.matrixL().solve(told.recorded - told.mean);
      information = j.transpose() * j;
      const VectorXd gradient = j.transpose() * rest;
      bool moved = false;
      for (int attempt = 0; attempt < 8 && !moved; ++attempt) {
        MatrixXd damped = information;
        damped.diagonal() *= 1 + damping;
        damped.diagonal().array() += 1e-9;
        // What is at its bound and would leave it stays there.
        for (Row k = 0; k < n; ++k)
          if ((z[k] <= lower[k] && gradient[k] < 0) || (z[k] >= upper[k] && gradient[k] > 0)) damped.row(k).setZero(), damped.col(k).setZero(), damped(k, k) = 1e12;
        const VectorXd next = inside(z + damped.ldlt().solve(gradient));
        MachineTold there = tell(parameters, next, rows);
        const double other = log_likelihood(there);
        if (other > likelihood + 1e-7) {
          moved = true, damping = std::max(1e-6, 0.3 * damping);
          z = next, told = std::move(there), likelihood = other;
        } else {
          damping *= 10;
        }
      }
      if (!moved) break;
    }
    if (likelihood > best.log_likelihood) {
      best.log_likelihood = likelihood, best.z = z, best.sound = true;
      MatrixXd held = information;
      held.diagonal().array() += 1e-9;
      best.covariance = n > 0 ? MatrixXd(held.inverse()) : MatrixXd(0, 0);
    }
  }
  return best;
}

}  // namespace quern
