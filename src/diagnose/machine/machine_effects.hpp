// What may be missing from the simulation of a machine: each effect as one number that moves from where nothing happens.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/machine/machine_experiment.hpp"

namespace quern {

// A number that a fit of a machine may move.
struct MachineParameter {
  // Most act in the simulation; some act on what it shows, and need no run of their own.
  enum class Acts { simulated, bearing_torque, gear_loss, offset, gain };
  std::string key, unit;
  Acts acts = Acts::simulated;
  std::string channel;            // offset, gain
  double null = 0, scale = 1;     // where nothing happens (of a free key: the case's value), and a step of the design
  double lower = 0, upper = 0;
  std::vector<Parameter> moves;   // simulated: the keys of the case, which take the value together
  std::vector<Setting> settings;  // other keys that go with it
  int dimension = -1;             // its place among the parameters of the emulators

  double at(double z) const { return null + z * scale; }
  bool simulated() const { return acts == Acts::simulated; }
};

struct MachineCandidate {
  std::string effect, form;
  MachineParameter parameter;
  bool rival = false;             // a quantity that the case calls known, set free: shown, never a verdict
};

// The keys that the case sets free, as parameters.
std::vector<MachineParameter> free_parameters(const Values& base);

// Of the catalogue, what can act in this case on what was recorded and is not in the case or free already.
std::vector<MachineCandidate> machine_candidates(const MachineExperiment& experiment);

}  // namespace quern
