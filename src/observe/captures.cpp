#include "src/observe/captures.hpp"
#include <algorithm>
#include <cmath>
#include "src/observe/block_average.hpp"
#include "src/observe/spectrum.hpp"

namespace quern {
namespace {

constexpr std::uint8_t wall_species = 255;
constexpr double least_energy = 1e-15, most_energy = 1e30;  // [J]; below and above, all is one bin

}  // namespace

void CaptureBin::add(const CaptureBin& more) {
  count += more.count;
  normal_loss += more.normal_loss;
  tangential_loss += more.tangential_loss;
}

void CaptureSums::add(const CaptureSums& later) {
  for (const auto& [kind, bins] : later.kinds)
    for (const auto& [bin, sum] : bins) kinds[kind][bin].add(sum);
}

CaptureBin CaptureSums::total() const {
  CaptureBin all;
  for (const auto& [kind, bins] : kinds)
    for (const auto& [bin, sum] : bins) all.add(sum);
  return all;
}

void Captures::begin(const Simulation& simulation, const ObserverSettings& settings) {
  began = true;
  bins_per_decade = settings.bins_per_decade;
  for (const Species& s : simulation.species) species.push_back(s.name);
  const Particles& p = simulation.particles;
  mass.resize(static_cast<std::size_t>(p.owned));
  kind.resize(mass.size());
  for (Index i = 0; i < p.owned; ++i) {
    const auto id = static_cast<std::size_t>(p.id[static_cast<std::size_t>(i)]);
    mass[id] = p.mass(i);
    charge_mass += mass[id];
    kind[id] = p.species[static_cast<std::size_t>(i)];
    while (species.size() <= kind[id]) species.push_back("species_" + std::to_string(species.size()));
  }
  blocks.span = first_span(settings, simulation.clock.time_step);
  blocks.open(simulation.clock.time());
}

void Captures::take(const Collision& c, CaptureSums& sums) {
  const auto mass_of = [&](Index id) { return id < 0 ? HUGE_VAL : mass[static_cast<std::size_t>(id)]; };
  const bool first_is_less = mass_of(c.first_id) <= mass_of(c.second_id);
  const Index particle = first_is_less ? c.first_id : c.second_id, body = first_is_less ? c.second_id : c.first_id;
  if (mass_of(body) < larger * mass_of(particle)) return;
  Release now{body, body < 0 ? wall_species : kind[static_cast<std::size_t>(body)], c.end_time, c.record.normal_loss, c.record.tangential_loss};
  std::array<Release, 4>& known = releases[particle];
  const Release* other = nullptr;
  CaptureBin both{1, now.normal_loss, now.tangential_loss};
  for (Release& release : known) {
    if (release.body == body || release.end <= c.record.start_time) continue;
    if (!other || release.end > other->end) other = &release;
    both.add({0, release.normal_loss, release.tangential_loss});
    release.normal_loss = release.tangential_loss = 0;
  }
  if (other) {
    const int bin = static_cast<int>(std::floor(std::log10(std::clamp(both.loss(), least_energy, most_energy)) * bins_per_decade));
    const auto [low, high] = std::minmax(now.species, other->species);
    sums.kinds[{low, high, kind[static_cast<std::size_t>(particle)]}][bin].add(both);
    now.normal_loss = now.tangential_loss = 0;
  }
  // It takes the place of the same body's last contact, or of the oldest.
  auto place = std::find_if(known.begin(), known.end(), [&](const Release& r) { return r.end > 0 && r.body == body; });
  if (place == known.end()) place = std::min_element(known.begin(), known.end(), [](const Release& a, const Release& b) { return a.end < b.end; });
  *place = now;
}

void Captures::see(const Simulation& simulation, const ObserverSettings& settings) {
  const double now = simulation.clock.time(), dt = simulation.clock.time_step;
  if (!began) {
    if (now < settings.start_time - 0.5 * dt) return;
    begin(simulation, settings);
    until = now;
    return;
  }
  if (blocks.due(now - dt)) blocks.open(now - dt);
  for (const Collision& c : simulation.ended_collisions()) take(c, blocks.blocks.back().sums);
  blocks.blocks.back().to = until = now;
}

std::vector<Headline> Captures::headlines(double start) const {
  if (blocks.blocks.empty()) return {};
  const std::size_t first = blocks.first_from(start);
  const CaptureBin all = blocks.total(first).total();
  const double seconds = until - blocks.blocks[first].from;
  if (!(all.count > 0 && seconds > 0)) return {};
  std::vector<double> rates;
  for (std::size_t b = first; b < blocks.blocks.size(); ++b) {
    const auto& block = blocks.blocks[b];
    const double end = b + 1 < blocks.blocks.size() ? blocks.blocks[b + 1].from : until;
    if (end - block.from > 0.5 * blocks.span) rates.push_back(block.sums.total().count / (end - block.from));
  }
  std::optional<std::array<double, 2>> interval = block_average(rates).ci95;
  if (interval) {
    const double half = 0.5 * ((*interval)[1] - (*interval)[0]);
    interval = {{all.count / seconds - half, all.count / seconds + half}};
  }
  return {{"capture_rate", all.count / seconds, "1/s", interval, "particles caught between two larger bodies per second"},
          {"capture_power", all.loss() / seconds, "W", std::nullopt, "dissipated in such captures per second"},
          {"mean_capture_energy", all.loss() / all.count, "J", std::nullopt, "dissipated per capture"}};
}

std::vector<Table> Captures::tables(double start) const {
  if (blocks.blocks.empty()) return {};
  const std::size_t first = blocks.first_from(start);
  const double seconds = until - blocks.blocks[first].from;
  const CaptureSums sums = blocks.total(first);
  if (sums.kinds.empty() || !(seconds > 0)) return {};
  const auto name = [&](std::uint8_t s) { return s == wall_species ? std::string("wall") : species[s]; };
  Column bodies{"bodies", "1", "larger body, particle, larger body", {}, {}};
  Column low{"energy_from", "J", "lower end of the bin", {}, {}}, high{"energy_to", "J", "upper end of the bin", {}, {}};
  Column count{"count", "1", "captures in the bin", {}, {}}, rate{"rate", "1/s", "captures per second", {}, {}};
  Column rate_low{"rate_low", "1/s", "lower end of the 95 % interval (Poisson)", {}, {}}, rate_high{"rate_high", "1/s", "upper end of the 95 % interval (Poisson)", {}, {}};
  Column loss{"dissipated", "W", "energy dissipated per second", {}, {}}, normal{"normal", "W", "its part along the normal", {}, {}};
  Column shear{"shear", "W", "its part by sliding and rolling", {}, {}};
  Column specific{"specific", "W/kg", "energy dissipated per second and mass of charge", {}, {}};
  for (const auto& [three, bins] : sums.kinds) {
    for (const auto& [bin, sum] : bins) {
      bodies.labels.push_back(name(three[0]) + "-" + name(three[2]) + "-" + name(three[1]));
      low.values.push_back(std::pow(10.0, static_cast<double>(bin) / bins_per_decade));
      high.values.push_back(std::pow(10.0, static_cast<double>(bin + 1) / bins_per_decade));
      count.values.push_back(sum.count);
      rate.values.push_back(sum.count / seconds);
      const auto [from, to] = poisson_interval(sum.count);
      rate_low.values.push_back(from / seconds);
      rate_high.values.push_back(to / seconds);
      loss.values.push_back(sum.loss() / seconds);
      normal.values.push_back(sum.normal_loss / seconds);
      shear.values.push_back(sum.tangential_loss / seconds);
      specific.values.push_back(sum.loss() / seconds / charge_mass);
    }
  }
  return {{"captures", "particles caught between two larger bodies, by the energy that the capture dissipated", {bodies, low, high, count, rate, rate_low, rate_high, loss, normal, shear, specific}}};
}

}  // namespace quern
