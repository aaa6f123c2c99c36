#include "src/diagnose/scores.hpp"
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include "src/base/random.hpp"

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd orthonormal(const MatrixXd& columns) {
  if (columns.cols() == 0 || columns.rows() == 0) return MatrixXd(columns.rows(), 0);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  qr.setThreshold(1e-7);
  const Row rank = std::min(qr.rank(), columns.rows());
  return qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
}

constexpr double clipped = 3;    // standard deviations

// Of Student's t, cut at ±`clipped`.
double clipped_variance(double tail) {
  constexpr int pieces = 400;
  double inside = 0, square = 0;
  for (int k = 0; k < pieces; ++k) {
    const double u = clipped * (k + 0.5) / pieces, density = std::exp(log_density(u, tail)) * 2 * clipped / pieces;
    inside += density, square += density * u * u;
  }
  return square + std::max(0.0, 1 - inside) * clipped * clipped;
}

// P that of a residual of so many independent normal numbers, of unknown deviation, such a share of the squares lies along so many directions (Fisher's F).
double share_above(double share, int degrees, double of) {
  const double others = of - degrees;
  return degrees <= 0 || !(others > 0) ? 1.0 : boost::math::ibetac(0.5 * degrees, 0.5 * others, std::clamp(share, 0.0, 1.0));
}

constexpr double hidden = 1e-3;  // a direction of which less is left is not seen

}  // namespace

double chi_squared_above(double x, int degrees) { return degrees <= 0 || !(x > 0) ? 1.0 : boost::math::gamma_q(0.5 * degrees, 0.5 * x); }

Residuals::Residuals(const Comparison& comparison, const Fit& fit, const std::vector<VectorXd>& numerical) : comparison_(&comparison), fit_(&fit), few_(fit.samples < few_samples) {
  Row rows = 0, taken = 0;
  std::vector<Whitened> white;
  for (std::size_t r = 0; r < fit.runs.size(); ++r) {
    white.push_back(comparison.independent(fit.runs[r], fit.linear[r], fit.noise));
    // One wild point counts for a little; many in a row are no noise and count for much.
    if (!few_) white.back().rest = white.back().rest.cwiseMax(-clipped).cwiseMin(clipped);
    first_.push_back(rows);
    rows += white.back().rest.size();
    own_.push_back(orthonormal(white.back().unknowns));
    taken += own_.back().cols();
  }
  rest_.resize(rows);
  MatrixXd shared(rows, static_cast<Row>(fit.moved.size()));
  for (std::size_t r = 0; r < white.size(); ++r) {
    const Row n = white[r].rest.size();
    rest_.segment(first_[r], n) = white[r].rest - own_[r] * (own_[r].transpose() * white[r].rest);
    shared.middleRows(first_[r], n) = white[r].shared - own_[r] * (own_[r].transpose() * white[r].shared);
  }
  // Parameters on their bounds cannot give way.
  MatrixXd movable(rows, 0);
  for (std::size_t k = 0; k < fit.moved.size(); ++k) {
    if (fit.shared[k] <= fit.moved[k].lower || fit.shared[k] >= fit.moved[k].upper) continue;
    movable.conservativeResize(Eigen::NoChange, movable.cols() + 1);
    movable.rightCols(1) = shared.col(static_cast<Row>(k));
  }
  if (!numerical.empty()) {
    const VectorXd error = without_own(stacked(numerical));
    if (error.allFinite() && error.norm() > 0.3) {
      movable.conservativeResize(Eigen::NoChange, movable.cols() + 1);
      movable.rightCols(1) = error / error.norm() * std::max(1.0, movable.cols() > 1 ? movable.leftCols(movable.cols() - 1).norm() : 1.0);
    }
  }
  shared_ = orthonormal(movable);
  rest_ -= shared_ * (shared_.transpose() * rest_);
  degrees_left_ = std::max(1.0, static_cast<double>(rows - taken - shared_.cols()));
  double told = 0;
  for (const std::size_t run : fit.runs)
    for (const Series& series : comparison.recording().runs[run].series) {
      const double tail = fit.noise[static_cast<std::size_t>(series.channel)].tail;
      told += static_cast<double>(series.value.size()) * clipped_variance(tail);
    }
  spread_ = std::sqrt(told / static_cast<double>(rows));
}

VectorXd Residuals::stacked(const std::vector<VectorXd>& column) const {
  VectorXd all(rest_.size());
  for (std::size_t r = 0; r < fit_->runs.size(); ++r) {
    all.segment(first_[r], column[r].size()) = comparison_->independent(fit_->runs[r], without_slopes(column[r]), fit_->noise).rest;
  }
  return all;
}

VectorXd Residuals::left_of(const std::vector<VectorXd>& column) const {
  return unexplained(stacked(column));
}

VectorXd Residuals::without_own(VectorXd all) const {
  for (std::size_t r = 0; r < own_.size(); ++r) {
    const Row n = own_[r].rows();
    const VectorXd part = all.segment(first_[r], n);
    all.segment(first_[r], n) = part - own_[r] * (own_[r].transpose() * part);
  }
  return all;
}

VectorXd Residuals::unexplained(VectorXd all) const {
  all = without_own(std::move(all));
  return all - shared_ * (shared_.transpose() * all);
}

