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

 private:
  // The slopes: derivatives of the size.
  struct Pair {
    Pack size, slope_u, slope_v;
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
    const Pack slope_large = root / sum, slope_small = raised * (one / ratio) * slope_large;
    const Mask first = a > b;
    return {large * root, select(first, slope_large, slope_small), select(first, slope_small, slope_large)};
  }
};

}  // namespace quern::QUERN_ISA
