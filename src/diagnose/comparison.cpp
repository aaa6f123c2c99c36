#include "src/diagnose/comparison.hpp"
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include "src/diagnose/projection.hpp"

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();

constexpr double beginnings[] = {0.12, 0.3, 0.6};  // parts of each run, for motions that fall out of step

std::size_t samples_of(const RecordedRun& run) {
  std::size_t count = 0;
  for (const Series& series : run.series) count += series.value.size();
  return count;
}

// Broyden's correction of a run's slopes: they then tell the change that a step made; lengths in standard deviations.
void learn(RunLinear& linear, const VectorXd& own, const VectorXd& shared, const VectorXd& rest, const Whitened& white) {
  VectorXd weighted_own = own, weighted_shared = shared;
  double length = 0;
  for (Row k = 0; k < own.size(); ++k) weighted_own[k] *= white.unknowns.col(k).squaredNorm(), length += weighted_own[k] * own[k];
  for (Row k = 0; k < shared.size(); ++k) weighted_shared[k] *= white.shared.col(k).squaredNorm(), length += weighted_shared[k] * shared[k];
  VectorXd missed = linear.rest - rest;
  if (own.size() > 0) missed -= linear.unknowns * own;
  if (shared.size() > 0) missed -= linear.shared * shared;
  linear.rest = rest;
  if (!(length > 1e-12) || !missed.allFinite()) return;
  if (own.size() > 0) linear.unknowns += missed * weighted_own.transpose() / length;
  if (shared.size() > 0) linear.shared += missed * weighted_shared.transpose() / length;
}

}  // namespace

Alteration Comparison::alteration_of(const Fit& fit) const {
  Alteration altered{{}, fit.settings};
  for (std::size_t k = 0; k < fit.moved.size(); ++k) altered.changes.push_back({&fit.moved[k], fit.shared[k]});
  return altered;
}

bool Comparison::predict(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns, double horizon, VectorXd& rest) const {
  const RecordedRun& recorded = recording().runs[run];
  const Experiment::Prediction predicted = experiment_->predict(run, altered, unknowns, horizon);
  rest.resize(static_cast<Row>(samples_of(recorded)));
  Row row = 0;
  for (std::size_t s = 0; s < predicted.size(); ++s)
    for (std::size_t k = 0; k < predicted[s].size(); ++k) rest[row++] = recorded.series[s].value[k] - predicted[s][k];
  if (!errors_.empty()) rest -= errors_[run];
  if (!trembling_.empty() && trembling_[run].size() == rest.size()) rest -= trembling_[run];
  return rest.allFinite();
}

Whitened Comparison::independent(std::size_t run, const RunLinear& linear, const Noise& noise) const {
  Whitened w{linear.rest, linear.unknowns, linear.shared, 0};
  Row row = 0;
  for (const Series& series : recording().runs[run].series) {
    const auto n = static_cast<Row>(series.value.size());
    const Whitening whitening = whitening_of(series, noise[static_cast<std::size_t>(series.channel)]);
    whiten(whitening, w.rest.segment(row, n));
    if (w.unknowns.cols() > 0) whiten(whitening, w.unknowns.middleRows(row, n));
    if (w.shared.cols() > 0) whiten(whitening, w.shared.middleRows(row, n));
    row += n;
  }
  return w;
}

