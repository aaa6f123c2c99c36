// Eight doubles at once. Compiled once for each instruction set, each in a namespace of its own (QUERN_ISA), so that
// the program can choose at run time. Every operation is IEEE double arithmetic without contraction and the width is
// eight everywhere, so that all three give the same bits.
#pragma once
#include <cstddef>
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

template <class Function>
inline Pack each(const Pack& a, Function&& f) {
  alignas(64) double lane[lanes];
  store(lane, a);
  for (double& value : lane) value = f(value);
  return load(lane);
}

QUERN_INLINE bool any(const Mask& m) { return bits(m) != 0; }

// The sum of the eight lanes, in a fixed order.
QUERN_INLINE double sum(const Pack& a) {
  alignas(64) double l[lanes];
  store(l, a);
  return ((l[0] + l[1]) + (l[2] + l[3])) + ((l[4] + l[5]) + (l[6] + l[7]));
}

// Adds the first `count` lanes.
QUERN_INLINE void add_first(Pack& to, const Pack& what, int count) { to += select(first_lanes(count), what, Pack(0.0)); }

// Four columns, one lane for each row.
struct QuadPack {
  Pack x, y, z, w;
  QUERN_INLINE Triple<Pack> xyz() const { return {x, y, z}; }
};

// Eight rows of four, wherever row(0..7) says, turned into columns; columns written to such rows; and two sets of columns added to
// rows of eight, one lane after the other, so that a row may occur more than once.
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
#if defined(__AVX512F__)
// Two rows to a register, k and k + 4, so that columns come out in the order of the lanes.
template <class Row>
QUERN_INLINE QuadPack gather_rows(Row&& row) {
  const auto two = [&](int k) __attribute__((always_inline)) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(row(k))), _mm256_load_pd(row(k + 4)), 1);
  };
  const __m512d a = two(0), b = two(1), c = two(2), d = two(3);
  const __m512d ab_low = _mm512_unpacklo_pd(a, b), ab_high = _mm512_unpackhi_pd(a, b);
  const __m512d cd_low = _mm512_unpacklo_pd(c, d), cd_high = _mm512_unpackhi_pd(c, d);
  const __m512i evens = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13), odds = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  return {Pack(_mm512_permutex2var_pd(ab_low, evens, cd_low)), Pack(_mm512_permutex2var_pd(ab_high, evens, cd_high)),
          Pack(_mm512_permutex2var_pd(ab_low, odds, cd_low)), Pack(_mm512_permutex2var_pd(ab_high, odds, cd_high))};
}
#else
template <class Row>
QUERN_INLINE QuadPack gather_rows(Row&& row) {
  const auto at = [&](int k) { return _mm256_load_pd(row(k)); };
  const Columns4 low = transpose(at(0), at(1), at(2), at(3));
  const Columns4 high = transpose(at(4), at(5), at(6), at(7));
  return {join(low.x, high.x), join(low.y, high.y), join(low.z, high.z), join(low.w, high.w)};
}
#endif
#if defined(__AVX512F__)
struct Rows {
  __m512d two[4];  // rows k and k + 4
};
QUERN_INLINE Rows rows_of(const QuadPack& q) {
  const __m512d xy_low = _mm512_unpacklo_pd(q.x.v, q.y.v), xy_high = _mm512_unpackhi_pd(q.x.v, q.y.v);
  const __m512d zw_low = _mm512_unpacklo_pd(q.z.v, q.w.v), zw_high = _mm512_unpackhi_pd(q.z.v, q.w.v);
  const __m512i evens = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13), odds = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  return {{_mm512_permutex2var_pd(xy_low, evens, zw_low), _mm512_permutex2var_pd(xy_high, evens, zw_high),
           _mm512_permutex2var_pd(xy_low, odds, zw_low), _mm512_permutex2var_pd(xy_high, odds, zw_high)}};
}
template <class Row>
QUERN_INLINE void scatter_rows(const QuadPack& q, Row&& row) {
  const Rows r = rows_of(q);
  for (int k = 0; k < 4; ++k) _mm256_store_pd(row(k), _mm512_castpd512_pd256(r.two[k]));
  for (int k = 0; k < 4; ++k) _mm256_store_pd(row(k + 4), _mm512_extractf64x4_pd(r.two[k], 1));
}
template <class Row>
QUERN_INLINE void add_double_rows(const QuadPack& first, const QuadPack& second, Row&& row) {
  const Rows a = rows_of(first), b = rows_of(second);
  const auto add = [](double* to, __m512d what) { _mm512_store_pd(to, _mm512_add_pd(_mm512_load_pd(to), what)); };
  for (int k = 0; k < 4; ++k) add(row(k), _mm512_shuffle_f64x2(a.two[k], b.two[k], 0x44));
  for (int k = 0; k < 4; ++k) add(row(k + 4), _mm512_shuffle_f64x2(a.two[k], b.two[k], 0xee));
}
#else
template <class Store>
QUERN_INLINE void for_rows(const QuadPack& q, Store&& store_row) {
  const Columns4 low = transpose(low_half(q.x), low_half(q.y), low_half(q.z), low_half(q.w));
  const Columns4 high = transpose(high_half(q.x), high_half(q.y), high_half(q.z), high_half(q.w));
  store_row(0, low.x), store_row(1, low.y), store_row(2, low.z), store_row(3, low.w);
  store_row(4, high.x), store_row(5, high.y), store_row(6, high.z), store_row(7, high.w);
}
template <class Row>
QUERN_INLINE void scatter_rows(const QuadPack& q, Row&& row) {
  for_rows(q, [&](int k, __m256d r) { _mm256_store_pd(row(k), r); });
}
template <class Row>
QUERN_INLINE void add_double_rows(const QuadPack& first, const QuadPack& second, Row&& row) {
  const auto add = [](double* to, __m256d what) { _mm256_store_pd(to, _mm256_add_pd(_mm256_load_pd(to), what)); };
  for_rows(first, [&](int k, __m256d r) { add(row(k), r); });
  for_rows(second, [&](int k, __m256d r) { add(row(k) + 4, r); });
}
#endif
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
template <class Row>
QUERN_INLINE void scatter_rows(const QuadPack& q, Row&& row) {
  for (int k = 0; k < lanes; ++k) {
    double* r = row(k);
    r[0] = q.x.v[k], r[1] = q.y.v[k], r[2] = q.z.v[k], r[3] = q.w.v[k];
  }
}
template <class Row>
QUERN_INLINE void add_double_rows(const QuadPack& first, const QuadPack& second, Row&& row) {
  for (int k = 0; k < lanes; ++k) {
    double* r = row(k);
    r[0] += first.x.v[k], r[1] += first.y.v[k], r[2] += first.z.v[k], r[3] += first.w.v[k];
    r[4] += second.x.v[k], r[5] += second.y.v[k], r[6] += second.z.v[k], r[7] += second.w.v[k];
  }
}
#endif

