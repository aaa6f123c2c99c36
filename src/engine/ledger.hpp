// The energy ledger: work done by walls and fields = Δ(kinetic + potential + elastic) + dissipated. All in joules, since the start.
#pragma once

namespace quern {

struct Ledger {
  // Stored now.
  double kinetic = 0;
  double potential = 0;  // of gravity
  double elastic = 0;    // in contact springs
  // Summed since the start.
  double wall_work = 0;      // done by moving walls on the particles
  double field_work = 0;     // done by fields other than gravity, and by gravity across a periodic boundary
  double normal_loss = 0;    // contact damping along the normal
  double sliding_loss = 0;   // friction and tangential damping
  double rolling_loss = 0;   // rolling resistance
  double stored_at_start = 0;
  double throughput = 0;     // Σ|work| in and out, the scale against which closure is judged

  double stored() const { return kinetic + potential + elastic; }
  double dissipated() const { return normal_loss + sliding_loss + rolling_loss; }
  // What the bookkeeping misses, and the same as a fraction of the work done (or of the energy that was there, if no work was).
  double gap() const { return wall_work + field_work - (stored() - stored_at_start) - dissipated(); }
  double closure() const;
};

}  // namespace quern