Score Residuals::score(const Direction& direction) {
  Score score;
  MatrixXd left(rest_.size(), 0);
  double longest = 0;
  for (const std::vector<VectorXd>& column : direction.columns) {
    for (const VectorXd& run : column)
      if (!run.allFinite()) return score;
    const VectorXd whole = stacked(column), seen = left_of(column);
    const double length = whole.norm();
    if (!(length > 0) || seen.norm() < hidden * length) continue;
    score.share = std::max(score.share, seen.norm() / length);
    score.visible = std::max(score.visible, seen.norm());
    longest = std::max(longest, seen.norm());
    left.conservativeResize(Eigen::NoChange, left.cols() + 1);
    left.rightCols(1) = seen;
  }
  if (!(longest > 1e-9)) return score;
  const MatrixXd basis = orthonormal(left);
  const VectorXd along = basis.transpose() * rest_ / spread_;
  score.degrees = static_cast<int>(basis.cols());
  score.statistic = along.squaredNorm();
  score.p = chi_squared_above(score.statistic, score.degrees);
  if (few_) {
    const double share = (basis.transpose() * rest_).squaredNorm() / std::max(rest_.squaredNorm(), 1e-300);
    score.p = share_above(share, score.degrees, degrees_left_);
    score.statistic = (degrees_left_ - score.degrees) * share / std::max(1 - share, 1e-9);
  }
  if (direction.columns.size() == 1) {
    score.amplitude = left.col(0).dot(rest_) / left.col(0).squaredNorm();
    if (direction.one_sided) {
      score.p = score.amplitude > 0 ? 0.5 * score.p : 1;
      if (score.amplitude < 0) score.statistic = 0;
    }
  }
  smallest_p_ = std::min(smallest_p_, score.p);
  // Signed so that forwards is along the direction.
  bases_.push_back(direction.columns.size() == 1 ? MatrixXd(left.col(0).normalized()) : basis);
  one_sided_.push_back(direction.one_sided && direction.columns.size() == 1);
  return score;
}

double Residuals::coherence(const Direction& a, const Direction& b) const {
  const VectorXd first = left_of(a.columns[0]), second = left_of(b.columns[0]);
  return std::abs(first.dot(second)) / std::max(first.norm() * second.norm(), 1e-300);
}

double Residuals::family_p(std::uint64_t seed, int repetitions) const {
  if (bases_.empty()) return 1;
  const Recording& recording = comparison_->recording();
  std::array<double, channel_count> count{};
  for (const std::size_t run : fit_->runs)
    for (const Series& series : recording.runs[run].series) count[static_cast<std::size_t>(series.channel)] += static_cast<double>(series.value.size());
  int as_small = 0;
  std::vector<double> smallest(static_cast<std::size_t>(repetitions), 1.0);
  comparison_->team().run(repetitions, [&](int repetition) {
    RandomStream random(seed, 4000 + static_cast<std::uint64_t>(repetition));
    VectorXd noise(rest_.size());
    std::array<double, channel_count> truth{};
    for (std::size_t c = 0; c < channel_count; ++c) {
      const double phi = fit_->noise[c].correlation;
      truth[c] = std::clamp(phi + random.normal() * std::sqrt((1 - phi * phi) / std::max(4.0, count[c])), 0.0, 0.995);
    }
    Row row = 0;
    for (const std::size_t run : fit_->runs) {
      for (const Series& series : recording.runs[run].series) {
        const auto c = static_cast<std::size_t>(series.channel);
        const auto n = static_cast<Row>(series.value.size());
        // Coloured as the noise may be, then whitened as it was thought to be.
        ChannelNoise true_noise = fit_->noise[c];
        true_noise.correlation = truth[c];
        const Whitening coloured = whitening_of(series, true_noise);
        Eigen::MatrixXd e(n, 1);
        double slow = 0;
        for (Row i = 0; i < n; ++i) {
          const double expected = coloured.carried[i] * slow, fresh = coloured.scale[i] * random.normal();
          e(i, 0) = expected + fresh;
          slow = expected + coloured.gain[i] * fresh;
        }
        whiten(whitening_of(series, fit_->noise[c]), e);
        noise.segment(row, n) = e;
        row += n;
      }
    }
    // As uncertain as the deviation is.
    const double spread = std::exp(random.normal() / std::sqrt(2 * degrees_left_));
    double least = 1;
    const double whole = few_ ? unexplained(noise).squaredNorm() : 0;
    for (std::size_t k = 0; k < bases_.size(); ++k) {
      const VectorXd along = bases_[k].transpose() * noise / spread;
      const auto degrees = static_cast<int>(along.size());
      double p = few_ ? share_above((bases_[k].transpose() * noise).squaredNorm() / whole, degrees, degrees_left_) : chi_squared_above(along.squaredNorm(), degrees);
      if (one_sided_[k]) p = along[0] > 0 ? 0.5 * p : 1;
      least = std::min(least, p);
    }
    smallest[static_cast<std::size_t>(repetition)] = least;
  });
  for (double p : smallest) as_small += p <= smallest_p_;
  // Beyond what repetitions can tell, Bonferroni's bound.
  const double bound = std::min(1.0, smallest_p_ * static_cast<double>(bases_.size()));
  const double counted = static_cast<double>(as_small + 1) / static_cast<double>(repetitions + 1);
  return as_small == 0 ? std::min(counted, bound) : counted;
}

}  // namespace quern