Whitened Comparison::whitened(std::size_t run, const RunLinear& linear, const Noise& noise, double horizon) const {
  Whitened w{linear.rest, linear.unknowns, linear.shared, 0};
  const RecordedRun& recorded = recording().runs[run];
  const double end = horizon >= 1 ? infinite : recorded.first_time() + horizon * (recorded.last_time() - recorded.first_time());
  Row row = 0;
  for (const Series& series : recorded.series) {
    const auto n = static_cast<Row>(series.value.size());
    const ChannelNoise& own = noise[static_cast<std::size_t>(series.channel)];
    const Whitening whitening = whitening_of(series, own);
    whiten(whitening, w.rest.segment(row, n));
    if (w.unknowns.cols() > 0) whiten(whitening, w.unknowns.middleRows(row, n));
    if (w.shared.cols() > 0) whiten(whitening, w.shared.middleRows(row, n));
    if (horizon >= 1) w.log_density -= whitening.log_scale;
    for (Row i = row; i < row + n; ++i) {
      const auto k = static_cast<std::size_t>(i - row);
      if ((series.channel == Channel::impact ? series.value[k] : series.t[k]) > end) {
        w.rest[i] = 0;
        w.unknowns.row(i).setZero(), w.shared.row(i).setZero();
        continue;
      }
      const double u = w.rest[i], root = std::sqrt(weight_of(u, own.tail));
      w.log_density += log_density(u, own.tail);
      w.rest[i] *= root;
      w.unknowns.row(i) *= root;
      w.shared.row(i) *= root;
    }
    row += n;
  }
  return w;
}

std::vector<double> Comparison::log_likelihoods(const Fit& fit, const Noise& noise) const {
  std::vector<double> all;
  for (std::size_t k = 0; k < fit.runs.size(); ++k) {
    all.push_back(fit.linear[k].rest.allFinite() ? whitened(fit.runs[k], without_slopes(fit.linear[k].rest), noise, fit.horizon).log_density : -infinite);
  }
  return all;
}

double Comparison::log_likelihood(const Fit& fit, const Noise& noise) const {
  double sum = 0;
  for (const double one : log_likelihoods(fit, noise)) sum += one;
  return sum;
}

// The likelihood less ½ ln det of the information on the unknowns and the common parameters.
double Comparison::restricted(const Fit& fit, const Noise& noise, std::size_t common) const {
  double sum = 0;
  const Row k = std::min(static_cast<Row>(common), fit.linear.front().shared.cols());
  MatrixXd information = MatrixXd::Zero(k, k);
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    Whitened w = whitened(fit.runs[r], fit.linear[r], noise);
    MatrixXd shared = w.shared.leftCols(k);
    sum += w.log_density - project_out(w.unknowns, shared, w.rest);
    information += shared.transpose() * shared;
  }
  if (k > 0) {
    const Eigen::LDLT<MatrixXd> ldlt(information);
    for (Row i = 0; i < k; ++i) sum -= 0.5 * std::log(std::max(ldlt.vectorD()[i], 1e-300));
  }
  return sum;
}

// Slopes that another fit of the same runs knows are taken from there.
void Comparison::linearize(Fit& fit, const Fit* known) const {
  if (known != nullptr && (known->runs != fit.runs || known->linear.size() != fit.runs.size())) known = nullptr;
  fit.linear.resize(fit.runs.size());
  std::vector<Row> there_in(fit.moved.size(), -1);
  for (std::size_t k = 0; known != nullptr && k < fit.moved.size(); ++k)
    for (std::size_t j = 0; j < known->moved.size() && static_cast<Row>(j) < known->linear.front().shared.cols(); ++j)
      if (known->moved[j].name == fit.moved[k].name && known->moved[j].scale == fit.moved[k].scale && known->moved[j].runs == fit.moved[k].runs) there_in[k] = static_cast<Row>(j);
  team_->run(static_cast<int>(fit.runs.size()), [&](int place) {
    const std::size_t run = fit.runs[static_cast<std::size_t>(place)];
    RunLinear& linear = fit.linear[static_cast<std::size_t>(place)];
    Alteration altered = alteration_of(fit);
    std::vector<double> own = fit.unknowns[run];
    if (!predict(run, altered, own, fit.horizon, linear.rest)) linear.rest.setConstant(infinite);
    const std::vector<Unknown>& unknowns = experiment_->unknowns(run);
    linear.unknowns.setZero(linear.rest.size(), static_cast<Row>(unknowns.size()));
    linear.shared.setZero(linear.rest.size(), static_cast<Row>(fit.moved.size()));
    VectorXd there;
    // The slope towards another value of one number.
    const auto slope = [&](double& number, double step, double scale, Eigen::Ref<VectorXd> column) {
      const double here = number;
      number = here + step;
      if (predict(run, altered, own, fit.horizon, there)) column = (linear.rest - there) * (scale / step);
      number = here;
    };
    const RunLinear* old = known != nullptr ? &known->linear[static_cast<std::size_t>(place)] : nullptr;
    if (old != nullptr && old->unknowns.cols() == linear.unknowns.cols() && old->unknowns.rows() == linear.unknowns.rows()) linear.unknowns = old->unknowns;
    else for (std::size_t k = 0; k < unknowns.size(); ++k) slope(own[k], 0.1 * unknowns[k].scale, unknowns[k].scale, linear.unknowns.col(static_cast<Row>(k)));
    for (std::size_t k = 0; k < fit.moved.size(); ++k) {
      const Parameter& p = fit.moved[k];
      if (there_in[k] >= 0) {
        linear.shared.col(static_cast<Row>(k)) = old->shared.col(there_in[k]);
        continue;
      }
      double step = 0.01 * p.scale;
      if (fit.covariance.rows() > static_cast<Row>(k) && fit.deviation(k) > 0) step = std::clamp(0.1 * fit.deviation(k), 1e-6 * p.scale, step);
      double& value = altered.changes[k].value;
      if (p.upper > p.lower) slope(value, value + step > p.upper ? -step : step, p.scale, linear.shared.col(static_cast<Row>(k)));
    }
  });
}

