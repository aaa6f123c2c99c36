#include "src/grinding/power_law.hpp"
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>

namespace quern {
namespace {

struct Line {
  double centre = 0, height = 0, slope = 0;   // ln K = height + slope (ln x − centre)
  double height_variance = 0, slope_variance = 0;  // for the variances given
  double chi_square = 0;
};

Line weighted_line(const std::vector<OperatingPoint>& points, const std::vector<double>& variances) {
  Line line;
  double w = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double weight = 1 / variances[k];
    w += weight, line.centre += weight * std::log(points[k].x), line.height += weight * std::log(points[k].rate);
  }
  line.centre /= w, line.height /= w;
  double xx = 0, xy = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double dx = std::log(points[k].x) - line.centre;
    xx += dx * dx / variances[k], xy += dx * (std::log(points[k].rate) - line.height) / variances[k];
  }
  line.slope = xx > 0 ? xy / xx : 0;
  line.height_variance = 1 / w, line.slope_variance = xx > 0 ? 1 / xx : 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double rest = std::log(points[k].rate) - line.height - line.slope * (std::log(points[k].x) - line.centre);
    line.chi_square += rest * rest / variances[k];
  }
  return line;
}

struct Weighted {
  Line line;
  double lack = 0;         // variance
  double chi_without = 0;  // chi-square with no lack
  bool errors_known = false;
};

// The least sum of squares where each point's variance is that of the side on which the line passes it: convex, and solved by
// weights of the last line, half a step where a point is passed on another side.
Line sided_line(const std::vector<OperatingPoint>& points, double lack, double slope) {
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
    line = weighted_line(points, variances);
    bool settled = round > 0 && std::abs(line.slope - slope) <= 1e-9 * std::abs(slope);
    slope = line.slope;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double rest = std::log(points[k].rate) - line.height - line.slope * (std::log(points[k].x) - line.centre);
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
  const Line plain = weighted_line(points, std::vector<double>(points.size(), 1.0));
  if (!out.errors_known) {
    out.line = plain;
    return out;
  }
  const auto freedom = static_cast<double>(points.size()) - 2;
  const auto excess = [&](double lack) { return sided_line(points, lack, plain.slope).chi_square - freedom; };
  out.chi_without = excess(0) + freedom;
  if (freedom > 0 && out.chi_without > freedom) {
    double high = 1e-6;
    while (excess(high) > 0) high *= 10;
    constexpr int bits = 20;
    std::uintmax_t most = 60;
    out.lack = boost::math::tools::toms748_solve(excess, 0.0, high, boost::math::tools::eps_tolerance<double>(bits), most).first;
  }
  out.line = sided_line(points, out.lack, plain.slope);
  return out;
}

double student(int freedom) { return boost::math::quantile(boost::math::students_t(freedom), 0.975); }

Interval95 exp_of(double centre, double half) { return {std::exp(centre - half), std::exp(centre + half)}; }

}  // namespace

double PowerLawFit::at(double x) const { return factor * std::pow(x, exponent); }

std::optional<Interval95> PowerLawFit::band_at(double x) const {
  if (points < 3) return std::nullopt;
  const double dx = std::log(x) - centre_and_covariance[0];
  return exp_of(std::log(at(x)), student(points - 2) * std::sqrt(centre_and_covariance[1] + dx * dx * centre_and_covariance[2]));
}

PowerLawFit fit_power_law(const std::vector<OperatingPoint>& points) {
  const Weighted w = weigh(points);
  PowerLawFit fit;
  fit.points = static_cast<int>(points.size());
  fit.exponent = w.line.slope;
  fit.factor = std::exp(w.line.height - w.line.slope * w.line.centre);
  fit.lack = std::sqrt(w.lack);
  const int freedom = fit.points - 2;
  const double scale = freedom > 0 ? w.line.chi_square / freedom : 0;
  fit.centre_and_covariance = {w.line.centre, scale * w.line.height_variance, scale * w.line.slope_variance};
  if (freedom < 1) return fit;
  if (w.errors_known) fit.p_of_law = boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), w.chi_without));
  const double half = student(freedom) * std::sqrt(scale * w.line.slope_variance);
  fit.exponent_ci95 = {{fit.exponent - half, fit.exponent + half}};
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
    squares += std::pow(std::log(point.rate) - line.height - line.slope * (std::log(point.x) - line.centre), 2);
    squares_mean += std::pow(std::log(point.rate) - mean, 2);
  }
  const auto root_mean = [&](double sum) { return std::sqrt(sum / static_cast<double>(points.size())); };
  if (possible) fit.held_out = root_mean(squares), fit.held_out_mean = root_mean(squares_mean);
  return fit;
}

}  // namespace quern
