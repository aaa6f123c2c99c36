// NestedNorm for eight directions or bodies at once: the same formulas, see there.
#pragma once
#include "src/base/pack_power.hpp"

namespace quern::QUERN_ISA {

using PackTriple = Triple<Pack>;

struct NormPack {
  PackTriple scale;
  QUERN_INLINE static Pack size(const Pack& a) { return greater(a, -a); }
  struct Exponent {
    Pack p, inverse;
    Mask other;  // than 2
    bool round;  // none is

    QUERN_INLINE explicit Exponent(const Pack& exponent) : p(exponent), inverse(Pack(1.0) / exponent), other(size(exponent - Pack(2.0)) > Pack(0.0)), round(bits(other) == 0) {}
  };
  Exponent outer, inner;

  QUERN_INLINE NormPack(const PackTriple& s, const Pack& p_outer, const Pack& p_inner) : scale(s), outer(p_outer), inner(p_inner) {}

  struct First {
    Pack value;
    PackTriple gradient;
  };
  QUERN_INLINE First first(const PackTriple& x) const {
    const PackTriple u = scaled_place(x);
    const Pair flat = pair(size(u.x), size(u.y), inner), whole = pair(flat.size, size(u.z), outer);
    return {whole.size, gradient(x, flat, whole)};
  }

  // The Hessian is across acrossᵀ + ring ringᵀ.
  struct Second {
    Pack value;
    PackTriple gradient;
    PackTriple across, ring;
    QUERN_INLINE Pack bend(const PackTriple& a, const PackTriple& b) const { return dot(across, a) * dot(across, b) + dot(ring, a) * dot(ring, b); }
  };
  QUERN_INLINE Second second(const PackTriple& x) const {
    const PackTriple u = scaled_place(x), s = signed_scale(x);
    const Pair flat = pair(size(u.x), size(u.y), inner), whole = pair(flat.size, size(u.z), outer);
    const Pack inverse = Pack(1.0) / whole.size, part = greater(flat.size, Pack(1e-270) * whole.size) * inverse;
    const Pack root = square_root(whole.bend * inverse);
    const Pack root_ring = square_root(lesser(Pack(most), whole.slope_u * flat.bend / part) * inverse);
    return {whole.size, gradient(x, flat, whole),
            {root * (whole.v * flat.slope_u) * s.x, root * (whole.v * flat.slope_v) * s.y, -(root * whole.u * s.z)},
            {root_ring * flat.v * s.x, -(root_ring * flat.u * s.y), Pack(0.0)}};
  }

 private:
  static constexpr double most = 1e9;
  // u and v: the two over the size; the slopes: its derivatives; bend: (p − 1) u^{p−2} v^{p−2}.
  struct Pair {
    Pack size, u, v, slope_u, slope_v, bend;
  };
  QUERN_INLINE PackTriple scaled_place(const PackTriple& x) const { return {scale.x * x.x, scale.y * x.y, scale.z * x.z}; }
  QUERN_INLINE PackTriple signed_scale(const PackTriple& x) const {
    const Pack zero(0.0);
    return {select(x.x < zero, -scale.x, scale.x), select(x.y < zero, -scale.y, scale.y), select(x.z < zero, -scale.z, scale.z)};
  }
  QUERN_INLINE PackTriple gradient(const PackTriple& x, const Pair& flat, const Pair& whole) const {
    const PackTriple s = signed_scale(x);
    const auto one = [&](const Pack& value, const Pack& of) { return select(size(of) > Pack(0.0), value, Pack(0.0)); };
    return {one(whole.slope_u * flat.slope_u * s.x, x.x), one(whole.slope_u * flat.slope_v * s.y, x.y), one(whole.slope_v * s.z, x.z)};
  }
  QUERN_INLINE static Pair pair(const Pack& a, const Pack& b, const Exponent& p) {
    const Pack one(1.0), large = greater(greater(a, b), Pack(1e-270)), ratio = greater(lesser(a, b) / large, Pack(1e-270));
    Pack raised = ratio * ratio;
    if (!p.round) raised = select(p.other, power(ratio, p.p), raised);
    const Pack sum = one + raised;
    Pack root = square_root(sum);
    if (!p.round) root = select(p.other, power(sum, p.inverse), root);
    const Pack inverse = one / root, inverse_ratio = one / ratio, shared = root / sum;
    const Pack of_small = ratio * inverse, slope_large = shared, slope_small = raised * inverse_ratio * shared;
    const Pack bend = (p.p - one) * lesser(Pack(most), (slope_large * root) * (slope_small * root * inverse_ratio));
    const Mask first = a > b;
    return {large * root, select(first, inverse, of_small), select(first, of_small, inverse), select(first, slope_large, slope_small), select(first, slope_small, slope_large), bend};
  }
};

}  // namespace quern::QUERN_ISA
