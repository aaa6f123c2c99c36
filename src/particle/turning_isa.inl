// How bodies turn, eight at once, for one instruction set.
#include "src/base/pack.hpp"
#include "src/particle/free_turn.hpp"
#include "src/particle/turn_rows.hpp"

namespace quern::QUERN_ISA {
namespace {

using PackTriple = Triple<Pack>;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

QUERN_INLINE UnitQuaternion<Pack> quaternion(const QuadPack& q) { return {q.xyz(), q.w}; }
QUERN_INLINE QuadPack quad(const PackTriple& v, const Pack& w) { return {v.x, v.y, v.z, w}; }

// Eight rows of arrays from one on; where they end before `last`, the last one stands in, and what is written for it goes nowhere.
struct EightRows {
  const Particles& p;
  Index from, last;
  Index row(int k) const { return from + k < last ? from + k : last - 1; }
  QUERN_INLINE QuadPack of(const std::vector<Quad>& rows) const {
    return gather_rows([&](int k) { return &rows[at(row(k))].x; });
  }
  QUERN_INLINE void to(std::vector<Quad>& rows, const QuadPack& what, bool spheres) const {
    alignas(64) Quad nowhere;
    scatter_rows(what, [&](int k) { return from + k < last && (spheres || p.shape[at(from + k)] != 0) ? &rows[at(from + k)].x : &nowhere.x; });
  }
};

QUERN_INLINE PackTriple spin_of(const UnitQuaternion<Pack>& q, const PackTriple& momentum, const PackTriple& moments) {
  const PackTriple own = into_own(q, momentum);
  return into_fixed<Pack>(q, {own.x / moments.x, own.y / moments.y, own.z / moments.z});
}

}  // namespace

void turn_shapes(Particles& p, Index first, Index last, const Quad* before, double time_step) {
  const Pack step(time_step), half(0.5), two(2.0);
  for (Index from = first; from < last; from += lanes) {
    const EightRows rows{p, from, last};
    const QuadPack velocity = rows.of(p.velocity), torque = rows.of(p.angular_acceleration), momentum = rows.of(p.momentum), spin = rows.of(p.spin), position = rows.of(p.position);
    const PackTriple moments = rows.of(p.inertia).xyz();
    const UnitQuaternion<Pack> old = quaternion(gather_rows([&](int k) { return &before[rows.row(k) - first].x; }));
    const Pack moved = step * length(velocity.xyz() - half * step * rows.of(p.acceleration).xyz());  // `advance` has predicted already
    const PackTriple middle = momentum.xyz() + half * step * torque.xyz(), predicted = momentum.xyz() + step * torque.xyz();
    const UnitQuaternion<Pack> q = turned(old, into_own(old, middle), {step / moments.x, step / moments.y, step / moments.z});
    const PackTriple change = q.vector - old.vector;
    const Pack scalar = q.scalar - old.scalar, path = momentum.w + moved;
    rows.to(p.orientation, quad(q.vector, q.scalar), false);
    rows.to(p.momentum, quad(momentum.xyz(), path), true);
    rows.to(p.momentum, quad(predicted, path + two * position.w * square_root(dot(change, change) + scalar * scalar)), false);
    rows.to(p.spin, quad(spin_of(q, predicted, moments), spin.w), false);
  }
}

void set_spins(Particles& p, Index first, Index last) {
  for (Index from = first; from < last; from += lanes) {
    const EightRows rows{p, from, last};
    rows.to(p.spin, quad(spin_of(quaternion(rows.of(p.orientation)), rows.of(p.momentum).xyz(), rows.of(p.inertia).xyz()), rows.of(p.spin).w), false);
  }
}

}  // namespace quern::QUERN_ISA