// Two rows of four in one register: half of it, put together, and what happens within each row.
#if defined(__AVX2__)
QUERN_INLINE Pack load_two_fours(const double* low, const double* high) { return join(_mm256_loadu_pd(low), _mm256_loadu_pd(high)); }
QUERN_INLINE Pack load_four(const double* p) { return join(_mm256_loadu_pd(p), _mm256_setzero_pd()); }
QUERN_INLINE void store_four(double* p, const Pack& a) { _mm256_storeu_pd(p, low_half(a)); }
QUERN_INLINE __m256d companion_of_four(__m256d a) { return _mm256_permute4x64_pd(a, 0xff); }
QUERN_INLINE Pack companion(const Pack& a) { return join(companion_of_four(low_half(a)), companion_of_four(high_half(a))); }
QUERN_INLINE Pack keep_companion(const Pack& a, const Pack& old) {
  return join(_mm256_blend_pd(low_half(a), low_half(old), 8), _mm256_blend_pd(high_half(a), high_half(old), 8));
}
QUERN_INLINE __m256d sum_in_four(__m256d a) {
  const __m256d pairs = _mm256_add_pd(a, _mm256_permute_pd(a, 5));
  return _mm256_add_pd(pairs, _mm256_permute2f128_pd(pairs, pairs, 1));
}
QUERN_INLINE Pack sum_of_four(const Pack& a) { return join(sum_in_four(low_half(a)), sum_in_four(high_half(a))); }
#else
QUERN_INLINE Pack load_two_fours(const double* low, const double* high) {
  Pack r;
  for (int k = 0; k < 4; ++k) r.v[k] = low[k], r.v[k + 4] = high[k];
  return r;
}
QUERN_INLINE Pack load_four(const double* p) {
  Pack r(0.0);
  for (int k = 0; k < 4; ++k) r.v[k] = p[k];
  return r;
}
QUERN_INLINE void store_four(double* p, const Pack& a) {
  for (int k = 0; k < 4; ++k) p[k] = a.v[k];
}
QUERN_INLINE Pack companion(const Pack& a) {
  Pack r;
  for (int k = 0; k < lanes; ++k) r.v[k] = a.v[k | 3];
  return r;
}
QUERN_INLINE Pack keep_companion(const Pack& a, const Pack& old) {
  Pack r = a;
  r.v[3] = old.v[3], r.v[7] = old.v[7];
  return r;
}
QUERN_INLINE Pack sum_of_four(const Pack& a) {
  Pack r;
  for (int k = 0; k < lanes; ++k) r.v[k] = (a.v[k & 4] + a.v[(k & 4) + 1]) + (a.v[(k & 4) + 2] + a.v[(k & 4) + 3]);
  return r;
}
#endif

// The rows that begin at base + width × index[0..7].
QUERN_INLINE QuadPack gather(const double* base, const Index* index, std::ptrdiff_t width = 1) {
  return gather_rows([&](int k) { return base + width * index[k]; });
}

// Whole numbers as indices.
QUERN_INLINE void store_integers(Index* to, const Pack& a) {
#if defined(__AVX512F__)
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_cvtpd_epi32(a.v));
#else
  alignas(64) double lane[lanes];
  store(lane, a);
  for (int k = 0; k < lanes; ++k) to[k] = static_cast<Index>(lane[k]);
#endif
}

// Copies those of eight indices whose bit is set to `to`, close together; may write all eight places.
QUERN_INLINE void pick(const Index* from, unsigned mask, Index* to) {
#if defined(__AVX512F__)
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_maskz_compress_epi32(static_cast<__mmask8>(mask), all));
#else
  for (int k = 0; k < lanes; ++k) {
    *to = from[k];
    to += mask >> k & 1u;
  }
#endif
}
QUERN_INLINE void pick(const double* from, unsigned mask, double* to) {
#if defined(__AVX512F__)
  store(to, Pack(_mm512_maskz_compress_pd(static_cast<__mmask8>(mask), load(from).v)));
#else
  for (int k = 0; k < lanes; ++k) {
    *to = from[k];
    to += mask >> k & 1u;
  }
#endif
}

}  // namespace quern::QUERN_ISA
