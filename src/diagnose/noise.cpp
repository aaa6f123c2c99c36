#include "src/diagnose/noise.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace quern {

Whitening whitening_of(const Series& series, const ChannelNoise& noise) {
  const auto n = static_cast<Eigen::Index>(series.value.size());
  Whitening w{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Ones(n), Eigen::VectorXd::Ones(n), 0};
  const double rate = noise.correlation > 0 ? -std::log(noise.correlation) / noise.spacing : 0;
  const double white = noise.correlation > 0 ? noise.white : 1, variance = noise.deviation * noise.deviation;
  double known = 0;  // variance of the slow part, over σ² and the told deviations
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double own = series.deviation.empty() ? 1 : series.deviation[k];
    const double phi = i == 0 || rate <= 0 ? 0 : noise.by_sample ? noise.correlation : std::min(0.999, std::exp(-rate * (series.t[k] - series.t[k - 1])));
    const double trembling = noise.jitter > 0 ? noise.jitter * series.rate[k] / own : 0;
    const double leap = series.leap.empty() || !(variance > 0) ? 0 : series.leap[k] * series.leap[k] / (own * own * variance);
    const double slow = phi * phi * known + (1 - phi * phi) * (1 - white), sum = slow + white + trembling * trembling + leap;
    const double before = i > 0 && !series.deviation.empty() ? series.deviation[k - 1] : own;
    w.carried[i] = phi * own / before;
    w.gain[i] = slow / sum;
    w.scale[i] = own * std::sqrt(variance * sum);
    known = slow * (1 - w.gain[i]);
    w.log_scale += std::log(w.scale[i]);
  }
  return w;
}

void whiten(const Whitening& w, Eigen::Ref<Eigen::MatrixXd> columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    double slow = 0;
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      const double expected = w.carried[i] * slow, fresh = columns(i, c) - expected;
      slow = expected + w.gain[i] * fresh;
      columns(i, c) = fresh / w.scale[i];
    }
  }
}

double log_density(double u, double tail) {
  if (tail > 1e6) return -0.5 * u * u - 0.5 * std::log(2 * std::numbers::pi);
  return std::lgamma(0.5 * (tail + 1)) - std::lgamma(0.5 * tail) - 0.5 * std::log(tail * std::numbers::pi) - 0.5 * (tail + 1) * std::log1p(u * u / tail);
}

double middle_of(std::vector<double> numbers) {
  if (numbers.empty()) return 0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

double robust_deviation(std::vector<double> numbers) {
  for (double& x : numbers) x = std::abs(x);
  return 1.4826 * middle_of(std::move(numbers));
}

}  // namespace quern
