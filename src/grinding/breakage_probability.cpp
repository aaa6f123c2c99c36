#include "src/grinding/breakage_probability.hpp"
#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include "src/base/random.hpp"
#include "src/grinding/saturation.hpp"

namespace quern {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
using Counts = std::vector<BreakageCount>;
using Pair = std::array<double, 2>;

// As searched for: ln f and W_min; ln m and ln W_s. Bounds stand for none and any.
struct Space {
  BreakageLaw law;
  Pair low, high;
};

// −ln S and so on: what is in the exponent of 1 − S.
double hazard(BreakageLaw law, double energy, const Pair& p) {
  if (law == BreakageLaw::vogel_peukert) return std::exp(p[0]) * std::max(0.0, energy - p[1]);
  return std::exp(std::min(700.0, std::exp(p[0]) * (std::log(energy) - p[1])));
}

// Minus the logarithm of the likelihood; ruled out ones get a large number that still has a slope.
double misfit(BreakageLaw law, const Counts& counts, const Pair& p) {
  constexpr double least = 1e-300;
  double sum = 0;
  for (const BreakageCount& c : counts) {
    const double h = hazard(law, c.energy, p);
    if (c.broken > 0) sum -= c.broken * std::log(std::max(least, -std::expm1(-h)));
    sum += (c.tested - c.broken) * h;
  }
  return sum;
}

Space space_of(BreakageLaw law, const Counts& counts) {
  double first_broken = counts.back().energy;
  for (const BreakageCount& c : counts)
    if (c.broken > 0) first_broken = std::min(first_broken, c.energy);
  const double last = counts.back().energy;
  if (law == BreakageLaw::vogel_peukert) return {law, {std::log(1e-5 / last), 0}, {std::log(1e5 / last), first_broken * (1 - 1e-12)}};
  constexpr double wide = 1e4;
  return {law, {std::log(0.01), std::log(counts.front().energy / wide)}, {std::log(300.0), std::log(last * wide)}};
}

// The least of a function with one minimum: a net, then Brent's way.
std::pair<double, double> least_of(const std::function<double(double)>& f, double from, double to, int net = 20) {
  std::vector<double> x, y;
  for (int k = 0; k <= net; ++k) x.push_back(from + (to - from) * k / net), y.push_back(f(x.back()));
  const auto at = static_cast<std::size_t>(std::min_element(y.begin(), y.end()) - y.begin());
  constexpr int bits = 24;
  std::uintmax_t most = 50;
  const auto [best, value] = boost::math::tools::brent_find_minima(f, x[at > 0 ? at - 1 : 0], x[std::min(at + 1, x.size() - 1)], bits, most);
  return value <= y[at] ? std::pair(best, value) : std::pair(x[at], y[at]);
}

// The least over the other parameter.
std::pair<double, double> profile(const Space& space, const Counts& counts, std::size_t held, double value) {
  const std::size_t other = 1 - held;
  return least_of(
      [&](double x) {
        Pair p;
        p[held] = value, p[other] = x;
        return misfit(space.law, counts, p);
      },
      space.low[other], space.high[other]);
}

Pair most_likely(const Space& space, const Counts& counts) {
  const double first = least_of([&](double x) { return profile(space, counts, 0, x).second; }, space.low[0], space.high[0], 24).first;
  return {first, profile(space, counts, 0, first).first};
}

// Where the profile of one parameter rises by half the quantile of χ² with one degree of freedom; a bound where it never does.
Interval95 profile_interval(const Space& space, const Counts& counts, std::size_t held, const Pair& best, double least) {
  constexpr double rise = 1.920729;
  const std::function<double(double)> excess = [&](double x) { return profile(space, counts, held, x).second - least - rise; };
  const auto end = [&](double bound) {
    const double at_bound = excess(bound);
    if (at_bound <= 0) return bound;
    std::uintmax_t most = 60;
    const bool upward = bound > best[held];
    const double a = upward ? best[held] : bound, b = upward ? bound : best[held];
    const auto [left, right] = boost::math::tools::toms748_solve(excess, a, b, upward ? -rise : at_bound, upward ? at_bound : -rise, boost::math::tools::eps_tolerance<double>(22), most);
    return 0.5 * (left + right);
  };
  return {end(space.low[held]), end(space.high[held])};
}

double deviance_of(BreakageLaw law, const Counts& counts, const Pair& p) {
  double full = 0;
  for (const BreakageCount& c : counts) {
    const int whole = c.tested - c.broken;
    if (c.broken > 0) full += c.broken * std::log(c.broken / static_cast<double>(c.tested));
    if (whole > 0) full += whole * std::log(whole / static_cast<double>(c.tested));
  }
  return 2 * std::max(0.0, misfit(law, counts, p) + full);
}

// As people write them.
Pair plain(BreakageLaw law, const Pair& p) { return {std::exp(p[0]), law == BreakageLaw::weibull ? std::exp(p[1]) : p[1]}; }

}  // namespace

