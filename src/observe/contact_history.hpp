// The course of single contacts: force and overlap against time, and one line for each contact. For few particles.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct ContactCourse {
  Index first = 0, second = 0;  // ids of the particles; second: −1 − wall
  double start = 0, end = 0;    // first touch; parting, or the last step seen [s]
  bool lasting = true;
  double normal_speed = 0, tangential_speed = 0;  // at first touch [m/s]
  double peak_force = 0;                          // normal [N]
  double peak_overlap = 0;                        // [m]
  double normal_loss = 0, tangential_loss = 0;    // [J]
  // Each step while it lasts.
  std::vector<double> time;     // [s]
  std::vector<double> force;    // normal, by the contact law at this overlap and speed [N]
  std::vector<double> overlap;  // [m]
  std::vector<double> closing;  // speed of approach, negative while parting [m/s]
  template <class Archive>
  void archive(Archive& a) {
    a(first, second, start, end, lasting, normal_speed, tangential_speed, peak_force, peak_overlap, normal_loss, tangential_loss, time, force, overlap, closing);
  }
};

struct ContactHistory {
  std::vector<ContactCourse> contacts;  // in the order of their first touch
  std::vector<std::string> wall_names;

  // Needs Simulation::start(true).
  void see(const Simulation& simulation);
  // contacts.csv: one row for each contact; contact_history.csv: one row for each step of each.
  std::vector<Table> tables() const;

  template <class Archive>
  void archive(Archive& a) {
    a(contacts, wall_names);
  }
};

}  // namespace quern
