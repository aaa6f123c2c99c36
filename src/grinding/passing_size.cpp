#include "src/grinding/passing_size.hpp"
#include <cmath>
#include <cstddef>
#include <limits>

namespace quern {

double passing_size(const std::vector<double>& sizes, const std::vector<double>& finer, double fraction) {
  for (std::size_t k = 1; k < sizes.size(); ++k) {
    if (!(finer[k - 1] <= fraction && fraction <= finer[k]) || finer[k] == finer[k - 1]) continue;
    const double part = (fraction - finer[k - 1]) / (finer[k] - finer[k - 1]);
    if (sizes[k - 1] <= 0) return part * sizes[k];
    return sizes[k - 1] * std::pow(sizes[k] / sizes[k - 1], part);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double passing_size_of_classes(const std::vector<double>& sizes, const std::vector<double>& amounts, double fraction) {
  const std::size_t n = sizes.size();
  if (n < 2) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> edges = {sizes[0] * std::sqrt(sizes[0] / sizes[1])}, finer = {0};
  for (std::size_t k = 0; k < n; ++k) {
    edges.push_back(k + 1 < n ? std::sqrt(sizes[k] * sizes[k + 1]) : sizes[k] * std::sqrt(sizes[k] / sizes[k - 1]));
    finer.push_back(finer.back() + amounts[k]);
  }
  for (double& f : finer) f /= finer.back();
  return passing_size(edges, finer, fraction);
}

}  // namespace quern