void Comparison::settle(Fit& fit, const FitOptions& options, bool& noise_known, const Fit* start) const {
  const auto shared = static_cast<Row>(fit.moved.size());
  const Fit* known = options.thorough ? nullptr : start;
  linearize(fit, known);
  bool fresh = known == nullptr;  // the slopes are those here; otherwise what steps taught (Broyden 1965)
  for (int round = 0; round <= options.noise_rounds; ++round) {
    if (!noise_known) {
      std::vector<double> ends;
      for (const std::size_t r : fit.runs) {
        const RecordedRun& run = recording().runs[r];
        ends.push_back(run.first_time() + fit.horizon * (run.last_time() - run.first_time()));
      }
      // A first idea: the robust size of what is left, so that wild points do not lead.
      for (const std::size_t c : channels_of(recording())) fit.noise[c].tail = 4;
      for (const std::size_t c : channels_of(recording())) {
        std::vector<double> rest;
        for (std::size_t r = 0; r < fit.runs.size(); ++r) {
          Row row = 0;
          for (const Series& series : recording().runs[fit.runs[r]].series) {
            for (std::size_t k = 0; k < series.value.size(); ++k, ++row)
              if (static_cast<std::size_t>(series.channel) == c && std::isfinite(fit.linear[r].rest[row]) && (fit.horizon >= 1 || series.t[k] <= ends[r]))
                rest.push_back(fit.linear[r].rest[row] / (series.deviation.empty() ? 1 : series.deviation[k]));
          }
        }
        fit.noise[c].deviation = std::max(robust_deviation(rest), resolution_of(recording(), static_cast<Channel>(c)));
      }
      noise_known = true;
    }
    double damping = 1e-3;
    double quality = log_likelihood(fit, fit.noise);
    bool at_rest = false;
    for (int iteration = 0; iteration < options.most_iterations && !at_rest; ++iteration) {
      ++fit.iterations;
      MatrixXd information = MatrixXd::Zero(shared, shared);
      VectorXd slope = VectorXd::Zero(shared);
      std::vector<Whitened> white(fit.runs.size());
      bool finite = true;
      for (std::size_t r = 0; r < fit.runs.size(); ++r) {
        if (!fit.linear[r].rest.allFinite()) { finite = false; break; }
        white[r] = whitened(fit.runs[r], fit.linear[r], fit.noise, fit.horizon);
        MatrixXd left = white[r].shared;
        VectorXd rest = white[r].rest;
        project_out(white[r].unknowns, left, rest);
        information += left.transpose() * left;
        slope += left.transpose() * rest;
      }
      if (!finite) break;
      // How well each parameter is known tells how wide its slopes are taken.
      fit.covariance = MatrixXd::Zero(shared, shared);
      for (Row i = 0; i < shared; ++i)
        if (information(i, i) > 0) fit.covariance(i, i) = fit.moved[static_cast<std::size_t>(i)].scale * fit.moved[static_cast<std::size_t>(i)].scale / information(i, i);
      // Parameters on a bound that would go beyond it stand still.
      std::vector<bool> still(fit.moved.size(), false);
      for (std::size_t k = 0; k < fit.moved.size(); ++k) {
        const auto i = static_cast<Row>(k);
        still[k] = (fit.shared[k] >= fit.moved[k].upper && slope[i] > 0) || (fit.shared[k] <= fit.moved[k].lower && slope[i] < 0) || information(i, i) < 1e-20;
      }
      bool better = false;
      const int attempts = fresh ? (options.thorough ? 8 : 5) : 2;
      for (int attempt = 0; attempt < attempts && !better; ++attempt) {
        MatrixXd damped = information;
        VectorXd pull = slope;
        for (Row i = 0; i < shared; ++i) {
          damped(i, i) += damping * information(i, i) + 1e-30;
          if (still[static_cast<std::size_t>(i)]) damped.row(i).setZero(), damped.col(i).setZero(), damped(i, i) = 1, pull[i] = 0;
        }
        const VectorXd step = shared > 0 ? VectorXd(damped.ldlt().solve(pull)) : VectorXd(0);
        Fit trial;
        trial.moved = fit.moved, trial.settings = fit.settings, trial.shared = fit.shared, trial.unknowns = fit.unknowns, trial.noise = fit.noise, trial.runs = fit.runs, trial.horizon = fit.horizon;
        trial.linear.resize(fit.runs.size());
        VectorXd taken(shared);
        for (Row i = 0; i < shared; ++i) {
          const auto k = static_cast<std::size_t>(i);
          trial.shared[k] = std::clamp(fit.shared[k] + fit.moved[k].scale * step[i], fit.moved[k].lower, fit.moved[k].upper);
          taken[i] = (trial.shared[k] - fit.shared[k]) / fit.moved[k].scale;
        }
        std::vector<VectorXd> own(fit.runs.size());
        for (std::size_t r = 0; r < fit.runs.size(); ++r) {
          const std::vector<Unknown>& unknowns = experiment_->unknowns(fit.runs[r]);
          if (unknowns.empty()) continue;
          const VectorXd target = shared > 0 ? VectorXd(white[r].rest - white[r].shared * taken) : white[r].rest;
          own[r] = white[r].unknowns.colPivHouseholderQr().solve(target) / (1 + damping);
          for (std::size_t k = 0; k < unknowns.size(); ++k) trial.unknowns[fit.runs[r]][k] += unknowns[k].scale * own[r][static_cast<Row>(k)];
        }
        const Alteration altered = alteration_of(trial);
        team_->run(static_cast<int>(fit.runs.size()), [&](int place) {
          const auto r = static_cast<std::size_t>(place);
          if (!predict(fit.runs[r], altered, trial.unknowns[fit.runs[r]], trial.horizon, trial.linear[r].rest)) trial.linear[r].rest.setConstant(infinite);
        });
        const double reached = log_likelihood(trial, trial.noise);
        if (reached > quality - 1e-9) {
          at_rest = reached - quality < (options.thorough ? 1e-3 : 1e-2);
          for (std::size_t r = 0; r < fit.runs.size(); ++r) learn(fit.linear[r], own[r], taken, trial.linear[r].rest, white[r]);
          fit.shared = trial.shared, fit.unknowns = trial.unknowns;
          quality = reached;
          damping = std::max(1e-9, damping * 0.1);
          better = true;
        } else {
          damping = std::max(1e-6, damping * 10);
        }
      }
      const bool moved = better && !at_rest;
      if (!better) at_rest = true;
      if (!moved && !fresh && (options.thorough || !better)) {
        // What was learnt of the slopes leads no further: true ones may.
        linearize(fit);
        fresh = true;
        at_rest = false;
        damping = 1e-3;
        continue;
      }
      if (moved) fresh = false;
    }
    fit.sound = std::isfinite(quality);
    if (!fit.sound) break;
    if (round == options.noise_rounds) break;
    const Noise before = fit.noise;
    estimate_noise(fit, options);
    double change = 0;
    for (std::size_t c = 0; c < channel_count; ++c)
      change = std::max({change, std::abs(std::log(fit.noise[c].deviation / before[c].deviation)), std::abs(fit.noise[c].correlation - before[c].correlation), std::abs(fit.noise[c].white - before[c].white),
                         std::abs(1 / fit.noise[c].tail - 1 / before[c].tail), fit.noise[c].jitter == before[c].jitter ? 0.0 : 1.0});
    if (change < 0.01) break;
  }
  if (!fresh && fit.sound && options.thorough) linearize(fit);
}

