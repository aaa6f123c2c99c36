#include "src/particle/turning.hpp"
#include "src/base/instruction_set.hpp"
#include "src/particle/free_turn.hpp"
#include "src/particle/turn_rows.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

UnitQuaternion<double> quaternion(const Rotation& q) { return {{q.x(), q.y(), q.z()}, q.w()}; }

}  // namespace

Rotation turned_freely(const Rotation& orientation, const Vec3& momentum, const Vec3& moments, double time) {
  const UnitQuaternion<double> q = quaternion(orientation);
  const UnitQuaternion<double> now = turned(q, into_own(q, triple(momentum)), triple(Vec3(time * moments.cwiseInverse())));
  return {now.scalar, now.vector.x, now.vector.y, now.vector.z};
}

Vec3 spin_of(const Rotation& orientation, const Vec3& momentum, const Vec3& moments) {
  const Vec3 own = orientation.conjugate() * momentum;
  return orientation * own.cwiseQuotient(moments);
}

void turn_shapes(Particles& p, Index first, Index last, const Quad* before, double time_step) {
#if defined(__x86_64__)
  const InstructionSet best = best_instruction_set();
  if (best == InstructionSet::avx512) return avx512::turn_shapes(p, first, last, before, time_step);
  if (best == InstructionSet::avx2) return avx2::turn_shapes(p, first, last, before, time_step);
#endif
  portable::turn_shapes(p, first, last, before, time_step);
}

void correct_momenta(Particles& p, Index first, Index last, const Torques& torques, double time_step) {
  for (Index i = first; i < last; ++i) {
    if (p.shape[at(i)] == 0) continue;
    const double* torque = torques.first + torques.stride * (i - first);
    add(p.momentum[at(i)], 0.5 * time_step * (Vec3(torque[0], torque[1], torque[2]) - vec(p.angular_acceleration[at(i)])));
  }
}

void set_spins(Particles& p, Index first, Index last) {
#if defined(__x86_64__)
  const InstructionSet best = best_instruction_set();
  if (best == InstructionSet::avx512) return avx512::set_spins(p, first, last);
  if (best == InstructionSet::avx2) return avx2::set_spins(p, first, last);
#endif
  portable::set_spins(p, first, last);
}

void set_spin(Particles& p, Index row, const Vec3& spin) {
  const Rotation q = rotation_of(p.orientation[at(row)]);
  const Vec3 own = q.conjugate() * spin;
  set(p.momentum[at(row)], q * own.cwiseProduct(vec(p.inertia[at(row)])));
  set(p.spin[at(row)], spin);
}

}  // namespace quern
