#include "src/grinding/schuhmann.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>
#include "src/base/random.hpp"

namespace quern {
namespace {

struct Line {
  double modulus, size;
};

// Through ln F against ln x; none where fewer than two sieves have something below them, or the line does not rise.
std::optional<Line> line_through(const std::vector<double>& x, const std::vector<double>& finer) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!(finer[k] > 0)) continue;
    const double a = std::log(x[k]), b = std::log(finer[k]);
    n += 1, sx += a, sy += b, sxx += a * a, sxy += a * b;
  }
  const double spread = n * sxx - sx * sx;
  if (n < 2 || !(spread > 0)) return std::nullopt;
  const double slope = (n * sxy - sx * sy) / spread;
  if (!(slope > 0)) return std::nullopt;
  return Line{slope, std::exp((sx - sy / slope) / n)};
}

// Which sieve is the first that a fragment passes; sieves.size(): none.
std::vector<std::size_t> classes_of(const std::vector<double>& sizes, const std::vector<double>& sieves) {
  std::vector<std::size_t> classes;
  for (const double size : sizes)
    classes.push_back(static_cast<std::size_t>(std::lower_bound(sieves.begin(), sieves.end(), size * (1 - 1e-9)) - sieves.begin()));
  return classes;
}

Interval95 middle_of(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto last = static_cast<double>(samples.size() - 1);
  return {samples[static_cast<std::size_t>(0.025 * last)], samples[static_cast<std::size_t>(std::ceil(0.975 * last))]};
}

}  // namespace

double SchuhmannFit::at(double x) const { return std::min(1.0, std::pow(x / size, modulus)); }

std::optional<SchuhmannFit> fit_schuhmann(const std::vector<double>& sizes, const std::vector<double>& masses, double finest) {
  constexpr double highest = 0.8, farthest = 2;
  constexpr std::size_t least_sieves = 4, least_fragments = 20, samples = 400;
  if (sizes.empty() || !(finest > 0)) return std::nullopt;
  const double largest = *std::max_element(sizes.begin(), sizes.end()), whole = std::accumulate(masses.begin(), masses.end(), 0.0);
  SchuhmannFit fit;
  for (double x = finest; x < largest; x *= std::sqrt(2.0)) fit.sieves.push_back(x);
  std::vector<std::size_t> classes = classes_of(sizes, fit.sieves);
  const auto finer_of = [&](auto&& drawn) {
    std::vector<double> finer(fit.sieves.size() + 1, 0);
    double sum = 0;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const std::size_t one = drawn(k);
      finer[classes[one]] += masses[one], sum += masses[one];
    }
    finer.pop_back();
    std::partial_sum(finer.begin(), finer.end(), finer.begin());
    for (double& f : finer) f /= sum;
    return finer;
  };
  const auto itself = [](std::size_t k) { return k; };
  fit.finer = finer_of(itself);
  const auto too_high = std::find_if(fit.finer.begin(), fit.finer.end(), [](double f) { return f >= highest; });
  fit.finer.erase(too_high, fit.finer.end());
  fit.sieves.resize(fit.finer.size());
  classes = classes_of(sizes, fit.sieves);
  const auto in_range = std::count_if(classes.begin(), classes.end(), [&](std::size_t c) { return 0 < c && c < fit.sieves.size(); });
  if (!(whole > 0) || fit.sieves.size() < least_sieves || static_cast<std::size_t>(in_range) < least_fragments) return std::nullopt;
  const std::optional<Line> line = line_through(fit.sieves, fit.finer);
  if (!line || line->size > farthest * largest) return std::nullopt;
  fit.modulus = line->modulus, fit.size = line->size;

  std::vector<double> moduli, scales;
  RandomStream random(1);
  const auto any = [&](std::size_t) { return static_cast<std::size_t>(random.uniform() * static_cast<double>(sizes.size())); };
  for (std::size_t k = 0; k < samples; ++k)
    if (const auto again = line_through(fit.sieves, finer_of(any))) moduli.push_back(again->modulus), scales.push_back(again->size);
  if (moduli.size() < samples / 2) return std::nullopt;
  fit.modulus_ci95 = middle_of(moduli), fit.size_ci95 = middle_of(scales);
  return fit;
}

}  // namespace quern
