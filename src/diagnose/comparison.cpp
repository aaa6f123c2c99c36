#include "src/diagnose/comparison.hpp"
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();

std::size_t samples_of(const RecordedRun& run) {
  std::size_t count = 0;
  for (const Series& series : run.series) count += series.value.size();
  return count;
}

// The channels that were recorded.
std::vector<std::size_t> channels_of(const Recording& recording) {
  std::vector<bool> seen(channel_count);
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series) seen[static_cast<std::size_t>(series.channel)] = true;
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < channel_count; ++c)
    if (seen[c]) channels.push_back(c);
  return channels;
}

// Takes what the columns explain out of a vector and other columns; returns ln |R| of the columns.
double project_out(const MatrixXd& columns, MatrixXd& others, VectorXd& rest) {
  if (columns.cols() == 0) return 0;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  const Row rank = std::min<Row>(qr.rank(), columns.rows());
  const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
  others -= basis * (basis.transpose() * others);
  rest -= basis * (basis.transpose() * rest);
  double log_size = 0;
  for (Row k = 0; k < rank; ++k) log_size += std::log(std::abs(qr.matrixQR()(k, k)));
  return log_size;
}

double median_spacing(const Recording& recording, Channel channel) {
  std::vector<double> spacings;
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series)
      if (series.channel == channel)
        for (std::size_t k = 1; k < series.t.size(); ++k) spacings.push_back(series.t[k] - series.t[k - 1]);
  if (spacings.empty()) return 1;
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle > 0 ? *middle : 1;
}

// The finest difference that a channel shows: below it nothing is noise.
double resolution_of(const Recording& recording, Channel channel) {
  double largest = 0;
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series)
      if (series.channel == channel)
        for (double y : series.value) largest = std::max(largest, std::abs(y));
  return 1e-7 * std::max(largest, 1e-12);
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
    const RunLinear bare{fit.linear[k].rest, MatrixXd(fit.linear[k].rest.size(), 0), MatrixXd(fit.linear[k].rest.size(), 0)};
    all.push_back(bare.rest.allFinite() ? whitened(fit.runs[k], bare, noise, fit.horizon).log_density : -infinite);
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

