#include "src/diagnose/machine/emulator.hpp"
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace quern {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rough = 0.02;           // part of a coefficient's variance that is each site's own
constexpr double least_response = 1e-3;  // of the spread, of one step of a parameter

double entry(const VectorXd& v, Index k) { return k < v.size() ? v[k] : 0; }

}  // namespace

void Emulator::add(std::size_t site, const VectorXd& parameters, double value, double deviation) {
  samples_.push_back({static_cast<Index>(site), parameters, value, deviation});
}

double Emulator::between_sites(Index a, Index b, double length) const {
  const double far = (sites_.row(a) - sites_.row(b)).squaredNorm() / (length * length);
  return (1 - rough) * std::exp(-0.5 * far) + (a == b ? rough : 0);
}

double Emulator::of_parameters(const VectorXd& a, const VectorXd& b, double bend) const {
  constexpr double base = 3;  // a: of the spread; the mean of all values says little of one site
  double linear = 0, pure = 0, crossed = 0;
  const Index n = std::min(a.size(), b.size());
  for (Index p = 0; p < n; ++p) {
    const double one = a[p] * b[p];
    linear += weights_[p] * one;
    pure += weights_[p] * one * one;
    for (Index q = 0; q < p; ++q) crossed += 2 * std::sqrt(weights_[p] * weights_[q]) * one * a[q] * b[q];
  }
  return base * base * spread_ * spread_ + 4 * linear + 4 * bend * bend * (pure + crossed);
}

double Emulator::variance_of(const Sample& sample, double noise) const {
  const double own = sample.deviation > 0 ? sample.deviation : 0.1 * spread_;
  return noise * noise * own * own + 1e-12 * spread_ * spread_;
}

// How much one step of each parameter does, from pairs of runs at one site that differ in little else.
void Emulator::weigh_parameters() {
  Index count = 0;
  for (const Sample& s : samples_) count = std::max(count, s.parameters.size());
  weights_ = VectorXd::Constant(count, least_response * least_response * spread_ * spread_);
  for (Index p = 0; p < count; ++p) {
    double squares = 0;
    int pairs = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Sample &a = samples_[i], &b = samples_[j];
        if (a.site != b.site) continue;
        const double step = entry(a.parameters, p) - entry(b.parameters, p);
        double others = 0;
        for (Index q = 0; q < count; ++q)
          if (q != p) others += std::abs(entry(a.parameters, q) - entry(b.parameters, q));
        if (std::abs(step) < 0.2 || others > 0.5 * std::abs(step)) continue;
        squares += (a.value - b.value) * (a.value - b.value) / (step * step), ++pairs;
      }
    if (pairs > 0) weights_[p] = std::max(weights_[p], squares / pairs);
  }
}

double Emulator::factorize(const Shape& shape) {
  const auto n = static_cast<Index>(samples_.size());
  MatrixXd k(n, n);
  VectorXd values(n);
  for (Index i = 0; i < n; ++i) {
    const Sample& a = samples_[static_cast<std::size_t>(i)];
    values[i] = a.value - mean_;
    for (Index j = 0; j <= i; ++j) {
      const Sample& b = samples_[static_cast<std::size_t>(j)];
      k(i, j) = between_sites(a.site, b.site, shape.length) * of_parameters(a.parameters, b.parameters, shape.bend);
    }
    k(i, i) += variance_of(a, shape.noise);
  }
  const Eigen::LLT<MatrixXd> factor(k);
  if (factor.info() != Eigen::Success) return -1e300;
  factor_ = factor.matrixL();
  solved_ = factor.solve(values);
  return -0.5 * values.dot(solved_) - factor_.diagonal().array().log().sum();
}

void Emulator::learn() {
  if (samples_.empty()) return;
  double sum = 0, squares = 0, claimed = 0;
  for (const Sample& s : samples_) sum += s.value, squares += s.value * s.value;
  const auto n = static_cast<double>(samples_.size());
  mean_ = sum / n;
  spread_ = std::sqrt(std::max(0.0, squares / n - mean_ * mean_));
  if (!(spread_ > 0)) spread_ = std::max(1e-9, 0.01 * std::abs(mean_));
  weigh_parameters();
  double best = -1e300;
  Shape chosen = shape_;
  for (const double length : {0.3, 0.6, 1.2, 2.4})
    for (const double bend : {0.05, 0.2, 0.5})
      for (const double noise : {0.1, 0.3, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0}) {
        const bool claims = samples_.front().deviation > 0;
        if (claims && noise < 0.7) continue;  // a run does not know its scatter to better than that, but not worse than it says by chance alone
        const Shape shape{length, bend, noise};
        // Runs are as noisy as they say, and functions smooth, unless they show otherwise.
        const double prior = claims ? -0.5 * std::pow(std::log(noise) / 0.4, 2) : 0;
        if (const double likelihood = factorize(shape) + prior; likelihood > best) best = likelihood, chosen = shape;
      }
  shape_ = chosen;
  factorize(shape_);
  for (const Sample& s : samples_) claimed += variance_of(s, shape_.noise) / n;
  scatter_ = std::sqrt(claimed);
}

Emulator::Told Emulator::tell(const VectorXd& parameters) const {
  const Index sites = sites_.rows();
  const auto n = static_cast<Index>(samples_.size());
  MatrixXd cross(n, sites), own(sites, sites);
  const VectorXd asked = [&] {
    VectorXd all = VectorXd::Zero(weights_.size());
    for (Index p = 0; p < all.size(); ++p) all[p] = entry(parameters, p);
    return all;
  }();
  for (Index i = 0; i < n; ++i) {
    const Sample& s = samples_[static_cast<std::size_t>(i)];
    const double k = of_parameters(s.parameters, asked, shape_.bend);
    for (Index j = 0; j < sites; ++j) cross(i, j) = between_sites(s.site, j, shape_.length) * k;
  }
  const double k = of_parameters(asked, asked, shape_.bend);
  for (Index i = 0; i < sites; ++i)
    for (Index j = 0; j < sites; ++j) own(i, j) = between_sites(i, j, shape_.length) * k;
  const MatrixXd half = factor_.triangularView<Eigen::Lower>().solve(cross);
  Told told;
  told.mean = VectorXd::Constant(sites, mean_) + cross.transpose() * solved_;
  told.covariance = own - half.transpose() * half;
  return told;
}

}  // namespace quern