// Runs that fit much worse than the others may have fallen out of step with their recording: each alone is fitted anew from its first guess, a beginning
// first. Whether one was brought back.
bool Comparison::bring_back(Fit& fit) const {
  constexpr double much = 1.5;
  std::vector<double> misfits, likelihoods;
  for (std::size_t place = 0; place < fit.runs.size(); ++place) {
    const Whitened w = whitened(fit.runs[place], without_slopes(fit.linear[place].rest), fit.noise);
    misfits.push_back(w.rest.squaredNorm() / static_cast<double>(std::max<Row>(1, w.rest.size())));
    likelihoods.push_back(w.log_density);
  }
  std::vector<double> sorted = misfits;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[(sorted.size() - 1) / 2];
  bool better = false;
  for (std::size_t place = 0; place < fit.runs.size(); ++place) {
    const std::size_t run = fit.runs[place];
    if (misfits[place] <= much * usual || experiment_->unknowns(run).empty()) continue;
    const Fit alone = carry_over(fit, {run});
    if (!alone.sound || !(log_likelihood(alone, fit.noise) > likelihoods[place] + 1)) continue;
    fit.unknowns[run] = alone.unknowns[run];
    better = true;
  }
  return better;
}

Fit Comparison::fit(const std::vector<Parameter>& moved, const std::vector<Setting>& settings, const std::vector<std::size_t>& runs, const Fit* start, const FitOptions& options) const {
  Fit fit;
  fit.moved = moved;
  fit.settings = settings;
  fit.runs = runs;
  for (const Parameter& p : moved) fit.shared.push_back(p.value);
  fit.unknowns.resize(experiment_->runs());
  for (std::size_t r = 0; r < experiment_->runs(); ++r)
    for (const Unknown& u : experiment_->unknowns(r)) fit.unknowns[r].push_back(u.guess);
  for (const std::size_t r : runs) fit.samples += samples_of(recording().runs[r]);
  bool noise_known = false;
  if (start != nullptr) {
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t j = 0; j < start->moved.size(); ++j)
        if (start->moved[j].name == moved[k].name) fit.shared[k] = std::clamp(start->shared[j], moved[k].lower, moved[k].upper);
    fit.unknowns = start->unknowns;
    fit.noise = start->noise;
    noise_known = true;
  }
  if (options.by_horizon) {
    FitOptions part = options;
    part.noise_rounds = 0, part.most_iterations = 6;
    for (const double horizon : beginnings) {
      fit.horizon = horizon;
      settle(fit, part, noise_known, nullptr);
      noise_known = false;  // what is noise and what a wrong start shows anew with each part
    }
    fit.horizon = 1;
  }
  settle(fit, options, noise_known, start);
  if (options.by_horizon && fit.sound && bring_back(fit)) settle(fit, options, noise_known, nullptr);
  const auto shared = static_cast<Row>(moved.size());
  fit.covariance = MatrixXd::Zero(shared, shared);
  if (fit.sound) {
    MatrixXd information = MatrixXd::Zero(shared, shared);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      Whitened w = whitened(runs[r], fit.linear[r], fit.noise);
      VectorXd rest = w.rest;
      project_out(w.unknowns, w.shared, rest);
      information += w.shared.transpose() * w.shared;
    }
    // Student's t tells less than its core of normal numbers would.
    double told = 0, count = 0;
    for (const std::size_t r : runs)
      for (const Series& series : recording().runs[r].series) {
        const double tail = fit.noise[static_cast<std::size_t>(series.channel)].tail;
        told += static_cast<double>(series.value.size()) * (tail + 1) / (tail + 3), count += static_cast<double>(series.value.size());
      }
    information *= told / count;
    for (Row i = 0; i < shared; ++i) information(i, i) += 1e-12 * (1 + information(i, i));
    const MatrixXd inverse = shared > 0 ? MatrixXd(information.ldlt().solve(MatrixXd::Identity(shared, shared))) : MatrixXd(0, 0);
    for (Row i = 0; i < shared; ++i)
      for (Row j = 0; j < shared; ++j) fit.covariance(i, j) = inverse(i, j) * moved[static_cast<std::size_t>(i)].scale * moved[static_cast<std::size_t>(j)].scale;
    fit.log_likelihood = restricted(fit, fit.noise, options.common);
  }
  return fit;
}

