// Triple<T>: a vector of three in which T is a double or a SIMD pack of doubles, so that one formula serves both.
// Quad: three components and a companion value in one 32-byte row, the form in which particle arrays are stored.
#pragma once
#include <cmath>
#include <cstdint>

#define QUERN_INLINE [[gnu::always_inline]] inline

namespace quern {

using Index = std::int32_t;

template <class T>
struct Triple {
  T x, y, z;
};

template <class T>
QUERN_INLINE Triple<T> operator+(const Triple<T>& a, const Triple<T>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class T>
QUERN_INLINE Triple<T> operator-(const Triple<T>& a, const Triple<T>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class T>
QUERN_INLINE Triple<T> operator*(const T& s, const Triple<T>& a) { return {s * a.x, s * a.y, s * a.z}; }
template <class T>
QUERN_INLINE T dot(const Triple<T>& a, const Triple<T>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class T>
QUERN_INLINE Triple<T> cross(const Triple<T>& a, const Triple<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// One row of a particle array: x, y, z and a companion w (radius, mass, … as the array says).
struct alignas(32) Quad {
  double x = 0, y = 0, z = 0, w = 0;
};

QUERN_INLINE Triple<double> xyz(const Quad& q) { return {q.x, q.y, q.z}; }

// The scalar side of the functions that contact laws call on doubles and packs alike.
QUERN_INLINE double select(bool condition, double yes, double no) { return condition ? yes : no; }
QUERN_INLINE double square_root(double a) { return std::sqrt(a); }
QUERN_INLINE double power(double a, double exponent) { return std::pow(a, exponent); }
QUERN_INLINE double greater(double a, double b) { return a > b ? a : b; }
QUERN_INLINE double lesser(double a, double b) { return a < b ? a : b; }
QUERN_INLINE double nearest_integer(double a) { return std::nearbyint(a); }
// What packs do lane by lane, for functions that only the library of C has.
template <class Function>
QUERN_INLINE double each(double a, Function&& f) { return f(a); }
QUERN_INLINE bool any(bool condition) { return condition; }

template <class T>
QUERN_INLINE T length(const Triple<T>& a) { return square_root(dot(a, a)); }

}  // namespace quern
