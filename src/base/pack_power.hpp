// Powers of eight doubles at once, the same bits for every instruction set.
#pragma once
#include <bit>
#include <cstdint>
#include "src/base/pack.hpp"

namespace quern::QUERN_ISA {

// a = mantissa · 2^exponent with 1 ≤ mantissa < 2; a > 0, no denormal.
struct Split {
  Pack mantissa, exponent;
};

#if defined(__AVX512F__)
QUERN_INLINE Split split(Pack a) { return {Pack(_mm512_getmant_pd(a.v, _MM_MANT_NORM_1_2, _MM_MANT_SIGN_src)), Pack(_mm512_getexp_pd(a.v))}; }
// a · 2^exponent, exponent whole, within ±1000.
QUERN_INLINE Pack scaled(Pack a, Pack exponent) { return Pack(_mm512_scalef_pd(a.v, exponent.v)); }
#elif defined(__AVX2__)
QUERN_INLINE Split split(Pack a) {
  const __m256i fraction = _mm256_set1_epi64x(0x000fffffffffffff), one = _mm256_set1_epi64x(0x3ff0000000000000), magic = _mm256_set1_epi64x(0x4330000000000000);
  const auto mantissa = [&](__m256d v) { return _mm256_castsi256_pd(_mm256_or_si256(_mm256_and_si256(_mm256_castpd_si256(v), fraction), one)); };
  const auto exponent = [&](__m256d v) {
    return _mm256_sub_pd(_mm256_castsi256_pd(_mm256_or_si256(_mm256_srli_epi64(_mm256_castpd_si256(v), 52), magic)), _mm256_set1_pd(0x1p52 + 1023));
  };
  return {{mantissa(a.a), mantissa(a.b)}, {exponent(a.a), exponent(a.b)}};
}
QUERN_INLINE Pack scaled(Pack a, Pack exponent) {
  const auto factor = [](__m256d e) { return _mm256_castsi256_pd(_mm256_slli_epi64(_mm256_castpd_si256(_mm256_add_pd(e, _mm256_set1_pd(0x1p52 + 1023))), 52)); };
  return {_mm256_mul_pd(a.a, factor(exponent.a)), _mm256_mul_pd(a.b, factor(exponent.b))};
}
#else
QUERN_INLINE Split split(const Pack& a) {
  Split s;
  for (int k = 0; k < lanes; ++k) {
    const auto bit = std::bit_cast<std::uint64_t>(a.v[k]);
    s.mantissa.v[k] = std::bit_cast<double>((bit & 0x000fffffffffffffu) | 0x3ff0000000000000u);
    s.exponent.v[k] = static_cast<double>(static_cast<std::int64_t>(bit >> 52) - 1023);
  }
  return s;
}
QUERN_INLINE Pack scaled(const Pack& a, const Pack& exponent) {
  Pack r;
  for (int k = 0; k < lanes; ++k) r.v[k] = a.v[k] * std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::int64_t>(exponent.v[k]) + 1023) << 52);
  return r;
}
#endif

// a^exponent for 1e-300 < a ≤ 1e300; off by less than 4e-16 times (2 + |log₂| of the result). Results below 2^-1000 are taken as that.
QUERN_INLINE Pack power(const Pack& a, const Pack& exponent) {
  const Pack one(1.0), half(0.5);
  Split s = split(a);
  const Mask high = s.mantissa > Pack(1.4142135623730951);
  const Pack m = select(high, half * s.mantissa, s.mantissa), e = select(high, s.exponent + one, s.exponent);
  // log₂ m by the series of artanh, t = (m − 1)/(m + 1) within ±0.172.
  const Pack t = (m - one) / (m + one), z = t * t, z2 = z * z, z4 = z2 * z2;
  const auto term = [](int k) { return Pack(2.8853900817779268 / (2 * k + 1)); };
  const Pack low = (term(0) + term(1) * z) + (term(2) + term(3) * z) * z2, mid = (term(4) + term(5) * z) + (term(6) + term(7) * z) * z2;
  const Pack log_m = t * (low + z4 * (mid + z4 * (term(8) + term(9) * z + term(10) * z2)));
  // 2^y by the series of exp, the whole part apart.
  const Pack whole = exponent * e, rest = exponent * log_m, y = greater(whole + rest, Pack(-1000.0));
  const Pack k = nearest_integer(y), x = select(y > Pack(-1000.0), ((whole - k) + rest) * Pack(0.6931471805599453), Pack(0.0));
  const Pack x2 = x * x, x4 = x2 * x2;
  const Pack first = (one + x) + (half + Pack(1.0 / 6) * x) * x2, second = (Pack(1.0 / 24) + Pack(1.0 / 120) * x) + (Pack(1.0 / 720) + Pack(1.0 / 5040) * x) * x2;
  const Pack third = (Pack(1.0 / 40320) + Pack(1.0 / 362880) * x) + (Pack(1.0 / 3628800) + Pack(1.0 / 39916800) * x) * x2;
  return scaled(first + x4 * (second + x4 * (third + x4 * (Pack(1.0 / 479001600) + Pack(1.0 / 6227020800.0) * x))), k);
}

}  // namespace quern::QUERN_ISA
