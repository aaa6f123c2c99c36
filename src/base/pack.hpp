// Eight doubles at once. Compiled once for each instruction set, each in a namespace of its own (QUERN_ISA), so that
// the program can choose at run time. Every operation is IEEE double arithmetic without contraction and the width is
// eight everywhere, so that all three give the same bits.
#pragma once
#include "src/base/triple.hpp"
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#ifndef QUERN_ISA
#define QUERN_ISA portable
#endif

namespace quern::QUERN_ISA {

inline constexpr int lanes = 8;

#if defined(__AVX512F__)
struct Pack {
  __m512d v;
  Pack() = default;
  QUERN_INLINE explicit Pack(double a) : v(_mm512_set1_pd(a)) {}
  QUERN_INLINE explicit Pack(__m512d a) : v(a) {}
};
struct Mask {
  __mmask8 m;
};
QUERN_INLINE Pack operator+(Pack a, Pack b) { return Pack(_mm512_add_pd(a.v, b.v)); }
QUERN_INLINE Pack operator-(Pack a, Pack b) { return Pack(_mm512_sub_pd(a.v, b.v)); }
QUERN_INLINE Pack operator*(Pack a, Pack b) { return Pack(_mm512_mul_pd(a.v, b.v)); }
QUERN_INLINE Pack operator/(Pack a, Pack b) { return Pack(_mm512_div_pd(a.v, b.v)); }
QUERN_INLINE Pack operator-(Pack a) { return Pack(_mm512_sub_pd(_mm512_set1_pd(-0.0), a.v)); }
QUERN_INLINE Mask operator<(Pack a, Pack b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ)}; }
QUERN_INLINE Mask operator>(Pack a, Pack b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_GT_OQ)}; }
QUERN_INLINE Mask operator&(Mask a, Mask b) { return {static_cast<__mmask8>(a.m & b.m)}; }
QUERN_INLINE Pack select(Mask m, Pack yes, Pack no) { return Pack(_mm512_mask_blend_pd(m.m, no.v, yes.v)); }
QUERN_INLINE Pack square_root(Pack a) { return Pack(_mm512_sqrt_pd(a.v)); }
QUERN_INLINE Pack greater(Pack a, Pack b) { return Pack(_mm512_max_pd(a.v, b.v)); }
QUERN_INLINE Pack lesser(Pack a, Pack b) { return Pack(_mm512_min_pd(a.v, b.v)); }
QUERN_INLINE Pack nearest_integer(Pack a) { return Pack(_mm512_roundscale_pd(a.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC)); }
QUERN_INLINE unsigned bits(Mask m) { return m.m; }
QUERN_INLINE Mask first_lanes(int count) { return {static_cast<__mmask8>((1u << count) - 1u)}; }
QUERN_INLINE Pack load(const double* p) { return Pack(_mm512_loadu_pd(p)); }
QUERN_INLINE void store(double* p, Pack a) { _mm512_storeu_pd(p, a.v); }
#elif defined(__AVX2__)
struct Pack {
  __m256d a, b;
  Pack() = default;
  QUERN_INLINE explicit Pack(double s) : a(_mm256_set1_pd(s)), b(a) {}
  QUERN_INLINE Pack(__m256d low, __m256d high) : a(low), b(high) {}
};
struct Mask {
  __m256d a, b;
};
QUERN_INLINE Pack operator+(Pack x, Pack y) { return {_mm256_add_pd(x.a, y.a), _mm256_add_pd(x.b, y.b)}; }
QUERN_INLINE Pack operator-(Pack x, Pack y) { return {_mm256_sub_pd(x.a, y.a), _mm256_sub_pd(x.b, y.b)}; }
QUERN_INLINE Pack operator*(Pack x, Pack y) { return {_mm256_mul_pd(x.a, y.a), _mm256_mul_pd(x.b, y.b)}; }
QUERN_INLINE Pack operator/(Pack x, Pack y) { return {_mm256_div_pd(x.a, y.a), _mm256_div_pd(x.b, y.b)}; }
QUERN_INLINE Pack operator-(Pack x) { return Pack(-0.0) - x; }
QUERN_INLINE Mask operator<(Pack x, Pack y) { return {_mm256_cmp_pd(x.a, y.a, _CMP_LT_OQ), _mm256_cmp_pd(x.b, y.b, _CMP_LT_OQ)}; }
QUERN_INLINE Mask operator>(Pack x, Pack y) { return y < x; }
QUERN_INLINE Mask operator&(Mask x, Mask y) { return {_mm256_and_pd(x.a, y.a), _mm256_and_pd(x.b, y.b)}; }
QUERN_INLINE Pack select(Mask m, Pack yes, Pack no) { return {_mm256_blendv_pd(no.a, yes.a, m.a), _mm256_blendv_pd(no.b, yes.b, m.b)}; }
QUERN_INLINE Pack square_root(Pack x) { return {_mm256_sqrt_pd(x.a), _mm256_sqrt_pd(x.b)}; }
QUERN_INLINE Pack greater(Pack x, Pack y) { return {_mm256_max_pd(x.a, y.a), _mm256_max_pd(x.b, y.b)}; }
QUERN_INLINE Pack lesser(Pack x, Pack y) { return {_mm256_min_pd(x.a, y.a), _mm256_min_pd(x.b, y.b)}; }
QUERN_INLINE Pack nearest_integer(Pack x) {
  constexpr int mode = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
  return {_mm256_round_pd(x.a, mode), _mm256_round_pd(x.b, mode)};
}
QUERN_INLINE unsigned bits(Mask m) {
  return static_cast<unsigned>(_mm256_movemask_pd(m.a)) | static_cast<unsigned>(_mm256_movemask_pd(m.b)) << 4;
}
QUERN_INLINE Mask first_lanes(int count) {
  const __m256d n = _mm256_set1_pd(count);
  return {_mm256_cmp_pd(_mm256_set_pd(3, 2, 1, 0), n, _CMP_LT_OQ), _mm256_cmp_pd(_mm256_set_pd(7, 6, 5, 4), n, _CMP_LT_OQ)};
}
QUERN_INLINE Pack load(const double* p) { return {_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)}; }
QUERN_INLINE void store(double* p, Pack x) { _mm256_storeu_pd(p, x.a), _mm256_storeu_pd(p + 4, x.b); }
#else
struct Pack {
  double v[lanes];
  Pack() = default;
  QUERN_INLINE explicit Pack(double s) { for (double& lane : v) lane = s; }
};
struct Mask {
  bool m[lanes];
};
#define QUERN_LANES(type, expression) \
  type r; \
  for (int k = 0; k < lanes; ++k) expression; \
  return r
