// A small simulation that has begun, with all that watches it: what checkpoints and results are read into.
#pragma once
#include "src/case/build.hpp"
#include "src/case/values.hpp"
#include "src/observe/observers.hpp"

namespace quern {

inline constexpr const char* small_case = R"(
name = "small"
duration = "1 s"
[material.steel]
density = 7800
young = "10 MPa"
[pair.default]
restitution = 0.6
friction = 0.5
rolling_friction = 0.01
[species.ball]
material = "steel"
diameter = "25 mm"
[mill]
type = "tumbling"
diameter = "0.1 m"
length = "0.05 m"
speed_fraction = 0.7
[insert.charge]
species = "ball"
count = 6
[observe]
charge = true
spectrum = true
contact_history = true
track = [0, 3]
signal = true
)";

struct SmallRun {
  Case read;
  Simulation simulation;
  Observers observers;

  SmallRun() : read(named_case_of(read_values_in(small_case, "/nowhere/case.toml", {}))) {
    Built built = build_case(read);
    simulation = std::move(built.simulation);
    observers = Observers(built.observe);
    simulation.start(observers.needs_collisions());
    observers.see(simulation);
  }
};

}  // namespace quern
