#include "src/grinding/power_law.hpp"
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <functional>
#include <limits>

namespace quern {
namespace {

struct Line {
  double centre = 0, height = 0, slope = 0;  // ln K = height + slope (ln x − centre)
  double chi_square = 0;

  double at(double log_x) const { return height + slope * (log_x - centre); }
};

// What a line must keep to: a slope, or a height at some ln x.
struct Held {
  std::optional<double> slope, height;
  double log_x = 0;
};

Line weighted_line(const std::vector<OperatingPoint>& points, const std::vector<double>& variances, const Held& held) {
  Line line;
  double w = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double weight = 1 / variances[k];
    w += weight, line.centre += weight * std::log(points[k].x), line.height += weight * std::log(points[k].rate);
  }
  line.centre /= w, line.height /= w;
  if (held.height) line.centre = held.log_x, line.height = *held.height;
  double xx = 0, xy = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double dx = std::log(points[k].x) - line.centre;
    xx += dx * dx / variances[k], xy += dx * (std::log(points[k].rate) - line.height) / variances[k];
  }
  line.slope = held.slope ? *held.slope : xx > 0 ? xy / xx : 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double rest = std::log(points[k].rate) - line.at(std::log(points[k].x));
    line.chi_square += rest * rest / variances[k];
  }
  return line;
}

struct Weighted {
  Line line;
  double lack = 0;         // variance
  double chi_without = 0;  // chi-square with no lack
  bool errors_known = false;
  double slope = 0;        // without weights, to begin with
};

// The least sum of squares where each point's variance is that of the side on which the line passes it. It is convex; the weights are
// those of the line before, until no point changes its side. An error of x counts as one of K by the slope: that given where the line is held to
// something, its own otherwise.
Line sided_line(const std::vector<OperatingPoint>& points, double lack, double slope, const Held& held = {}) {
  constexpr double least = 1e-16, most = 1e6;  // of a logarithm: no measurement is exact, none is without any weight
  std::vector<double> variances, rests;
  for (std::size_t k = 0; k < points.size(); ++k) rests.push_back(0);
  Line line;
  constexpr int rounds = 12;
  for (int round = 0; round < rounds; ++round) {
    variances.clear();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const OperatingPoint& p = points[k];
      const auto& [smaller, larger] = p.log_rate_variance;
      const double own = rests[k] > 0 ? smaller : rests[k] < 0 ? larger : std::min(smaller, larger);
      variances.push_back(std::clamp(own + slope * slope * p.log_x_variance, least, most) + lack);
    }
    line = weighted_line(points, variances, held);
    bool settled = round > 0;
    if (!held.slope && !held.height) {
      settled = settled && std::abs(line.slope - slope) <= 1e-9 * std::abs(slope);
      slope = line.slope;
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double rest = std::log(points[k].rate) - line.at(std::log(points[k].x));
      settled = settled && (rest > 0) == (rests[k] > 0);
      rests[k] = rest;
    }
    if (settled) break;
  }
  return line;
}

Weighted weigh(const std::vector<OperatingPoint>& points) {
  Weighted out;
  for (const OperatingPoint& p : points) out.errors_known = out.errors_known || p.log_rate_variance[0] > 0 || p.log_x_variance > 0;
  out.slope = weighted_line(points, std::vector<double>(points.size(), 1.0), {}).slope;
  const auto freedom = static_cast<double>(points.size()) - 2;
  const auto excess = [&](double lack) { return sided_line(points, lack, out.slope).chi_square - freedom; };
  out.chi_without = excess(0) + freedom;
  if (!out.errors_known) {
    out.lack = 1;  // whatever is common to all: the scale comes from the residuals
  } else if (freedom > 0 && out.chi_without > freedom) {
    double high = 1e-6;
    while (excess(high) > 0) high *= 10;
    constexpr int bits = 20;
    std::uintmax_t most = 60;
    out.lack = boost::math::tools::toms748_solve(excess, 0.0, high, boost::math::tools::eps_tolerance<double>(bits), most).first;
  }
  out.line = sided_line(points, out.lack, out.slope);
  return out;
}

double student(int freedom) { return boost::math::quantile(boost::math::students_t(freedom), 0.975); }

// Where the least sum of squares with a held value stays near the least of all; convex in the value.
Interval95 interval_of(const std::vector<OperatingPoint>& points, const Weighted& w, double best, const std::function<Held(double)>& hold) {
  const int freedom = static_cast<int>(points.size()) - 2;
  const double t = student(freedom), rise = t * t * w.line.chi_square / freedom;
  Interval95 out{best, best};
  constexpr double exact = 1e-18;
  if (!(rise > exact)) return out;
  const auto excess = [&](double value) { return sided_line(points, w.lack, w.line.slope, hold(value)).chi_square - w.line.chi_square - rise; };
  for (const std::size_t side : {0u, 1u}) {
    double step = side == 0 ? -1e-3 : 1e-3;
    constexpr double far = 1e3;  // of a logarithm
    while (excess(best + step) < 0 && std::abs(step) < far) step *= 2;
    const double a = std::min(best, best + step), b = std::max(best, best + step);
    std::uintmax_t most = 60;
    if (std::abs(step) < far) out[side] = boost::math::tools::toms748_solve(excess, a, b, boost::math::tools::eps_tolerance<double>(24), most).first;
    else out[side] = std::copysign(std::numeric_limits<double>::infinity(), step);
  }
  return out;
}

}  // namespace

double PowerLawFit::at(double x) const { return factor * std::pow(x, exponent); }

std::optional<Interval95> PowerLawFit::band_at(double x) const {
  if (points.size() < 3) return std::nullopt;
  const Interval95 logs = interval_of(points, weigh(points), std::log(at(x)), [&](double height) { return Held{{}, height, std::log(x)}; });
  return Interval95{std::exp(logs[0]), std::exp(logs[1])};
}

PowerLawFit fit_power_law(const std::vector<OperatingPoint>& points) {
  const Weighted w = weigh(points);
  PowerLawFit fit;
  fit.points = points;
  fit.exponent = w.line.slope;
  fit.factor = std::exp(w.line.at(0));
  fit.lack = w.errors_known ? std::sqrt(w.lack) : 0;
  const int freedom = static_cast<int>(points.size()) - 2;
  if (freedom < 1) return fit;
  if (w.errors_known) fit.p_of_law = boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), w.chi_without));
  fit.exponent_ci95 = interval_of(points, w, fit.exponent, [](double slope) { return Held{slope, {}, 0}; });
  fit.factor_ci95 = fit.band_at(1);
  double squares = 0, squares_mean = 0;
  bool possible = true;
  for (std::size_t left_out = 0; left_out < points.size(); ++left_out) {
    std::vector<OperatingPoint> rest = points;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out));
    possible = possible && std::any_of(rest.begin(), rest.end(), [&](const OperatingPoint& p) { return p.x != rest[0].x; });
    if (!possible) break;
    const Line line = weigh(rest).line;
    double mean = 0;
    for (const OperatingPoint& p : rest) mean += std::log(p.rate) / static_cast<double>(rest.size());
    const OperatingPoint& point = points[left_out];
    squares += std::pow(std::log(point.rate) - line.at(std::log(point.x)), 2);
    squares_mean += std::pow(std::log(point.rate) - mean, 2);
  }
  const auto root_mean = [&](double sum) { return std::sqrt(sum / static_cast<double>(points.size())); };
  if (possible) fit.held_out = root_mean(squares), fit.held_out_mean = root_mean(squares_mean);
  return fit;
}

}  // namespace quern