QUERN_INLINE Pack operator+(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] + b.v[k]); }
QUERN_INLINE Pack operator-(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] - b.v[k]); }
QUERN_INLINE Pack operator*(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] * b.v[k]); }
QUERN_INLINE Pack operator/(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] / b.v[k]); }
QUERN_INLINE Pack operator-(const Pack& a) { QUERN_LANES(Pack, r.v[k] = -0.0 - a.v[k]); }
QUERN_INLINE Mask operator<(const Pack& a, const Pack& b) { QUERN_LANES(Mask, r.m[k] = a.v[k] < b.v[k]); }
QUERN_INLINE Mask operator>(const Pack& a, const Pack& b) { QUERN_LANES(Mask, r.m[k] = a.v[k] > b.v[k]); }
QUERN_INLINE Mask operator&(const Mask& a, const Mask& b) { QUERN_LANES(Mask, r.m[k] = a.m[k] && b.m[k]); }
QUERN_INLINE Pack select(const Mask& m, const Pack& yes, const Pack& no) { QUERN_LANES(Pack, r.v[k] = m.m[k] ? yes.v[k] : no.v[k]); }
QUERN_INLINE Pack square_root(const Pack& a) { QUERN_LANES(Pack, r.v[k] = std::sqrt(a.v[k])); }
QUERN_INLINE Pack greater(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] > b.v[k] ? a.v[k] : b.v[k]); }
QUERN_INLINE Pack lesser(const Pack& a, const Pack& b) { QUERN_LANES(Pack, r.v[k] = a.v[k] < b.v[k] ? a.v[k] : b.v[k]); }
QUERN_INLINE Pack nearest_integer(const Pack& a) { QUERN_LANES(Pack, r.v[k] = std::nearbyint(a.v[k])); }
QUERN_INLINE unsigned bits(const Mask& m) {
  unsigned r = 0;
  for (int k = 0; k < lanes; ++k) r |= static_cast<unsigned>(m.m[k]) << k;
  return r;
}
QUERN_INLINE Mask first_lanes(int count) { QUERN_LANES(Mask, r.m[k] = k < count); }
QUERN_INLINE Pack load(const double* p) { QUERN_LANES(Pack, r.v[k] = p[k]); }
QUERN_INLINE void store(double* p, const Pack& a) { for (int k = 0; k < lanes; ++k) p[k] = a.v[k]; }
#undef QUERN_LANES
#endif

