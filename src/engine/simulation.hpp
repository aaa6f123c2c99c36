// src/engine — the step, the time-step limit, the energy ledger, checkpoints. No file formats of results.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>
#include "bonds/bonds.hpp"
#include "mills/frame.hpp"
#include "shapes/superquadric.hpp"
#include "src/base/domain.hpp"
#include "src/base/threads.hpp"
#include "src/contact/contacts.hpp"
#include "src/engine/ledger.hpp"
#include "src/field/fields.hpp"
#include "src/material/material.hpp"
#include "src/particle/particles.hpp"
#include "src/wall/walls.hpp"

namespace quern {

struct Clock {
  std::int64_t step = 0;
  double time_step = 0;  // [s]
  double origin = 0;     // by which steps of other lengths moved it (Simulation::fly_for) [s]
  double time() const { return origin + static_cast<double>(step) * time_step; }
};

inline constexpr std::uint8_t no_law = 255;  // pair kind of materials that cannot meet

struct Species {
  std::string name;
  std::uint8_t material = 0;
};

// All of a simulation's state, and the step. State is data: observers read it and never change it.
struct Simulation {
  std::vector<Material> materials;
  std::vector<Species> species;
  std::vector<Superquadric> shapes;       // that particles name by index; 0: the unit ball. Empty where all are spheres
  std::vector<PairLaw> pair_laws;         // by pair kind
  std::vector<std::uint8_t> pair_kind;    // [a * materials + b] → kind or no_law, symmetric
  Domain domain;
  std::vector<Frame> frames;
  std::vector<Wall> walls;
  Vec3 gravity{0, 0, -9.81};              // [m/s²]
  std::vector<Field> fields;              // all others
  double carried_density = 0;             // added mass: of the fluid that moves with a particle, over the particle's volume [kg/m³]
  Particles particles;
  Bonds bonds;                            // between particles; made before start()
  Contacts contacts;
  Clock clock;
  Ledger ledger;
  std::shared_ptr<ThreadTeam> team = std::make_shared<ThreadTeam>(1);
  const Kernels* kernels = &best_kernels();

  // Call once when everything above is in place (record_collisions: whether collisions are written down).
  void start(bool record_collisions);
  void step();
  // One step that is as long as `steps` time steps, for a flight through free space: nothing may come to touch on the way (see
  // free_steps). The clock goes on by so many.
  void fly(std::int64_t steps);
  // One step of another length, up to an instant such as first touch.
  void fly_for(double time);

  // Fills the stored part of the ledger (kinetic, potential) for this instant; step() keeps the rest.
  void measure_energy();
  // The same numbers for observers, who change nothing: {kinetic, potential} [J].
  std::array<double, 2> kinetic_and_potential() const;
  // Collisions that ended in the last step, in a fixed order, and those still lasting now (flagged).
  const std::vector<Collision>& ended_collisions() const { return contacts.ended; }
  std::vector<Collision> lasting_collisions() const;

  // Of the ball of a particle's volume [m].
  double solid_radius(Index i) const;

  // Brings the walls to where the clock says.
  void move_walls();

  // Kept by start() and step().
  std::array<double, 2> reference_energy{0, 0};  // kinetic and potential at the start [J]
  double extent_of_particles = 0;                // of the box that holds them, as of the last search [m]

 private:
  void go_on(std::int64_t steps, double time_step);
  StepContext context() const;
};

}  // namespace quern
