// One body and how it stands to a wall, and what lies between two of its states.
#pragma once
#include <cstdint>
#include "src/engine/simulation.hpp"

namespace quern {

// The particle that was inserted first.
struct BodyState {
  double time = 0;  // of the simulation [s]
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), acceleration = Vec3::Zero(), spin = Vec3::Zero(), spin_rate = Vec3::Zero();
  double gap = 1e300, gap_rate = 0;  // from its surface to the wall [m], [m/s]
  double force = 0;                  // of all bodies on the wall, along the wall's normal: pushing it is positive [N]

  template <class Archive>
  void archive(Archive& a) {
    a(time, gap, gap_rate, force);
    for (Vec3* v : {&position, &velocity, &acceleration, &spin, &spin_rate}) a(v->x(), v->y(), v->z());
  }
};

BodyState body_state(const Simulation& simulation, const Wall* wall);

// The wall whose surface is nearest to that particle's; −1: there is none.
int nearest_wall(const Simulation& simulation);

// When the gap closed between two states, the first with a gap.
double touch_time(const BodyState& before, const BodyState& after);

// What is read off a body: a component of one of its vectors, or how it presses on the wall.
enum class BodyReading : std::uint8_t { position, velocity, spin, force, displacement };

// At a part s (0 … 1) of the way between two states, through value and slope at both; forces straight.
double value_between(BodyReading reading, int axis, const BodyState& before, const BodyState& after, double s);

// Earlier than the first state: straight on at the first velocity, without a force.
double value_before(BodyReading reading, int axis, const BodyState& first, double earlier);

}  // namespace quern
