#include "src/observe/fragments.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include "src/observe/fragment_tables.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// Of all grains, in the order of their ids.
double kinetic_energy_of_grains(const Simulation& s) {
  Index most = -1;
  for (const Bond& bond : s.bonds.list) most = std::max(most, bond.second);
  std::vector<bool> bonded(at(most + 1), false);
  for (const Bond& bond : s.bonds.list) bonded[at(bond.first)] = bonded[at(bond.second)] = true;
  std::vector<double> energy(bonded.size(), 0);
  const Particles& p = s.particles;
  for (Index row = 0; row < p.owned; ++row) {
    const Index id = p.id[at(row)];
    if (id > most || !bonded[at(id)]) continue;
    const Quad &v = p.velocity[at(row)], &w = p.spin[at(row)];
    energy[at(id)] = 0.5 * (v.w * dot(xyz(v), xyz(v)) + w.w * dot(xyz(w), xyz(w)));
  }
  return std::accumulate(energy.begin(), energy.end(), 0.0);
}

// The way the bodies fly at the start; where they do not, or not one way, down.
std::pair<Vec3, std::string> direction_of(const Simulation& s, const Fragments& bodies, const ObserverSettings& settings) {
  if (settings.impact_direction) return {settings.impact_direction->normalized(), "the direction of impact"};
  Vec3 momentum = Vec3::Zero();
  double momenta = 0;
  for (const Fragment& body : bodies.list) {
    momentum += body.mass * vec(body.velocity);
    momenta += body.mass * length(body.velocity);
  }
  constexpr double one_way = 0.1;
  if (momenta > 0 && momentum.norm() > one_way * momenta) return {momentum.normalized(), "the velocity at the start"};
  if (s.gravity.norm() > 0) return {s.gravity.normalized(), "the vertical"};
  return {Vec3::UnitZ(), "the z axis"};
}

}  // namespace

void Fragmentation::begin(const Simulation& simulation, const ObserverSettings& settings) {
  const Fragments bodies = find_bodies(simulation.bonds, simulation.particles, simulation.domain);
  for (std::size_t k = 0; k < bodies.list.size(); ++k) body_size[bodies.list[k].id] = sieve_size(bodies, k, simulation.particles);
  std::tie(direction, direction_name) = direction_of(simulation, bodies, settings);
  next = simulation.clock.time();
  began = true;
}

Damage Fragmentation::damage_of(const Simulation& s) {
  // Fragments change only when bonds fail.
  if (counted_failures_ != s.bonds.failures.size()) {
    counted_ = {};
    for (const BondFailure& failure : s.bonds.failures) (failure.mode == BondFailureMode::tension ? counted_.tension : counted_.shear) += 1;
    const Fragments all = find_fragments(s.bonds, s.particles, s.domain);
    std::map<Index, double> largest;
    double single = 0, most = 0;
    for (const Fragment& f : all.list) {
      largest.try_emplace(f.body, f.mass);  // they come by mass
      if (f.grains == 1) single += f.mass;
    }
    for (const auto& [body, mass] : largest) most += mass;
    counted_.ratio = s.bonds.damage();
    counted_.fragments = static_cast<double>(all.list.size());
    counted_.largest = all.mass > 0 ? most / all.mass : 0;
    counted_.fines = all.mass > 0 ? single / all.mass : 0;
    counted_failures_ = s.bonds.failures.size();
  }
  Damage now = counted_;
  now.time = s.clock.time();
  now.bond_energy = s.ledger.bond_energy, now.released = s.ledger.bond_failure;
  now.kinetic = kinetic_energy_of_grains(s);
  return now;
}

void Fragmentation::see(const Simulation& simulation, const ObserverSettings& settings) {
  if (simulation.bonds.empty()) return;
  if (!began) begin(simulation, settings);
  const double now = simulation.clock.time(), dt = simulation.clock.time_step;
  if (now < next - 0.5 * dt) return;
  const double interval = settings.fragment_interval > 0 ? settings.fragment_interval : 200 * dt;
  next = interval * (std::floor((now + 0.5 * dt) / interval) + 1);
  series.push_back(damage_of(simulation));
  constexpr std::size_t rows_per_sieving = 20;
  if (series.size() % rows_per_sieving == 1) sizes.push_back(product_size(simulation));
}

void Fragmentation::finish(const Simulation& simulation) {
  if (!began) return;
  std::vector<Damage> all = series;
  if (all.empty() || all.back().time < simulation.clock.time()) all.push_back(damage_of(simulation));
  const FragmentView view{simulation, all, sizes, body_size, direction, direction_name};
  std::tie(headlines_, tables_) = fragment_results(view);
}

}  // namespace quern
