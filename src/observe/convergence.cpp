#include "src/observe/convergence.hpp"
#include <fmt/format.h>
#include <algorithm>

namespace quern {

bool Convergence::due(const Simulation& simulation, const ObserverSettings& settings) const {
  const double interval = settings.convergence_interval;
  return interval > 0 && simulation.clock.time() >= next * interval - 0.5 * simulation.clock.time_step;
}

void Convergence::look(const Simulation& simulation, const CollisionSpectrum& spectrum, double start, const ObserverSettings& settings) {
  const double now = simulation.clock.time(), interval = settings.convergence_interval;
  next = std::max(next + 1, std::floor((now + 0.5 * simulation.clock.time_step) / interval) + 1);
  if (!spectrum.began) return;
  const CollisionSpectrum::Precision p = spectrum.precision(start);
  if (!(p.seconds > 0)) return;
  time.push_back(now);
  sampled.push_back(p.seconds);
  impact_rate.push_back(p.impact_rate);
  impact_half.push_back(p.impact_half);
  collision_rate.push_back(p.collision_rate);
  collision_half.push_back(p.collision_half);
  widest_bin.push_back(p.widest_bin);
  const double wanted = settings.stop_at_interval, wanted_of_bins = settings.stop_at_bin_interval;
  if (wanted <= 0 && wanted_of_bins <= 0) return;
  bool narrow = p.settled && p.impact_rate > 0;
  if (wanted > 0) narrow = narrow && p.impact_half <= wanted * p.impact_rate && p.collision_half <= wanted * p.collision_rate;
  if (wanted_of_bins > 0) narrow = narrow && p.widest_bin <= wanted_of_bins;
  if (!narrow) {
    narrow_since = -1;
    return;
  }
  if (narrow_since < 0) narrow_since = now, narrow_sampled = p.seconds;
  const double rounding = 0.5 * simulation.clock.time_step;
  reached = p.seconds >= least_spans * first_span(settings, simulation.clock.time_step) - rounding && now - narrow_since >= hold * narrow_sampled - rounding;
}

std::string Convergence::widths() const {
  if (time.empty()) return "";
  const auto percent = [](double half, double value) { return std::isfinite(half) && value > 0 ? fmt::format("{:.2g} %", 100 * half / value) : std::string("an unknown part"); };
  return fmt::format("after {:.4g} s of sampling the 95 % intervals are E_i ± {}, collisions per second ± {}, widest bin ± {}", sampled.back(),
                     percent(impact_half.back(), impact_rate.back()), percent(collision_half.back(), collision_rate.back()), percent(widest_bin.back(), 1));
}

std::vector<Table> Convergence::tables() const {
  if (time.empty()) return {};
  const auto bound = [](const std::vector<double>& value, const std::vector<double>& half, int side) {
    std::vector<double> out;
    for (std::size_t k = 0; k < value.size(); ++k) out.push_back(value[k] + side * half[k]);
    return out;
  };
  return {{"convergence", "how the intervals of the collision spectrum narrow with the time that was sampled",
           {{"time", "s", "simulated time", time, {}},
            {"sampled", "s", "of it sampled: since averages begin", sampled, {}},
            {"impact_energy_rate", "W", "E_i over what was sampled", impact_rate, {}},
            {"impact_energy_rate_low", "W", "lower end of its 95 % interval", bound(impact_rate, impact_half, -1), {}},
            {"impact_energy_rate_high", "W", "upper end of its 95 % interval", bound(impact_rate, impact_half, 1), {}},
            {"collision_rate", "1/s", "contacts that ended per second", collision_rate, {}},
            {"collision_rate_low", "1/s", "lower end of its 95 % interval", bound(collision_rate, collision_half, -1), {}},
            {"collision_rate_high", "1/s", "upper end of its 95 % interval", bound(collision_rate, collision_half, 1), {}},
            {"widest_bin", "1", "greatest half-width over rate of the bins of impact energy that carry at least 1 % of E_i", widest_bin, {}}}}};
}

}  // namespace quern
