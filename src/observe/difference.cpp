#include "src/observe/difference.hpp"
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace quern {
namespace {

double normal_quantile(double probability) { return boost::math::quantile(boost::math::normal(), probability); }

constexpr double upper = 0.975;

}  // namespace

Estimate difference(const Estimate& first, const Estimate& second) {
  Estimate d{second.value - first.value, std::nullopt};
  if (!first.ci95 || !second.ci95) return d;
  const auto below = [](const Estimate& e) { return e.value - (*e.ci95)[0]; };
  const auto above = [](const Estimate& e) { return (*e.ci95)[1] - e.value; };
  d.ci95 = {{d.value - std::hypot(below(second), above(first)), d.value + std::hypot(above(second), below(first))}};
  return d;
}

Verdict judge(const Estimate& d, double tolerance, int rows) {
  const auto [low, high] = d.ci95.value_or(std::array<double, 2>{d.value, d.value});
  const bool within = std::max(-low, high) <= tolerance;
  if (!d.ci95) return within ? Verdict::same : Verdict::moves;
  const double wider = normal_quantile(1 - (1 - upper) / std::max(1, rows)) / normal_quantile(upper);
  const bool differs = d.value + wider * (low - d.value) > 0 || d.value + wider * (high - d.value) < 0;
  if (differs) return within ? Verdict::moves_little : Verdict::moves;
  return within ? Verdict::same : Verdict::unknown;
}

double longer_by(const Estimate& d, double tolerance) {
  if (!d.ci95) return 1;
  const double half = 0.5 * ((*d.ci95)[1] - (*d.ci95)[0]), z = normal_quantile(upper);
  constexpr double found_on_one_side = 0.95;  // 90 % on both
  return std::max(1.0, std::pow(half / tolerance * (z + normal_quantile(found_on_one_side)) / z, 2));
}

}  // namespace quern
