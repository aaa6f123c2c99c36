#include "src/grinding/saturation.hpp"
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>
#include "src/base/random.hpp"

namespace quern {
namespace {

constexpr double least_shape = 0.5, largest_shape = 5;

struct Data {
  std::vector<double> x, y, weight;
};

// Parameters as they are searched for: P, x_0, ln x_s, ln m.
using Parameters = Eigen::Vector4d;

SaturationLaw law_of(const Parameters& p) { return {p[0], p[1], std::exp(p[2]), std::exp(p[3])}; }

// The least squares by Levenberg's and Marquardt's way, with steps that end at the bounds (Nocedal & Wright 2006, Numerical Optimization, § 10.3).
struct Search {
  const Data& data;
  Parameters low, high;
  std::array<bool, 4> free;

  double squares(const Parameters& p) const {
    const SaturationLaw law = law_of(p);
    double sum = 0;
    for (std::size_t k = 0; k < data.x.size(); ++k) sum += data.weight[k] * std::pow(data.y[k] - law.at(data.x[k]), 2);
    return sum;
  }

  // The best plateau for the other parameters.
  void project(Parameters& p) const {
    Parameters unit = p;
    unit[0] = 1;
    const SaturationLaw law = law_of(unit);
    double top = 0, bottom = 0;
    for (std::size_t k = 0; k < data.x.size(); ++k) {
      const double f = law.at(data.x[k]);
      top += data.weight[k] * f * data.y[k], bottom += data.weight[k] * f * f;
    }
    p[0] = std::clamp(bottom > 0 ? top / bottom : 0.0, low[0], high[0]);
  }

  void normal_equations(const Parameters& p, Eigen::Matrix4d& a, Eigen::Vector4d& b) const {
    a.setZero(), b.setZero();
    const SaturationLaw law = law_of(p);
    for (std::size_t k = 0; k < data.x.size(); ++k) {
      const double u = (data.x[k] - law.threshold) / law.scale;
      Eigen::Vector4d slope = Eigen::Vector4d::Zero();
      double y = 0;
      if (u > 0) {
        const double log_u = std::log(u), power = std::exp(law.shape * log_u), rest = std::exp(-power);
        const double by_u = law.plateau * rest * law.shape * power / u;
        y = law.plateau * (1 - rest);
        slope = {1 - rest, -by_u / law.scale, -by_u * u, law.plateau * rest * power * log_u * law.shape};
      }
      a += data.weight[k] * slope * slope.transpose();
      b += data.weight[k] * (data.y[k] - y) * slope;
    }
  }

  double improve(Parameters& p) const {
    constexpr int most = 60;
    constexpr double enough = 1e-10, damping_most = 1e9;
    double best = squares(p), damping = 1e-3;
    Eigen::Matrix4d a;
    Eigen::Vector4d b;
    for (int step = 0; step < most && damping < damping_most; ++step) {
      normal_equations(p, a, b);
      // What is fixed, or pushes against its bound, stays.
      for (int j = 0; j < 4; ++j)
        if (!free[static_cast<std::size_t>(j)] || (p[j] <= low[j] && b[j] < 0) || (p[j] >= high[j] && b[j] > 0)) a.row(j).setZero(), a.col(j).setZero(), a(j, j) = 1, b[j] = 0;
      bool better = false;
      while (!better && damping < damping_most) {
        Eigen::Matrix4d damped = a;
        for (int j = 0; j < 4; ++j) damped(j, j) += damping * std::max(a(j, j), 1e-12);
        const Parameters next = (p + damped.ldlt().solve(b)).cwiseMax(low).cwiseMin(high);
        const double value = squares(next);
        better = value < best;
        if (!better) {
          damping *= 8;
          continue;
        }
        const bool done = best - value < enough * best;
        p = next, best = value, damping = std::max(1e-9, damping / 8);
        if (done) return best;
      }
    }
    return best;
  }
};

Search search_over(const Data& data, const SaturationForm& form) {
  double first = data.x.back();
  for (const double x : data.x)
    if (x > 0) first = std::min(first, x);
  const double last = data.x.back();
  constexpr double wide = 1e3;
  // A threshold beyond the last but one point would leave one point for the whole rise.
  const double largest_threshold = std::min(form.largest_threshold, data.x.size() > 1 ? data.x[data.x.size() - 2] : last);
  return {data,
          {0, 0, std::log(first / wide), std::log(least_shape)},
          {form.largest_plateau, largest_threshold, std::log(last * wide), std::log(largest_shape)},
          {true, form.free_threshold, true, form.free_shape}};
}

Parameters best_of(const Data& data, const SaturationForm& form, const Parameters* start) {
  const Search search = search_over(data, form);
  Parameters best;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](Parameters p) {
    search.project(p);
    const double value = search.improve(p);
    if (value < least) least = value, best = p;
  };
  if (start) attempt(*start);
  // From a coarse net, as the sum of squares has a kink wherever the threshold passes a point.
  struct Seed {
    double squares;
    Parameters p;
  };
  std::vector<Seed> net;
  const double last = data.x.back();
  std::vector<double> thresholds = {0};
  if (form.free_threshold)
    for (std::size_t k = 0; k + 2 < data.x.size(); ++k)
      if (const double between = 0.5 * (data.x[k] + data.x[k + 1]); between < form.largest_threshold) thresholds.push_back(between);
  for (const double threshold : thresholds)
    for (const double share : {0.03, 0.1, 0.3, 1.0, 10.0})
      for (const double shape : form.free_shape ? std::vector<double>{1, 2.5} : std::vector<double>{1}) {
        Parameters p{1, threshold, std::log((last - threshold) * share), std::log(shape)};
        search.project(p);
        net.push_back({search.squares(p), p});
      }
  std::stable_sort(net.begin(), net.end(), [](const Seed& a, const Seed& b) { return a.squares < b.squares; });
  const std::size_t tried = start ? 1 : 6;
  for (std::size_t k = 0; k < std::min(tried, net.size()); ++k) attempt(net[k].p);
  return best;
}

// Student's t with so many degrees of freedom.
double student(RandomStream& random, int freedom) {
  constexpr int as_normal = 200;
  const double z = random.normal();
  if (freedom > as_normal) return z;
  double squares = 0;
  for (int k = 0; k < freedom; ++k) squares += std::pow(random.normal(), 2);
  return z / std::sqrt(squares / freedom);
}

}  // namespace

