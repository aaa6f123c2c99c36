// The energy ledger: work done by walls and fields = Δ(kinetic + potential + elastic + bonds) + dissipated. All in joules, since the start.
#pragma once

namespace quern {

struct Ledger {
  // Stored now.
  double kinetic = 0;    // with that of the fluid that moves with the particles, where there is added mass
  double potential = 0;  // of gravity
  double elastic = 0;    // in contact springs
  double bond_energy = 0;  // in bonds
  // Summed since the start.
  double wall_work = 0;      // done by moving walls on the particles
  double field_work = 0;     // done by fields other than gravity, and by gravity across a periodic boundary
  double normal_loss = 0;    // contact damping along the normal
  double sliding_loss = 0;   // friction and tangential damping
  double rolling_loss = 0;   // rolling resistance
  double bond_loss = 0;      // damping of bonds
  double bond_failure = 0;   // stored in bonds when they failed
  double stored_at_start = 0;
  double throughput = 0;     // Σ|work of the walls|, step by step

  double stored() const { return kinetic + potential + elastic + bond_energy; }
  double dissipated() const { return normal_loss + sliding_loss + rolling_loss + bond_loss + bond_failure; }
  // What the bookkeeping misses [J], and the same as a fraction of the work done: by walls, by gravity (the largest change of
  // potential or kinetic energy seen when the energy was measured), or turned into heat, whichever is largest.
  double gap() const { return wall_work + field_work - (stored() - stored_at_start) - dissipated(); }
  double closure() const;
  double exchanged = 0;      // largest change of kinetic or potential energy since the start seen so far
};

}  // namespace quern