Fit Comparison::carry_over(const Fit& from, const std::vector<std::size_t>& runs) const {
  // Shared parameters that cannot move.
  std::vector<Parameter> fixed = from.moved;
  for (std::size_t k = 0; k < fixed.size(); ++k) fixed[k].lower = fixed[k].upper = from.shared[k];
  FitOptions options;
  options.noise_rounds = 0;
  Fit start = from;
  for (const std::size_t run : runs)
    for (std::size_t u = 0; u < start.unknowns[run].size(); ++u) start.unknowns[run][u] = experiment_->unknowns(run)[u].guess;
  Fit found = fit(fixed, from.settings, runs, &start, options);
  if (experiment_->has_wall() && recording().kind != RecordingKind::contact) {
    // Bounces may be out of step with the recording: a beginning is fitted first.
    Fit stepwise = start;
    stepwise.moved = fixed, stepwise.runs = runs, stepwise.samples = found.samples;
    FitOptions part = options;
    part.most_iterations = 6;
    bool noise_known = true;
    for (const double horizon : beginnings) {
      stepwise.horizon = horizon;
      settle(stepwise, part, noise_known, nullptr);
    }
    stepwise.horizon = 1;
    settle(stepwise, part, noise_known, nullptr);
    const Fit other = fit(fixed, from.settings, runs, &stepwise, options);
    if (other.sound && (!found.sound || log_likelihood(other, from.noise) > log_likelihood(found, from.noise))) found = other;
  }
  return found;
}

std::vector<VectorXd> Comparison::response(const Fit& fit, const Alteration& more) const {
  std::vector<VectorXd> responses(fit.runs.size());
  Alteration all = alteration_of(fit);
  all.changes.insert(all.changes.end(), more.changes.begin(), more.changes.end());
  all.settings.insert(all.settings.end(), more.settings.begin(), more.settings.end());
  team_->run(static_cast<int>(fit.runs.size()), [&](int place) {
    const auto r = static_cast<std::size_t>(place);
    const std::size_t run = fit.runs[r];
    VectorXd rest;
    predict(run, all, fit.unknowns[run], 1, rest);
    responses[r] = fit.linear[r].rest - rest;
  });
  return responses;
}

double Comparison::misfit(const Fit& fit, const Noise& noise) const {
  double sum = 0, count = 0;
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    const Whitened w = whitened(fit.runs[r], without_slopes(fit.linear[r].rest), noise);
    sum += w.rest.squaredNorm();
    count += static_cast<double>(w.rest.size());
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace quern
