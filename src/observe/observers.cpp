#include "src/observe/observers.hpp"

#include <iterator>

namespace quern {

namespace {

template <class T>
void append(std::vector<T>& all, std::vector<T> more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

void Observers::see(const Simulation& simulation) {
  if (settings.power) torque_power.see(simulation, settings);
  if (settings.shell_force) shell_force.see(simulation, settings);
  if (settings.spectrum) spectrum.see(simulation, settings);
  if (settings.spectrum) captures.see(simulation, settings);
  if (settings.spectrum && convergence.due(simulation, settings)) convergence.look(simulation, spectrum, steady_time(), settings);
  if (settings.charge) charge.see(simulation, settings);
  if (settings.contact_history) contact_history.see(simulation);
  if (!settings.track.empty()) track.see(simulation, settings);
  if (settings.signal) signal.see(simulation, settings);
  if (settings.fragments) fragments.see(simulation, settings);
  if (!settings.loading.empty()) loading.see(simulation, settings);
  if (settings.discharge) discharge.see(simulation, settings);
}

void Observers::finish(const Simulation& simulation) {
  if (settings.spectrum) spectrum.finish(simulation);
  if (!settings.track.empty()) track.finish(simulation, settings);
  if (settings.fragments) fragments.finish(simulation);
}

double Observers::steady_time() const {
  if (settings.start_time >= 0) return settings.start_time;
  return settings.power ? torque_power.steady_time(settings) : 0.0;
}

std::vector<Headline> Observers::headlines() const {
  const double from = steady_time();
  std::vector<Headline> all;
  if (settings.power) append(all, torque_power.headlines(settings));
  if (settings.shell_force) append(all, shell_force.headlines(settings, from));
  if (settings.charge) append(all, charge.headlines(from));
  if (settings.spectrum) append(all, spectrum.headlines(from));
  if (settings.spectrum) append(all, captures.headlines(from));
  if (settings.fragments) append(all, fragments.headlines());
  if (!settings.loading.empty()) append(all, loading.headlines(settings));
  if (settings.discharge) append(all, discharge.headlines(settings));
  return all;
}

std::vector<Table> Observers::tables() const {
  const double from = steady_time();
  std::vector<Table> all;
  if (settings.power) append(all, torque_power.tables());
  if (settings.shell_force) append(all, shell_force.tables(settings, from));
  if (settings.charge) append(all, charge.tables(settings, from));
  if (settings.spectrum) append(all, spectrum.tables(from));
  if (settings.spectrum) append(all, captures.tables(from));
  if (settings.spectrum) append(all, convergence.tables());
  if (settings.contact_history) append(all, contact_history.tables());
  if (!settings.track.empty()) append(all, track.tables());
  if (settings.signal) append(all, signal.tables());
  if (settings.fragments) append(all, fragments.tables());
  if (!settings.loading.empty()) append(all, loading.tables(settings));
  if (settings.discharge) append(all, discharge.tables());
  return all;
}

}  // namespace quern
