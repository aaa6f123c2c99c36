#include "src/observe/discharge.hpp"
#include <algorithm>
#include <iterator>
#include "src/observe/block_average.hpp"

namespace quern {
namespace {

double mass_beyond(const Particles& p, const OutletPlane& plane) {
  double mass = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(p.owned); ++k)
    if ((vec(p.position[k]) - plane.point).dot(plane.direction) > 0) mass += p.velocity[k].w;
  return mass;
}

}  // namespace

void Discharge::see(const Simulation& s, const ObserverSettings& settings) {
  const double now = s.clock.time();
  if (!began) {
    began = true, began_at = now, next = now + settings.discharge_interval;
    first_mass = mass_beyond(s.particles, *settings.discharge);
    return;
  }
  if (now < next - 0.5 * s.clock.time_step) return;
  while (next < now + 0.5 * s.clock.time_step) next += settings.discharge_interval;
  time.push_back(now);
  mass.push_back(mass_beyond(s.particles, *settings.discharge) - first_mass);
}

std::vector<double> Discharge::rates() const {
  std::vector<double> rates(time.size());
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double before = k > 0 ? time[k - 1] : began_at, mass_before = k > 0 ? mass[k - 1] : 0;
    rates[k] = (mass[k] - mass_before) / (time[k] - before);
  }
  return rates;
}

std::vector<Headline> Discharge::headlines(const ObserverSettings& settings) const {
  if (time.empty()) return {};
  const std::vector<double> all = rates();
  const auto from = settings.start_time < 0 ? static_cast<std::ptrdiff_t>(steady_start(all))
                                            : std::upper_bound(time.begin(), time.end(), settings.start_time + 0.5 * settings.discharge_interval) - time.begin();
  std::vector<Headline> lines{{"discharged_mass", mass.back(), "kg", std::nullopt, "through the plane since the start"}};
  if (from >= std::ssize(all)) return lines;
  const BlockAverage rate = block_average(std::vector<double>(all.begin() + from, all.end()));
  lines.push_back({"discharge_rate", rate.mean, "kg/s", rate.ci95, "mass through the plane per second since averages begin"});
  return lines;
}

std::vector<Table> Discharge::tables() const {
  return {{"discharge", "mass through the plane",
           {{"time", "s", "end of the interval", time, {}},
            {"mass", "kg", "of the particles that have passed through the plane since the start, by their centres", mass, {}},
            {"rate", "kg/s", "mean of the interval", rates(), {}}}}};
}

}  // namespace quern
