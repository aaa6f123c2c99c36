#include "src/observe/block_average.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace quern {

namespace {

double mean_of(const std::vector<double>& x) {
  double sum = 0;
  for (double v : x) sum += v;
  return x.empty() ? 0 : sum / static_cast<double>(x.size());
}

struct Level {
  double count = 0;
  double variance = 0;     // of a block
  double correlation = 0;  // of neighbouring blocks
};

}  // namespace

BlockAverage block_average(const std::vector<double>& series) {
  BlockAverage result;
  result.mean = mean_of(series);
  result.blocks = series.size();
  if (series.size() < 4) return result;
  std::vector<Level> levels;
  for (std::vector<double> x = series; x.size() >= 4;) {
    const double n = static_cast<double>(x.size()), mean = mean_of(x);
    double squares = 0, products = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      squares += (x[k] - mean) * (x[k] - mean);
      if (k + 1 < x.size()) products += (x[k] - mean) * (x[k + 1] - mean);
    }
    // The estimate of the correlation is low by 1/n where there is none.
    levels.push_back({n, squares / (n - 1), squares > 0 ? products / squares + 1 / n : 0});
    const std::size_t odd = x.size() % 2;
    std::vector<double> halved;
    for (std::size_t k = odd; k + 1 < x.size(); k += 2) halved.push_back(0.5 * (x[k] + x[k + 1]));
    x = std::move(halved);
  }
  std::size_t chosen = levels.size() - 1;
  double doubt = 0;
  for (std::size_t k = levels.size(); k-- > 0;) {
    doubt += levels[k].count * levels[k].correlation * levels[k].correlation;
    const boost::math::chi_squared independent(static_cast<double>(levels.size() - k));
    if (doubt <= boost::math::quantile(independent, 0.7)) {
      chosen = k;
      result.settled = levels[k].count >= 8;
    }
  }
  const Level& level = levels[chosen];
  result.block = std::size_t{1} << chosen;
  result.blocks = static_cast<std::size_t>(level.count);
  // What correlation the test let pass is taken to die out as that of a first-order autoregressive series does.
  const double rest = std::clamp(level.correlation, 0.0, 0.9);
  result.standard_error = std::sqrt(level.variance / level.count * (1 + rest) / (1 - rest));
  const double half = boost::math::quantile(boost::math::students_t(level.count - 1), 0.975) * result.standard_error;
  result.ci95 = {{result.mean - half, result.mean + half}};
  return result;
}

std::size_t steady_start(const std::vector<double>& series) {
  constexpr std::size_t batch = 5;
  const std::size_t batches = series.size() / batch;
  if (batches < 4) return 0;
  const double reference = mean_of(series);
  double sum = 0, squares = 0, least = INFINITY;
  std::size_t best = 0;
  for (std::size_t k = batches; k-- > 0;) {
    double value = 0;
    for (std::size_t s = 0; s < batch; ++s) value += series[k * batch + s] - reference;
    value /= batch;
    sum += value;
    squares += value * value;
    if (k > batches / 2) continue;
    const double n = static_cast<double>(batches - k), error = (squares - sum * sum / n) / (n * n);
    if (error <= least) least = error, best = k;
  }
  return best * batch;
}

BlockAverage steady_average(const std::vector<double>& series) {
  const auto from = static_cast<std::ptrdiff_t>(steady_start(series));
  return block_average(std::vector<double>(series.begin() + from, series.end()));
}

std::array<double, 2> poisson_interval(double count) {
  // Of very many the cube root is normal (Wilson & Hilferty 1931), to a millionth of the interval's width.
  constexpr double many = 1e6, z = 1.959963984540054;
  if (!(count < many)) {
    const auto approximate = [](double of, double side) { return of * std::pow(1 - 1 / (9 * of) + side * z / (3 * std::sqrt(of)), 3); };
    return {approximate(count, -1), approximate(count + 1, 1)};
  }
  const auto quantile = [](double freedom, double p) { return 0.5 * boost::math::quantile(boost::math::chi_squared(freedom), p); };
  constexpr double hardly_any = 0.01;  // below it the lower end is less than 1e-150
  return {count > hardly_any ? quantile(2 * count, 0.025) : 0.0, quantile(2 * std::max(0.0, count) + 2, 0.975)};
}

}  // namespace quern
