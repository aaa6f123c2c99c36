// Everything that watches one run. Use: make from settings; see() after every step; finish() before the results are read.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/captures.hpp"
#include "src/observe/charge.hpp"
#include "src/observe/contact_history.hpp"
#include "src/observe/convergence.hpp"
#include "src/observe/discharge.hpp"
#include "src/observe/fragments.hpp"
#include "src/observe/loading.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/shell_force.hpp"
#include "src/observe/signal.hpp"
#include "src/observe/spectrum.hpp"
#include "src/observe/table.hpp"
#include "src/observe/torque_power.hpp"
#include "src/observe/track.hpp"

namespace quern {

struct Observers {
  ObserverSettings settings;
  TorquePower torque_power;
  ShellForce shell_force;
  CollisionSpectrum spectrum;
  Captures captures;
  Convergence convergence;
  Charge charge;
  ContactHistory contact_history;
  Track track;
  Signal signal;
  Fragmentation fragments;
  Loading loading;
  Discharge discharge;

  Observers() = default;
  explicit Observers(const ObserverSettings& chosen) : settings(chosen) {}

  // Whether Simulation::start must record collisions.
  bool needs_collisions() const { return settings.spectrum || settings.charge || settings.contact_history; }
  // Call once after Simulation::start and after each step.
  void see(const Simulation& simulation);
  // Takes in what is still going on (contacts that last). May be called any number of times and the run may go on after it.
  void finish(const Simulation& simulation);

  // Where averages begin [s].
  double steady_time() const;
  std::vector<Headline> headlines() const;
  std::vector<Table> tables() const;

  // All that was seen, not the settings: those come from the case.
  template <class Archive>
  void archive(Archive& a) {
    a(torque_power, shell_force, spectrum, captures, convergence, charge, contact_history, track, signal, fragments, loading, discharge);
  }
};

}  // namespace quern
