// What is noise about a fit, and what may be physics that the fit lacks.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include "src/diagnose/comparison.hpp"
#include "src/diagnose/projection.hpp"

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinite = std::numeric_limits<double>::infinity();

double median_spacing(const Recording& recording, Channel channel) {
  std::vector<double> spacings;
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series)
      if (series.channel == channel)
        for (std::size_t k = 1; k < series.t.size(); ++k) spacings.push_back(series.t[k] - series.t[k - 1]);
  const double middle = middle_of(std::move(spacings));
  return middle > 0 ? middle : 1;
}

// Whether a channel's samples follow one another at times far from even.
bool is_uneven(const Recording& recording, Channel channel, double spacing) {
  std::size_t all = 0, off = 0;
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series)
      if (series.channel == channel)
        for (std::size_t k = 1; k < series.t.size(); ++k) ++all, off += std::abs(series.t[k] - series.t[k - 1] - spacing) > 0.3 * spacing;
  return 5 * off > all;
}

}  // namespace

void Comparison::estimate_noise(Fit& fit, const FitOptions& options) const {
  const Recording& recording = recording_;
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
    if (fit.samples < few_samples) {
      own.tail = ChannelNoise{}.tail;
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
    const auto look = [&](double phi, bool by_sample) {
      ChannelNoise trial = own;
      trial.correlation = phi, trial.by_sample = by_sample;
      const double q = quality(trial);
      if (q > best) best = q, best_phi = phi, own.by_sample = by_sample;
    };
    if (own.correlation == 0 && !events) {
      const bool uneven = is_uneven(recording, static_cast<Channel>(c), own.spacing);
      for (double phi : {0.15, 0.4, 0.65, 0.85, 0.95}) {
        look(phi, false);
        if (uneven) look(phi, true);
      }
    }
    for (double width : {0.3, 0.1, 0.03}) {
      if (events) break;
      const double centre = best_phi;
      for (double side : {-1.0, 1.0}) {
        // In the scale of ln((1+φ)/(1−φ)), in which 0.9 and 0.99 lie as far apart as 0.2 and 0.8.
        const double z = std::atanh(std::min(centre, 0.995)) + side * width;
        if (z > 0) look(std::min(std::tanh(z), 0.995), own.by_sample);
      }
    }
    // Slow noise looks like physics and is believed late.
    own.correlation = best_phi < 0.02 || best < without + 3 * cost ? 0 : best_phi;
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
      ChannelNoise steady = own;
      steady.jitter = 0;
      double best_jitter = 0;
      best = quality(steady) + cost;
      std::vector<double> rates;  // over the told deviations
      double squares = 0;
      for (const std::size_t run : fit.runs)
        for (const Series& series : recording.runs[run].series)
          if (static_cast<std::size_t>(series.channel) == c)
            for (std::size_t k = 0; k < series.rate.size(); ++k) rates.push_back(series.rate[k] / (series.deviation.empty() ? 1 : series.deviation[k])), squares += rates.back() * rates.back();
      // Of most samples, or of the few in which something happens.
      const double few = std::sqrt(squares / std::max<double>(1, static_cast<double>(rates.size()))), most = robust_deviation(std::move(rates)), typical = most > 0.1 * few ? most : few;
      constexpr double in_order = 0.3;  // of the time between samples: beyond it they would be out of order
      const auto try_jitter = [&](double jitter) {
        if (jitter * own.deviation > in_order * own.spacing) return;
        ChannelNoise trial = own;
        trial.jitter = jitter;
        if (const double q = quality(trial); q > best) best = q, best_jitter = jitter;
      };
      if (typical > 0)
        for (double part : {0.3, 0.6, 1.2, 2.5, 5.0, 12.0, 40.0}) try_jitter(part / typical);
      for (double factor : {1.5, 1.2, 1.08}) {
        const double centre = best_jitter;
        if (centre > 0) try_jitter(centre * factor), try_jitter(centre / factor);
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
  Comparison left_over = *this;
  Recording& fewer = left_over.recording_;  // without the samples about the contacts of a bouncing body
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
      some.t.clear(), some.value.clear(), some.deviation.clear(), some.rate.clear(), some.leap.clear();
      for (std::size_t k = 0; k < series.value.size(); ++k, ++row) {
        if (!pieces.kept[row]) continue;
        some.t.push_back(series.t[k]), some.value.push_back(series.value[k]);
        if (!series.deviation.empty()) some.deviation.push_back(series.deviation[k]);
        if (!series.rate.empty()) some.rate.push_back(series.rate[k]);
        if (!series.leap.empty()) some.leap.push_back(series.leap[k]);
      }
      series = some;
    }
  }
  if (fit.samples < few_samples) {
    Fit own = fit;
    estimate_noise(own, {});
    return own.noise;
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
  Eigen::SelfAdjointEigenSolver<MatrixXd> eigen;
  if (gram.rows() > 0) eigen.compute(gram);
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
  // The residual as those columns leave it under a noise.
  const auto left_under = [&](const Noise& noise) {
    Fit left = wide;
    left.noise = noise;
    MatrixXd information = MatrixXd::Zero(wide.linear[0].shared.cols(), wide.linear[0].shared.cols());
    VectorXd slope = VectorXd::Zero(information.rows());
    std::vector<Whitened> white;
    for (std::size_t r = 0; r < wide.runs.size(); ++r) {
      white.push_back(left_over.whitened(wide.runs[r], wide.linear[r], noise));
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
    return left;
  };
  for (int round = 0; round < 2; ++round) {
    Fit left = left_under(wide.noise);
    left_over.estimate_noise(left, {});
    wide.noise = left.noise;
  }
  // With so much taken away, what remains says little of slow noise. The noise of the whole residual holds unless what remains speaks against it.
  const auto quality = [&](const Noise& noise) { return left_over.restricted(left_under(noise), noise, static_cast<std::size_t>(wide.linear.front().shared.cols())); };
  constexpr double against_it = 3;  // ln of likelihood
  // Noise that hardly forgets itself within a run is as good as physics.
  constexpr double least_memories = 3;
  for (const std::size_t c : channels_of(recording())) {
    double samples = 0, series = 0;
    for (const std::size_t run : fit.runs)
      for (const Series& one : recording().runs[run].series)
        if (static_cast<std::size_t>(one.channel) == c) samples += static_cast<double>(one.value.size()), series += 1;
    if ((1 - fit.noise[c].correlation) * samples < least_memories * series) continue;
    if ((fit.noise[c].correlation == 0 && wide.noise[c].correlation == 0) || fit.noise[c].tail != wide.noise[c].tail) continue;
    Noise first = wide.noise;
    first[c] = fit.noise[c];
    if (quality(first) > quality(wide.noise) - against_it) wide.noise = first;
  }
  return wide.noise;
}

}  // namespace quern