QUERN_INLINE Pack& operator+=(Pack& a, const Pack& b) { return a = a + b; }
QUERN_INLINE Pack& operator-=(Pack& a, const Pack& b) { return a = a - b; }

inline Pack power(const Pack& a, double exponent) {
  alignas(64) double lane[lanes];
  store(lane, a);
  for (double& value : lane) value = std::pow(value, exponent);
  return load(lane);
}

// The sum of the eight lanes, in a fixed order.
QUERN_INLINE double sum(const Pack& a) {
  alignas(64) double l[lanes];
  store(l, a);
  return ((l[0] + l[1]) + (l[2] + l[3])) + ((l[4] + l[5]) + (l[6] + l[7]));
}

struct QuadPack {
  Pack x, y, z, w;
  QUERN_INLINE Triple<Pack> xyz() const { return {x, y, z}; }
};

// Rows base[index[0..7]] turned into columns, and back.
#if defined(__AVX2__)
struct Columns4 {
  __m256d x, y, z, w;
};
QUERN_INLINE Columns4 transpose(__m256d a, __m256d b, __m256d c, __m256d d) {
  const __m256d ab_low = _mm256_unpacklo_pd(a, b), ab_high = _mm256_unpackhi_pd(a, b);
  const __m256d cd_low = _mm256_unpacklo_pd(c, d), cd_high = _mm256_unpackhi_pd(c, d);
  return {_mm256_permute2f128_pd(ab_low, cd_low, 0x20), _mm256_permute2f128_pd(ab_high, cd_high, 0x20),
          _mm256_permute2f128_pd(ab_low, cd_low, 0x31), _mm256_permute2f128_pd(ab_high, cd_high, 0x31)};
}
QUERN_INLINE Pack join(__m256d low, __m256d high) {
#if defined(__AVX512F__)
  return Pack(_mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1));
#else
  return {low, high};
#endif
}
QUERN_INLINE __m256d low_half(const Pack& p) {
#if defined(__AVX512F__)
  return _mm512_castpd512_pd256(p.v);
#else
  return p.a;
#endif
}
QUERN_INLINE __m256d high_half(const Pack& p) {
#if defined(__AVX512F__)
  return _mm512_extractf64x4_pd(p.v, 1);
#else
  return p.b;
#endif
}
template <class Row>
QUERN_INLINE QuadPack gather_rows(Row&& row) {
  const auto at = [&](int k) { return _mm256_load_pd(row(k)); };
  const Columns4 low = transpose(at(0), at(1), at(2), at(3));
  const Columns4 high = transpose(at(4), at(5), at(6), at(7));
  return {join(low.x, high.x), join(low.y, high.y), join(low.z, high.z), join(low.w, high.w)};
}
QUERN_INLINE void columns_to_rows(const QuadPack& q, Quad* out) {
  const Columns4 low = transpose(low_half(q.x), low_half(q.y), low_half(q.z), low_half(q.w));
  const Columns4 high = transpose(high_half(q.x), high_half(q.y), high_half(q.z), high_half(q.w));
  const __m256d rows[8] = {low.x, low.y, low.z, low.w, high.x, high.y, high.z, high.w};
  for (int k = 0; k < 8; ++k) _mm256_store_pd(&out[k].x, rows[k]);
}
QUERN_INLINE void add_row(Quad& to, const Quad& row) {
  _mm256_store_pd(&to.x, _mm256_add_pd(_mm256_load_pd(&to.x), _mm256_load_pd(&row.x)));
}
#else
template <class Row>
QUERN_INLINE QuadPack gather_rows(Row&& row) {
  QuadPack q;
  for (int k = 0; k < lanes; ++k) {
    const double* r = row(k);
    q.x.v[k] = r[0], q.y.v[k] = r[1], q.z.v[k] = r[2], q.w.v[k] = r[3];
  }
  return q;
}
QUERN_INLINE void columns_to_rows(const QuadPack& q, Quad* out) {
  for (int k = 0; k < lanes; ++k) out[k].x = q.x.v[k], out[k].y = q.y.v[k], out[k].z = q.z.v[k], out[k].w = q.w.v[k];
}
QUERN_INLINE void add_row(Quad& to, const Quad& row) { to.x += row.x, to.y += row.y, to.z += row.z, to.w += row.w; }
#endif

QUERN_INLINE QuadPack gather(const Quad* base, const Index* index) {
  return gather_rows([&](int k) { return &base[index[k]].x; });
}

}  // namespace quern::QUERN_ISA