std::vector<Level> levels_of(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<std::size_t> order(x.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  constexpr double rounding = 1e-9;
  std::vector<Level> levels;
  for (std::size_t k = 0; k < order.size();) {
    std::size_t end = k;
    double sum = 0, squares = 0;
    for (; end < order.size() && x[order[end]] <= x[order[k]] * (1 + rounding); ++end) sum += y[order[end]];
    const auto n = static_cast<double>(end - k);
    for (std::size_t j = k; j < end; ++j) squares += std::pow(y[order[j]] - sum / n, 2);
    levels.push_back({x[order[k]], sum / n, n > 1 ? std::sqrt(squares / (n - 1)) : 0, static_cast<int>(end - k)});
    k = end;
  }
  return levels;
}

double SaturationLaw::at(double x) const {
  const double u = (x - threshold) / scale;
  return u > 0 ? -plateau * std::expm1(shape == 1 ? -u : -std::pow(u, shape)) : 0;
}

double SaturationLaw::half() const { return threshold + scale * std::pow(std::log(2.0), 1 / shape); }

double SaturationLaw::initial_slope() const { return plateau / scale; }

std::optional<Interval95> SaturationFit::middle95(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const auto at = [&](double part) {
    const double place = part * static_cast<double>(values.size() + 1) - 1;
    const double clamped = std::clamp(place, 0.0, static_cast<double>(values.size() - 1));
    const auto below = static_cast<std::size_t>(clamped);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (clamped - static_cast<double>(below)) * (values[above] - values[below]);
  };
  return {{at(0.025), at(0.975)}};
}

SaturationFit fit_saturation(const std::vector<Level>& levels, const SaturationForm& form, std::uint64_t seed, int draws) {
  Data data;
  int repeats = 0;  // degrees of freedom of the scatter
  double within = 0, residuals = 0;
  for (const Level& level : levels) {
    data.x.push_back(level.x), data.y.push_back(level.mean), data.weight.push_back(level.count);
    repeats += level.count - 1, within += (level.count - 1) * level.scatter * level.scatter;
  }
  SaturationFit fit;
  fit.form = form;
  const Parameters best = best_of(data, form, nullptr);
  fit.law = law_of(best);
  for (const Level& level : levels) residuals += level.count * std::pow(level.mean - fit.law.at(level.x), 2);
  const int freedom = static_cast<int>(levels.size()) - form.parameters();
  fit.residual = freedom > 0 ? std::sqrt(residuals / freedom) : 0;
  if (freedom > 0 && repeats > 0 && within > 0)
    fit.p_of_law = boost::math::cdf(boost::math::complement(boost::math::fisher_f(freedom, repeats), residuals / freedom / (within / repeats)));
  if (repeats == 0 && freedom < 1) return fit;

  constexpr int own = 4;  // repeats from which a level's own scatter is trusted
  const double pooled = repeats > 0 ? std::sqrt(within / repeats) : fit.residual;
  RandomStream random(seed, 0x5a7);
  Data drawn = data;
  for (int draw = 0; draw < draws; ++draw) {
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const bool trusted = levels[k].count >= own;
      const double error = (trusted ? levels[k].scatter : pooled) / std::sqrt(levels[k].count);
      drawn.y[k] = fit.law.at(levels[k].x) + error * student(random, trusted ? levels[k].count - 1 : repeats > 0 ? repeats : freedom);
    }
    fit.redrawn.push_back(law_of(best_of(drawn, form, &best)));
  }
  return fit;
}

}  // namespace quern
