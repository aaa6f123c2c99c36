#include "src/grinding/kinetics.hpp"
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <functional>

namespace quern {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

double weight_of(const SizeSeries& s, std::size_t k) { return s.weights.empty() ? 1 : s.weights[k]; }

double decay(double rate, double shape, double time) {
  const double x = rate * time;
  return std::exp(shape == 1 ? -x : -std::pow(x, shape));
}

struct Line {
  double start = 0, limit = 0, squares = 0;
};

// The best D_0 and D_∞ for a rate.
Line line_for(const SizeSeries& s, std::optional<double> limit, double rate, double shape, std::vector<double>& x) {
  const std::size_t n = s.times.size();
  x.resize(n);
  double w = 0, wx = 0, wy = 0, wxx = 0;
  for (std::size_t k = 0; k < n; ++k) {
    x[k] = decay(rate, shape, s.times[k]);
    const double weight = weight_of(s, k);
    w += weight, wx += weight * x[k], wy += weight * s.sizes[k], wxx += weight * x[k] * x[k];
  }
  const auto through = [&](double foot) {  // the span for a limit
    double top = 0;
    for (std::size_t k = 0; k < n; ++k) top += weight_of(s, k) * x[k] * (s.sizes[k] - foot);
    return wxx > 0 ? std::max(0.0, top / wxx) : 0.0;
  };
  double foot = limit.value_or(0), span = 0;
  if (limit) {
    span = through(foot);
  } else {
    const double mean_x = wx / w, mean_y = wy / w;
    double sxx = 0, sxy = 0;
    for (std::size_t k = 0; k < n; ++k) {
      sxx += weight_of(s, k) * (x[k] - mean_x) * (x[k] - mean_x);
      sxy += weight_of(s, k) * (x[k] - mean_x) * (s.sizes[k] - mean_y);
    }
    span = sxx > 0 ? std::max(0.0, sxy / sxx) : 0;
    foot = mean_y - span * mean_x;
    if (foot < 0) foot = 0, span = through(0);
  }
  Line line{foot + span, foot, 0};
  for (std::size_t k = 0; k < n; ++k) {
    const double rest = s.sizes[k] - foot - span * x[k];
    line.squares += weight_of(s, k) * rest * rest;
  }
  return line;
}

// The sum of squares against ln K, on a grid wide enough that its ends stand for K = 0 and K = ∞.
struct Profile {
  std::function<double(double)> squares;
  std::vector<double> grid, values;
  double best = 0, least = 0;
  bool inside = true;
};

Profile profile_of(const SizeSeries& s, std::optional<double> limit, double shape) {
  double last = 0, first = infinite;
  for (const double t : s.times) {
    last = std::max(last, t);
    if (t > 0) first = std::min(first, t);
  }
  constexpr double none = 1e-4, all = 40;  // exp(−none) and exp(−all) are as good as 1 and 0
  constexpr int per_e = 4;
  const double from = std::log(std::pow(none, 1 / shape) / last), to = std::log(std::pow(all, 1 / shape) / first);
  const int count = std::max(8, static_cast<int>(std::ceil((to - from) * per_e)));
  Profile p;
  p.squares = [&s, limit, shape, x = std::vector<double>()](double log_rate) mutable { return line_for(s, limit, std::exp(log_rate), shape, x).squares; };
  for (int k = 0; k <= count; ++k) {
    p.grid.push_back(from + (to - from) * k / count);
    p.values.push_back(p.squares(p.grid.back()));
  }
  const auto least = std::min_element(p.values.begin(), p.values.end()) - p.values.begin();
  p.inside = least > 0 && least < count;
  p.best = p.grid[static_cast<std::size_t>(least)], p.least = p.values[static_cast<std::size_t>(least)];
  if (!p.inside) return p;
  const auto at = static_cast<std::size_t>(least);
  constexpr int bits = 26;  // half of those of a double: no minimum is found more closely
  std::uintmax_t most = 60;
  const auto [best, value] = boost::math::tools::brent_find_minima(p.squares, p.grid[at - 1], p.grid[at + 1], bits, most);
  if (value <= p.least) p.best = best, p.least = value;
  return p;
}

double crossing(const std::function<double(double)>& excess, double a, double b, double at_a, double at_b) {
  if (at_a == 0) return a;
  if (at_b == 0) return b;
  std::uintmax_t most = 60;
  const auto [left, right] = boost::math::tools::toms748_solve(excess, a, b, at_a, at_b, boost::math::tools::eps_tolerance<double>(30), most);
  return 0.5 * (left + right);
}

// Where a profile stays below a bound: from the outermost crossings, −∞ and ∞ where it never rises above it.
Interval95 below(const std::function<double(double)>& squares, const std::vector<double>& grid, const std::vector<double>& values, double best, double bound) {
  const auto excess = [&](double x) { return squares(x) - bound; };
  const std::size_t n = grid.size();
  Interval95 out{-infinite, infinite};
  std::size_t low = 0, high = n - 1;
  while (low < n && values[low] > bound) ++low;
  while (high > 0 && values[high] > bound) --high;
  // The lowest point may lie between two points of the grid that are both above.
  const auto least = [&](std::size_t k) { return k < n && grid[k] <= best ? grid[k] : best; };
  const auto most = [&](std::size_t k) { return grid[k] >= best ? grid[k] : best; };
  if (low == n) low = static_cast<std::size_t>(std::upper_bound(grid.begin(), grid.end(), best) - grid.begin());
  if (values[high] > bound) high = static_cast<std::size_t>(std::lower_bound(grid.begin(), grid.end(), best) - grid.begin()) - 1;
  if (low > 0) {
    const double inner = least(low);
    const double outer = grid[low - 1] < inner ? grid[low - 1] : grid[low - 2];
    out[0] = crossing(excess, outer, inner, excess(outer), std::min(0.0, excess(inner)));
  }
  if (high + 1 < n) {
    const double inner = most(high);
    const double outer = grid[high + 1] > inner ? grid[high + 1] : grid[high + 2];
    out[1] = crossing(excess, inner, outer, std::min(0.0, excess(inner)), excess(outer));
  }
  return out;
}

double student(int freedom) { return boost::math::quantile(boost::math::students_t(freedom), 0.975); }

// By the slope of the sizes in ln K, less what the linear parameters can take up.
double variance_of_log_rate(const SizeSeries& s, std::optional<double> limit, const KineticsFit& fit) {
  const bool free_limit = !limit;
  double w = 0, mean_x = 0, mean_g = 0;
  std::vector<double> x, g;
  for (std::size_t k = 0; k < s.times.size(); ++k) {
    const double power = std::pow(fit.rate * s.times[k], fit.shape);
    x.push_back(std::exp(-power));
    g.push_back(-(fit.start - fit.limit) * x[k] * power * fit.shape);
    w += weight_of(s, k), mean_x += weight_of(s, k) * x[k], mean_g += weight_of(s, k) * g[k];
  }
  mean_x = free_limit ? mean_x / w : 0, mean_g = free_limit ? mean_g / w : 0;
  double xx = 0, xg = 0, gg = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double weight = weight_of(s, k), dx = x[k] - mean_x, dg = g[k] - mean_g;
    xx += weight * dx * dx, xg += weight * dx * dg, gg += weight * dg * dg;
  }
  const double information = gg - (xx > 0 ? xg * xg / xx : 0);
  return information > 0 ? 1 / information : infinite;
}

