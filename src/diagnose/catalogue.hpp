// The catalogue: each effect that a comparison may name, in the forms in which the simulation can switch it on.
#pragma once
#include <string>
#include <vector>
#include "src/diagnose/comparison.hpp"

namespace quern {

// What people are told of an effect; `quern list effects` shows it.
struct EffectEntry {
  const char* name;
  const char* keys;        // with which a case switches it on
  const char* signature;   // by which an expert tells it
  const char* experiment;  // that would part it from its look-alikes
  const char* source;
};
std::vector<EffectEntry> all_effects();
const EffectEntry* find_effect(const std::string& name);

// One way in which something could be missing: keys of the case that move from where nothing happens.
struct Candidate {
  std::string effect;                  // of the catalogue; rivals that are no effect of it have names of their own, such as "gravity"
  std::string form;                    // in words, where an effect has several
  std::vector<Parameter> parameters;   // `value`: where nothing happens; the first is the strength
  std::vector<std::vector<double>> probes;  // values of the parameters at which a fit may begin, weak ones first
  std::vector<Setting> settings;       // other keys that go with it
  bool rival = false;                  // shown in the ranking, never a verdict: a known quantity set free, a distorted scale
  bool free_form = false;              // a learnt curve
};

// What the calibrated baseline is like: sizes from which probes and bounds follow.
struct Sizes {
  double mass = 0, radius = 0, density = 0, speed = 0, gravity = 0, duration = 0, spin = 0;  // typical, SI
  double overlap = 0, force = 0, contact_time = 0, impact_speed = 0;  // of the hardest contact; 0: none
  double acceleration = 0;       // typical, besides that of contacts
};
Sizes sizes_of(const Comparison& comparison, const Fit& baseline);

// All candidates that the case and the recording allow.
std::vector<Candidate> candidates_for(const Comparison& comparison, const Fit& baseline, const Sizes& sizes);

// Learnt curves: a force on the body, or in the contact, as a function of one quantity of its state.
std::vector<Candidate> free_forms_for(const Comparison& comparison, const Fit& baseline, const Sizes& sizes);

}  // namespace quern
