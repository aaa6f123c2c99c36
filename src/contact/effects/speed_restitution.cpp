#include "src/contact/effects/speed_restitution.hpp"
#include <algorithm>
#include <cmath>
#include <vector>
#include "src/contact/restitution.hpp"

namespace quern {
namespace {

// −ln e measured at ascending damping ratios β = β_most (k/n)².
struct Measured {
  static constexpr int count = 400;
  static constexpr double most = 8;
  std::vector<double> logarithm;

  explicit Measured(SpeedRestitution::Mapping mapping) {
    for (int k = 0; k <= count; ++k) {
      const double beta = ratio(k);
      const ContactLaw law = mapping == SpeedRestitution::Mapping::linear ? ContactLaw(Linear{1, 1, beta, 0}) : ContactLaw(HertzMindlin{0.75, 1, beta, 0});
      const double e = k == 0 ? 1 : collide_head_on(law, 1, 1, 1).restitution;
      logarithm.push_back(e > 0 ? -std::log(e) : 1e3);
      if (e < 0.5 * SpeedRestitution::least) break;
    }
  }
  static double ratio(double k) { return most * (k / count) * (k / count); }
  double damping_ratio(double restitution) const {
    const double wanted = -std::log(restitution);
    const auto above = std::lower_bound(logarithm.begin() + 1, logarithm.end() - 1, wanted);
    const double share = (wanted - *(above - 1)) / (*above - *(above - 1));
    const double k = static_cast<double>(above - logarithm.begin()), low = ratio(k - 1), high = ratio(k);
    return low + share * (high - low);
  }
};

double damping_ratio(SpeedRestitution::Mapping mapping, double restitution) {
  static const Measured linear(SpeedRestitution::Mapping::linear), hertz(SpeedRestitution::Mapping::hertz);
  return (mapping == SpeedRestitution::Mapping::linear ? linear : hertz).damping_ratio(restitution);
}

}  // namespace

double SpeedRestitution::at(double speed) const {
  return std::clamp(1 - (1 - restitution) * std::pow(std::max(0.0, speed) / reference_speed, exponent), least, 1.0);
}

double SpeedRestitution::damping_scale(double speed) const {
  return std::max(1e-30, damping_ratio(mapping, at(speed)) / damping_ratio(mapping, restitution));
}

}  // namespace quern