KineticsFit fit_at(const SizeSeries& s, std::optional<double> limit, const Profile& p, double shape) {
  KineticsFit fit;
  fit.shape = shape;
  fit.rate = std::exp(p.best);
  std::vector<double> x;
  const Line line = line_for(s, limit, fit.rate, shape, x);
  fit.start = line.start, fit.limit = line.limit, fit.squares = line.squares;
  fit.points = static_cast<int>(s.times.size());
  fit.parameters = limit ? 2 : 3;
  fit.determined = p.inside && fit.start > fit.limit;
  return fit;
}

constexpr double shape_from = 0.1, shape_to = 4;

}  // namespace

double KineticsFit::scatter() const { return freedom() > 0 ? std::sqrt(squares / freedom()) : 0; }

double KineticsFit::at(double time) const { return limit + (start - limit) * decay(rate, shape, time); }

KineticsFit fit_kinetics(const SizeSeries& s, std::optional<double> limit, double shape) {
  const Profile p = profile_of(s, limit, shape);
  KineticsFit fit = fit_at(s, limit, p, shape);
  if (fit.determined) fit.log_rate_variance.fill(variance_of_log_rate(s, limit, fit));
  if (fit.freedom() < 1) return fit;
  const double rise = p.least * student(fit.freedom()) * student(fit.freedom()) / fit.freedom();
  const Interval95 log_rate = below(p.squares, p.grid, p.values, p.best, p.least + rise);
  fit.rate_ci95 = {{std::exp(log_rate[0]), std::exp(log_rate[1])}};
  if (!fit.determined || !(p.least > 0)) return fit;
  for (std::size_t side = 0; side < 2; ++side) fit.log_rate_variance[side] = std::pow(log_rate[side] - p.best, 2) / rise;
  return fit;
}