void Comparison::estimate_noise(Fit& fit, const FitOptions& options) const {
  const Recording& recording = *recording_;
  // How many samples each estimated number takes away: shared out by the channels' samples.
  const auto shared_columns = static_cast<std::size_t>(fit.linear.front().shared.cols());
  double estimated = static_cast<double>(shared_columns);
  for (const RunLinear& linear : fit.linear) estimated += static_cast<double>(linear.unknowns.cols());
  const double free_part = std::max(0.05, 1 - estimated / std::max(1.0, static_cast<double>(fit.samples)));
  for (const std::size_t c : channels_of(recording)) {
    ChannelNoise& own = fit.noise[c];
    own.spacing = median_spacing(recording, static_cast<Channel>(c));
    const double least = resolution_of(recording, static_cast<Channel>(c));
    bool has_deviations = false;
    const auto innovations = [&](const ChannelNoise& trial) {
      std::vector<double> all;
      for (std::size_t r = 0; r < fit.runs.size(); ++r) {
        Row row = 0;
        for (const Series& series : recording.runs[fit.runs[r]].series) {
          const auto n = static_cast<Row>(series.value.size());
          if (static_cast<std::size_t>(series.channel) == c) {
            has_deviations |= !series.deviation.empty();
            VectorXd u = fit.linear[r].rest.segment(row, n);
            whiten(whitening_of(series, trial), u);
            all.insert(all.end(), u.data(), u.data() + n);
          }
          row += n;
        }
      }
      return all;
    };
    // σ for a correlation and a tail: the weights and the deviation in turn.
    const auto settle = [&](ChannelNoise& trial) {
      trial.deviation = 1;
      const std::vector<double> plain = innovations(trial);
      double deviation = std::max(robust_deviation(plain), 1e-300);
      for (int round = 0; round < 20; ++round) {
        double sum = 0;
        for (double x : plain) sum += weight_of(x / deviation, trial.tail) * x * x;
        const double next = std::sqrt(sum / (free_part * static_cast<double>(plain.size())));
        const bool done = std::abs(next - deviation) < 1e-6 * deviation;
        deviation = std::max(next, 1e-300);
        if (done) break;
      }
      // Told deviations are taken at their word, nearly; they are of all of a distribution, tails and all.
      const double whole = trial.tail < 1e6 ? std::sqrt(trial.tail / (trial.tail - 2)) : 1;
      trial.deviation = has_deviations ? std::clamp(deviation, 0.8 / whole, 1.25) : std::max(deviation, least);
    };
    const auto quality = [&](ChannelNoise trial) {
      settle(trial);
      Noise noise = fit.noise;
      noise[c] = trial;
      return restricted(fit, noise, shared_columns);
    };
    if (fit.samples < 30) {
      settle(own);
      continue;
    }
    const bool events = static_cast<Channel>(c) == Channel::impact;  // each read from the clock for itself
    // Each further number of the noise must be worth more than itself (Schwarz 1978).
    double samples = 0;
    for (const std::size_t run : fit.runs)
      for (const Series& series : recording.runs[run].series)
        if (static_cast<std::size_t>(series.channel) == c) samples += static_cast<double>(series.value.size());
    const double cost = 0.5 * std::log(samples);
    ChannelNoise uncorrelated = own;
    uncorrelated.correlation = uncorrelated.white = 0;
    const double without = quality(uncorrelated);
    // Correlation: a coarse look, then finer about the best.
    double best = quality(own), best_phi = own.correlation;
    const auto look = [&](double phi) {
      ChannelNoise trial = own;
      trial.correlation = phi;
      const double q = quality(trial);
      if (q > best) best = q, best_phi = phi;
    };
    if (own.correlation == 0 && !events)
      for (double phi : {0.15, 0.4, 0.65, 0.85, 0.95}) look(phi);
    for (double width : {0.3, 0.1, 0.03}) {
      if (events) break;
      const double centre = best_phi;
      for (double side : {-1.0, 1.0}) {
        // In the scale of ln((1+φ)/(1−φ)), in which 0.9 and 0.99 lie as far apart as 0.2 and 0.8.
        const double z = std::atanh(std::min(centre, 0.995)) + side * width;
        if (z > 0) look(std::min(std::tanh(z), 0.995));
      }
    }
    own.correlation = best_phi < 0.02 || best < without + cost ? 0 : best_phi;
    if (own.correlation > 0) {
      // A white part beside the slow one, which then lasts longer. It must be worth more than a number.
      ChannelNoise found = own;
      found.white = 0;
      double most = quality(found) + cost;
      for (double white : {0.1, 0.3, 0.6, 0.85})
        for (double longer : {0.0, 0.4, 0.8, 1.3}) {
          ChannelNoise trial = own;
          trial.white = white;
          trial.correlation = std::min(std::tanh(std::atanh(own.correlation) + longer), 0.97);
          if (const double q = quality(trial); q > most) most = q, found = trial;
        }
      own = found;
    } else {
      own.white = 0;
    }
    // A clock that trembles: worth it only where it tells more than a number would.
    {
      std::vector<double> rates;  // over the told deviations
      for (const std::size_t run : fit.runs)
        for (const Series& series : recording.runs[run].series)
          if (static_cast<std::size_t>(series.channel) == c)
            for (std::size_t k = 0; k < series.rate.size(); ++k) rates.push_back(series.rate[k] / (series.deviation.empty() ? 1 : series.deviation[k]));
      const double typical = robust_deviation(rates);
      ChannelNoise steady = own;
      steady.jitter = 0;
      double best_jitter = 0;
      best = quality(steady) + cost;
      if (typical > 0)
        for (double part : {0.3, 0.6, 1.2, 2.5, 5.0, 12.0, 40.0}) {
          ChannelNoise trial = own;
          trial.jitter = part / typical;
          const double q = quality(trial);
          if (q > best) best = q, best_jitter = trial.jitter;
        }
      own.jitter = best_jitter;
    }
    if (options.tails) {
      double best_tail = own.tail;
      best = -infinite;
      for (double tail : {1e9, 12.0, 6.0, 4.0, 3.0, 2.2}) {
        ChannelNoise trial = own;
        trial.tail = tail;
        const double q = quality(trial) - (tail < 1e6 ? cost : 0);
        if (q > best) best = q, best_tail = tail;
      }
      own.tail = best_tail;
    }
    settle(own);
  }
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
    const RunLinear bare{fit.linear[place].rest, MatrixXd(fit.linear[place].rest.size(), 0), MatrixXd(fit.linear[place].rest.size(), 0)};
    const Whitened w = whitened(fit.runs[place], bare, fit.noise);
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
    const RunLinear bare{alone.linear[0].rest, MatrixXd(alone.linear[0].rest.size(), 0), MatrixXd(alone.linear[0].rest.size(), 0)};
    if (!alone.sound || !(whitened(run, bare, fit.noise).log_density > likelihoods[place] + 1)) continue;
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
    for (const double horizon : {0.12, 0.3, 0.6}) {
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

Comparison::Pieces Comparison::pieces_of(const Fit& fit, std::size_t place) const {
  constexpr std::size_t most_curves = 6, samples_per_curve = 6;
  const std::size_t run = fit.runs[place];
  const RecordedRun& recorded = recording().runs[run];
  Pieces pieces{MatrixXd(fit.linear[place].rest.size(), 0), std::vector<bool>(static_cast<std::size_t>(fit.linear[place].rest.size()), true)};
  MatrixXd& columns = pieces.curves;
  if (recording().kind == RecordingKind::impacts) {
    // The clock's zero is estimated; times may yet drift and bend.
    const Series& series = recorded.series.front();
    const std::size_t n = series.value.size(), count = std::min<std::size_t>(2, n / 3);
    columns.setZero(static_cast<Row>(n), static_cast<Row>(count));
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < n; ++i)
        columns(static_cast<Row>(i), static_cast<Row>(k)) =
            std::legendre(static_cast<unsigned>(k + 1), 2 * static_cast<double>(i) / static_cast<double>(n - 1) - 1) * fit.noise[static_cast<std::size_t>(Channel::impact)].deviation;
    return pieces;
  }
  std::vector<std::pair<double, double>> contacts;
  double touched = 0, beginning = 0;
  bool together = false;
  if (experiment_->has_wall()) {
    const std::vector<Experiment::Point> path = experiment_->path(run, alteration_of(fit), fit.unknowns[run]);
    for (const Experiment::Point& p : path) {
      if (p.overlap > 0 && !together) beginning = p.time;
      if (!(p.overlap > 0) && together) contacts.push_back({beginning, p.time}), touched += p.time - beginning;
      together = p.overlap > 0;
    }
    if (together) contacts.push_back({beginning, path.back().time}), touched += path.back().time - beginning;
  }
  const bool bounces = touched < 0.3 * (recorded.last_time() - recorded.first_time()) && recording().kind == RecordingKind::trajectory;
  if (!bounces && recording().kind == RecordingKind::trajectory) contacts.clear();  // it lies on the wall
  std::vector<double> ends;
  for (const auto& [from, to] : contacts) {
    ends.push_back(bounces ? 0.5 * (from + to) : from);
    if (!bounces) ends.push_back(to);
  }
  ends.push_back(infinite);
  // Where nothing of the start is estimated, runs may scatter about their means.
  const bool about_mean = experiment_->unknowns(run).empty();
  Row row = 0;
  for (const Series& series : recorded.series) {
    const std::size_t n = series.value.size();
    const ChannelNoise& noise = fit.noise[static_cast<std::size_t>(series.channel)];
    const auto add = [&] {
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols(1).setZero();
      return columns.cols() - 1;
    };
    const double about = bounces ? noise.spacing : 0;
    std::size_t from = 0;
    for (std::size_t piece = 0; piece < ends.size(); ++piece) {
      std::size_t to = from;
      while (to < n && series.t[to] < ends[piece]) ++to;
      if (to - from >= 2) {
        const std::size_t count = std::clamp<std::size_t>((to - from) / samples_per_curve, 1, most_curves);
        const double middle = 0.5 * (series.t[from] + series.t[to - 1]), half = std::max(0.5 * (series.t[to - 1] - series.t[from]), 1e-300);
        for (std::size_t k = about_mean && (piece == 0 || bounces) ? 1 : 0; k < count; ++k) {
          const Row c = add();
          for (std::size_t i = from; i < to; ++i)
            columns(row + static_cast<Row>(i), c) = std::legendre(static_cast<unsigned>(k), std::clamp((series.t[i] - middle) / half, -1.0, 1.0)) * noise.deviation;
        }
      }
      for (std::size_t i = from; i < to && bounces; ++i) {
        const bool near = (piece > 0 && series.t[i] < contacts[piece - 1].second + about) || (piece < contacts.size() && series.t[i] > contacts[piece].first - about);
        if (near) pieces.kept[static_cast<std::size_t>(row) + i] = false;
      }
      from = to;
    }
    row += static_cast<Row>(n);
  }
  return pieces;
}

Noise Comparison::settled_noise(const Fit& fit, const std::vector<std::vector<VectorXd>>& all_columns) const {
  Fit wide;
  wide.moved = fit.moved, wide.runs = fit.runs, wide.noise = fit.noise, wide.linear = fit.linear, wide.samples = 0;
  std::size_t unknowns = fit.moved.size();
  Recording fewer = recording();  // without the samples about the contacts of a bouncing body
  Comparison left_over = *this;
  left_over.recording_ = &fewer;
  std::vector<std::vector<VectorXd>> columns = all_columns;
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    RunLinear& linear = wide.linear[r];
    const Pieces pieces = pieces_of(fit, r);
    const Row own = linear.unknowns.cols();
    linear.unknowns.conservativeResize(Eigen::NoChange, own + pieces.curves.cols());
    linear.unknowns.rightCols(pieces.curves.cols()) = pieces.curves;
    unknowns += static_cast<std::size_t>(linear.unknowns.cols());
    std::vector<Row> kept;
    for (std::size_t k = 0; k < pieces.kept.size(); ++k)
      if (pieces.kept[k]) kept.push_back(static_cast<Row>(k));
    wide.samples += kept.size();
    if (kept.size() == pieces.kept.size()) continue;
    linear.rest = linear.rest(kept).eval(), linear.unknowns = linear.unknowns(kept, Eigen::all).eval(), linear.shared = linear.shared(kept, Eigen::all).eval();
    for (auto& column : columns) column[r] = column[r](kept).eval();
    std::size_t row = 0;
    for (Series& series : fewer.runs[fit.runs[r]].series) {
      Series some = series;
      some.t.clear(), some.value.clear(), some.deviation.clear(), some.rate.clear();
      for (std::size_t k = 0; k < series.value.size(); ++k, ++row) {
        if (!pieces.kept[row]) continue;
        some.t.push_back(series.t[k]), some.value.push_back(series.value[k]);
        if (!series.deviation.empty()) some.deviation.push_back(series.deviation[k]);
        if (!series.rate.empty()) some.rate.push_back(series.rate[k]);
      }
      series = some;
    }
  }
  if (wide.samples < 12 + unknowns) return fit.noise;
  // The columns' main directions, as the others leave them.
  const auto most = static_cast<Row>((wide.samples - unknowns) / 10);
  MatrixXd gram = MatrixXd::Zero(static_cast<Row>(columns.size()), static_cast<Row>(columns.size()));
  VectorXd whole = VectorXd::Zero(gram.rows());
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    RunLinear all{wide.linear[r].rest, wide.linear[r].unknowns, MatrixXd(wide.linear[r].rest.size(), gram.cols())};
    for (Row c = 0; c < gram.cols(); ++c) all.shared.col(c) = columns[static_cast<std::size_t>(c)][r];
    Whitened w = left_over.whitened(fit.runs[r], all, fit.noise);
    whole += w.shared.colwise().squaredNorm().transpose();
    project_out(w.unknowns, w.shared, w.rest);
    gram += w.shared.transpose() * w.shared;
  }
  VectorXd size(gram.rows());
  for (Row c = 0; c < gram.rows(); ++c) size[c] = gram(c, c) > 1e-6 * whole[c] && whole[c] > 0 ? 1 / std::sqrt(gram(c, c)) : 0;
  gram = size.asDiagonal() * gram * size.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(gram);
  MatrixXd kept(gram.rows(), 0);
  for (Row c = gram.rows() - 1; c >= 0 && kept.cols() < most; --c) {
    if (!(eigen.eigenvalues()[c] > 1e-4 * eigen.eigenvalues()[gram.rows() - 1])) break;
    kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
    kept.rightCols(1) = size.cwiseProduct(eigen.eigenvectors().col(c)) * std::sqrt(static_cast<double>(wide.samples) / eigen.eigenvalues()[c]);
  }
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    RunLinear& linear = wide.linear[r];
    const Row own = linear.shared.cols();
    linear.shared.conservativeResize(Eigen::NoChange, own + kept.cols());
    linear.shared.rightCols(kept.cols()).setZero();
    for (Row c = 0; c < gram.cols(); ++c)
      if (size[c] > 0) linear.shared.rightCols(kept.cols()) += columns[static_cast<std::size_t>(c)][r] * kept.row(c);
  }
  // The residual as those columns leave it.
  for (int round = 0; round < 2; ++round) {
    Fit left = wide;
    MatrixXd information = MatrixXd::Zero(wide.linear[0].shared.cols(), wide.linear[0].shared.cols());
    VectorXd slope = VectorXd::Zero(information.rows());
    std::vector<Whitened> white;
    for (std::size_t r = 0; r < wide.runs.size(); ++r) {
      white.push_back(left_over.whitened(wide.runs[r], wide.linear[r], wide.noise));
      MatrixXd shared = white[r].shared;
      VectorXd rest = white[r].rest;
      project_out(white[r].unknowns, shared, rest);
      information += shared.transpose() * shared;
      slope += shared.transpose() * rest;
    }
    information.diagonal().array() += 1e-9 * (1 + information.diagonal().maxCoeff());
    const VectorXd along = information.ldlt().solve(slope);
    for (std::size_t r = 0; r < wide.runs.size(); ++r) {
      left.linear[r].rest -= wide.linear[r].shared * along;
      if (wide.linear[r].unknowns.cols() > 0) {
        const VectorXd own = white[r].unknowns.colPivHouseholderQr().solve(white[r].rest - white[r].shared * along);
        left.linear[r].rest -= wide.linear[r].unknowns * own;
      }
    }
    FitOptions options;
    left_over.estimate_noise(left, options);
    wide.noise = left.noise;
  }
  return wide.noise;
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
    for (const double horizon : {0.12, 0.3, 0.6, 1.0}) {
      stepwise.horizon = horizon;
      settle(stepwise, part, noise_known, nullptr);
    }
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
    const Experiment::Prediction predicted = experiment_->predict(run, all, fit.unknowns[run]);
    const RecordedRun& recorded = recording().runs[run];
    VectorXd rest(fit.linear[r].rest.size());
    Row row = 0;
    for (std::size_t s = 0; s < predicted.size(); ++s)
      for (std::size_t k = 0; k < predicted[s].size(); ++k) rest[row++] = recorded.series[s].value[k] - predicted[s][k];
    if (!errors_.empty()) rest -= errors_[run];
    responses[r] = fit.linear[r].rest - rest;
  });
  return responses;
}

double Comparison::misfit(const Fit& fit, const Noise& noise) const {
  double sum = 0, count = 0;
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    const RunLinear bare{fit.linear[r].rest, MatrixXd(fit.linear[r].rest.size(), 0), MatrixXd(fit.linear[r].rest.size(), 0)};
    const Whitened w = whitened(fit.runs[r], bare, noise);
    sum += w.rest.squaredNorm();
    count += static_cast<double>(w.rest.size());
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace quern