double BreakageFit::at(double energy, double a, double b) const {
  if (law == BreakageLaw::vogel_peukert) return -std::expm1(-a * std::max(0.0, energy - b));
  return -std::expm1(-std::pow(energy / b, a));
}

Interval95 BreakageFit::band_at(double energy) const {
  std::vector<double> values;
  for (const Pair& p : redrawn) values.push_back(at(energy, p[0], p[1]));
  return SaturationFit::middle95(std::move(values)).value_or(Interval95{0, 1});
}

BreakageEvidence evidence_of(const Counts& counts) {
  int broken = 0, whole = 0;
  double first_broken = infinite, last_whole = 0;
  for (const BreakageCount& c : counts) {
    broken += c.broken, whole += c.tested - c.broken;
    if (c.broken > 0) first_broken = std::min(first_broken, c.energy);
    if (c.broken < c.tested) last_whole = std::max(last_whole, c.energy);
  }
  if (broken == 0) return BreakageEvidence::none_broke;
  if (whole == 0) return BreakageEvidence::all_broke;
  if (counts.size() == 1) return BreakageEvidence::one_level;
  return first_broken >= last_whole ? BreakageEvidence::step : BreakageEvidence::enough;
}

BreakageFit fit_breakage(const Counts& counts, BreakageLaw law, std::uint64_t seed, int draws) {
  const Space space = space_of(law, counts);
  const Pair best = most_likely(space, counts);
  BreakageFit fit;
  fit.law = law;
  const Pair values = plain(law, best);
  fit.first = values[0], fit.second = values[1];
  const double least = misfit(law, counts, best);
  fit.log_likelihood = -least;
  for (std::size_t held = 0; held < 2; ++held) {
    Interval95 ends = profile_interval(space, counts, held, best, least);
    const bool logarithm = held == 0 || law == BreakageLaw::weibull;
    const bool none = ends[0] <= space.low[held], any = logarithm && ends[1] >= space.high[held];
    if (logarithm) ends = {none ? 0 : std::exp(ends[0]), any ? infinite : std::exp(ends[1])};
    (held == 0 ? fit.first_ci95 : fit.second_ci95) = ends;
  }
  fit.deviance = deviance_of(law, counts, best);
  RandomStream random(seed, 0xb4e);
  int as_bad = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Counts drawn = counts;
    for (BreakageCount& c : drawn) {
      const double s = fit.at(c.energy);
      c.broken = 0;
      for (int k = 0; k < c.tested; ++k) c.broken += random.uniform() < s;
    }
    // Without broken ones, or without whole ones, the likelihood has no maximum; its bounds stand for it.
    const Pair redrawn = most_likely(space_of(law, drawn), drawn);
    as_bad += deviance_of(law, drawn, redrawn) >= fit.deviance * (1 - 1e-9);
    fit.redrawn.push_back(plain(law, redrawn));
  }
  if (counts.size() > 2 && draws > 0) fit.p_of_law = (as_bad + 1.0) / (draws + 1.0);
  return fit;
}

Interval95 proportion_interval(int hits, int trials) {
  const auto quantile = [](double a, double b, double p) { return boost::math::quantile(boost::math::beta_distribution<double>(a, b), p); };
  return {hits == 0 ? 0 : quantile(hits, trials - hits + 1, 0.025), hits == trials ? 1 : quantile(hits + 1, trials - hits, 0.975)};
}

}  // namespace quern