std::optional<ShapeFit> fit_shape(const SizeSeries& s, std::optional<double> limit) {
  ShapeFit out;
  const int parameters = limit ? 3 : 4;
  const int freedom = static_cast<int>(s.times.size()) - parameters;
  if (freedom < 1) return std::nullopt;
  const std::function<double(double)> squares = [&](double log_shape) { return profile_of(s, limit, std::exp(log_shape)).least; };
  std::vector<double> grid, values;
  constexpr int count = 24;
  for (int k = 0; k <= count; ++k) {
    grid.push_back(std::log(shape_from) + k * std::log(shape_to / shape_from) / count);
    values.push_back(squares(grid.back()));
  }
  const auto at = static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin());
  double best = grid[at], least = values[at];
  if (at > 0 && at < count) {
    constexpr int bits = 20;
    std::uintmax_t most = 30;
    const auto [x, y] = boost::math::tools::brent_find_minima(squares, grid[at - 1], grid[at + 1], bits, most);
    if (y <= least) best = x, least = y;
  }
  const double shape = std::exp(best);
  out.fit = fit_at(s, limit, profile_of(s, limit, shape), shape);
  out.fit.parameters = parameters;
  const double t = student(freedom);
  const Interval95 log_shape = below(squares, grid, values, best, least * (1 + t * t / freedom));
  out.shape_ci95 = {{std::exp(log_shape[0]), std::exp(log_shape[1])}};
  const double first_order = fit_kinetics(s, limit).squares;
  const double ratio = least > 0 ? std::max(0.0, first_order / least - 1) * freedom : infinite;
  out.p_first_order = std::isfinite(ratio) ? boost::math::cdf(boost::math::complement(boost::math::fisher_f(1, freedom), ratio)) : 0;
  return out;
}

std::optional<double> held_out_error(const SizeSeries& s, std::optional<double> limit, bool free_shape) {
  const std::size_t needed = (limit ? 2u : 3u) + (free_shape ? 1u : 0u);
  std::vector<double> times = s.times;
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.size() < needed + 1) return std::nullopt;
  double sum = 0, weight = 0;
  for (const double left_out : times) {
    SizeSeries rest;
    for (std::size_t k = 0; k < s.times.size(); ++k) {
      if (s.times[k] == left_out) continue;
      rest.times.push_back(s.times[k]), rest.sizes.push_back(s.sizes[k]);
      if (!s.weights.empty()) rest.weights.push_back(s.weights[k]);
    }
    KineticsFit fit;
    if (free_shape) {
      const std::optional<ShapeFit> shaped = fit_shape(rest, limit);
      if (!shaped) return std::nullopt;
      fit = shaped->fit;
    } else {
      fit = fit_kinetics(rest, limit);
    }
    for (std::size_t k = 0; k < s.times.size(); ++k) {
      if (s.times[k] != left_out) continue;
      sum += weight_of(s, k) * std::pow(s.sizes[k] - fit.at(left_out), 2);
      weight += weight_of(s, k);
    }
  }
  return std::sqrt(sum / weight);
}

}  // namespace quern
