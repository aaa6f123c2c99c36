#include "src/observe/soundness.hpp"
#include <algorithm>
#include <cmath>

namespace quern {
namespace {

bool positive(double x) { return std::isfinite(x) && x > 0; }

// Series that grow together.
bool all_of_length(std::size_t length, std::initializer_list<const std::vector<double>*> series) {
  return std::all_of(series.begin(), series.end(), [&](const auto* one) { return one->size() == length; });
}

template <class Sums, class Fits>
bool sound_blocks(const TimeBlocks<Sums>& blocks, bool began, Fits fits) {
  if (!began) return blocks.blocks.empty();
  return positive(blocks.span) && !blocks.blocks.empty() && blocks.blocks.size() <= TimeBlocks<Sums>::most &&
         std::all_of(blocks.blocks.begin(), blocks.blocks.end(), [&](const auto& block) { return fits(block.sums); });
}

bool sound_power(const TorquePower& t, const Simulation& s, const ObserverSettings& settings) {
  const std::size_t rows = t.time.size(), vial_rows = settings.planetary ? rows : 0;
  return all_of_length(rows, {&t.torque, &t.power, &t.wall_power, &t.ledger_power}) && all_of_length(vial_rows, {&t.vial_torque, &t.vial_power}) &&
         t.wall_names.size() == (t.began ? s.walls.size() : 0) && sound_blocks(t.walls, t.began, [&](const WallHistories& sums) { return sums.walls.size() == s.walls.size(); });
}

bool sound_shell(const ShellForce& f, const Simulation& s, const ObserverSettings& settings) {
  return all_of_length(f.time.size(), {&f.horizontal, &f.vertical}) && f.interval == (f.began ? std::max(settings.force_interval, s.clock.time_step) : 0);
}

// Of as many species as the particles have.
bool sound_species(const std::vector<std::string>& names, const Simulation& s) {
  constexpr std::size_t most = 255;
  return names.size() >= s.species.size() && names.size() <= most && std::all_of(s.particles.species.begin(), s.particles.species.end(), [&](std::uint8_t k) { return k < names.size(); });
}

bool sound_spectrum(const CollisionSpectrum& c, const Simulation& s, const ObserverSettings& settings) {
  if (c.began && (c.bins_per_decade != settings.bins_per_decade || !sound_species(c.species, s) || c.radii.size() != s.particles.id.size())) return false;
  if (!c.began && !(c.species.empty() && c.radii.empty())) return false;
  const std::size_t kinds = c.kinds(), bins = static_cast<std::size_t>(c.bins());
  const auto fits = [&](const SpectrumSums& sums) {
    const std::size_t totals = sums.totals.empty() ? 0 : kinds * contact_classes;
    return sums.totals.size() == totals && sums.histograms.size() == totals * energy_measures && (sums.carried.empty() || sums.carried.size() == kinds) &&
           std::all_of(sums.histograms.begin(), sums.histograms.end(), [&](const auto& histogram) { return histogram.empty() || histogram.size() == bins; });
  };
  return sound_blocks(c.ended, c.began, fits) && fits(c.lasting);
}

bool sound_captures(const Captures& c, const Simulation& s, const ObserverSettings& settings) {
  if (!c.began) return c.species.empty() && c.releases.empty() && c.blocks.blocks.empty();
  const auto known = [&](std::uint8_t kind) { return kind < c.species.size(); };
  const auto body = [&](std::uint8_t kind) { return kind == 255 || known(kind); };
  const auto fits = [&](const CaptureSums& sums) {
    constexpr int farthest = 100000;  // a bin; from the least number of a computer to the greatest there are 40 thousand at most
    return std::all_of(sums.kinds.begin(), sums.kinds.end(), [&](const auto& one) {
      const auto& [three, energies] = one;
      return body(three[0]) && body(three[1]) && known(three[2]) && (energies.empty() || (energies.begin()->first > -farthest && energies.rbegin()->first < farthest));
    });
  };
  return c.bins_per_decade == settings.bins_per_decade && sound_species(c.species, s) && c.mass.size() == s.particles.id.size() && c.kind.size() == c.mass.size() &&
         std::all_of(c.kind.begin(), c.kind.end(), known) && sound_blocks(c.blocks, true, fits) &&
         std::all_of(c.releases.begin(), c.releases.end(), [&](const auto& of) { return std::all_of(of.second.begin(), of.second.end(), [&](const Release& r) { return body(r.species); }); });
}

bool sound_convergence(const Convergence& c) {
  return all_of_length(c.time.size(), {&c.sampled, &c.impact_rate, &c.impact_half, &c.collision_rate, &c.collision_half, &c.widest_bin});
}

bool sound_charge(const Charge& c, const Simulation& s, const ObserverSettings& settings) {
  if (!c.began) return c.balls.empty() && c.blocks.blocks.empty();
  const PolarGrid& grid = c.grid;
  if (grid.radius_cells != settings.radius_cells || grid.angle_cells != settings.angle_cells || !positive(grid.radius) || !positive(grid.length)) return false;
  // Samples come after now, and not without end within a step; a line is read off within reach of the grid.
  constexpr double least_of_step = 1e-6, far = 1e6;
  if (!positive(c.interval) || c.interval < least_of_step * s.clock.time_step || !std::isfinite(c.next_sample) || c.next_sample < s.clock.time() || c.sampled < 0 || c.sampled > (std::int64_t{1} << 62)) return false;
  if (!std::isfinite(c.layer_from) || !std::isfinite(c.mean_diameter)) return false;
  for (const double x : {c.line_point[0], c.line_point[1]})
    if (!(std::abs(x) <= far * grid.radius)) return false;
  for (const double x : {c.line_direction[0], c.line_direction[1]})
    if (!(std::abs(x) <= 1.001)) return false;
  const auto fits = [&](const ChargeSums& sums) { return c.fits(sums); };
  return sound_blocks(c.blocks, true, fits) && c.balls.size() <= s.particles.id.size() &&
         std::all_of(c.balls.begin(), c.balls.end(), [](const BallTrack& ball) { return ball.held_angle >= 0 && ball.held_angle <= 360 && ball.flight_samples >= 0 && ball.flight_samples < (1 << 30); });
}

bool sound_contacts(const ContactHistory& h, const Simulation& s) {
  if (!(h.contacts.empty() && h.wall_names.empty()) && h.wall_names.size() != s.walls.size()) return false;
  return std::all_of(h.contacts.begin(), h.contacts.end(), [&](const ContactCourse& c) {
    return all_of_length(c.time.size(), {&c.force, &c.overlap, &c.closing}) && (c.second >= 0 || static_cast<std::size_t>(-1 - static_cast<std::int64_t>(c.second)) < h.wall_names.size());
  });
}

bool sound_fragments(const Fragmentation& f, const Simulation& s) {
  if (!f.began) return true;
  const Fragments bodies = find_bodies(s.bonds, s.particles, s.domain);
  return std::all_of(bodies.list.begin(), bodies.list.end(), [&](const Fragment& body) { return f.body_size.count(body.id) == 1; });
}

bool sound_loading(const Loading& l, const Simulation& s, const ObserverSettings& settings) {
  const std::size_t rows = l.time.size();
  const auto known = [&](const std::vector<RestingGrain>& grains) {
    return std::all_of(grains.begin(), grains.end(), [&](const RestingGrain& grain) { return grain.id >= 0 && static_cast<std::size_t>(grain.id) < s.particles.id.size(); });
  };
  return l.walls.size() == (l.began ? settings.loading.size() : 0) && (l.began || rows == 0) && all_of_length(rows, {&l.kinetic, &l.bond_energy, &l.broken}) &&
         all_of_length(settings.strain ? rows : 0, {&l.strain_along, &l.strain_across}) && l.gauge.size() == (l.gauges.empty() ? 0 : rows) &&
         std::all_of(l.walls.begin(), l.walls.end(), [&](const WallLoading& wall) { return all_of_length(rows, {&wall.displacement, &wall.force}); }) && known(l.specimen) && known(l.middle) &&
         std::all_of(l.gauges.begin(), l.gauges.end(), [&](const auto& gauge) { return !gauge.empty() && known(gauge); });
}

bool sound_discharge(const Discharge& d, const Simulation& s) {
  return d.mass.size() == d.time.size() && (!d.began || (std::isfinite(d.next) && d.next >= s.clock.time()));
}

}  // namespace

// What a case does not watch is not looked at again.
bool sound(const Observers& o, const Simulation& s) {
  const ObserverSettings& settings = o.settings;
  return (!settings.power || sound_power(o.torque_power, s, settings)) && (!settings.shell_force || sound_shell(o.shell_force, s, settings)) &&
         (!settings.spectrum || (sound_spectrum(o.spectrum, s, settings) && sound_captures(o.captures, s, settings) && sound_convergence(o.convergence))) &&
         (!settings.charge || sound_charge(o.charge, s, settings)) && (!settings.contact_history || sound_contacts(o.contact_history, s)) && (!settings.signal || o.signal.sound(s, settings)) &&
         (!settings.fragments || sound_fragments(o.fragments, s)) && (settings.loading.empty() || sound_loading(o.loading, s, settings)) && (!settings.discharge || sound_discharge(o.discharge, s));
}

}  // namespace quern
