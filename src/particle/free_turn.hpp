// The free turn of a body, for one or eight (T: double or a pack).
#pragma once
#include <cmath>
#include "src/base/triple.hpp"

namespace quern {

template <class T>
struct UnitQuaternion {
  Triple<T> vector;
  T scalar;
};

// v told in the axes that q turns into the fixed ones; and back.
template <class T>
QUERN_INLINE Triple<T> rotated(const Triple<T>& u, const T& w, const Triple<T>& v) {
  const Triple<T> twice = T(2.0) * cross(u, v);
  return v + w * twice + cross(u, twice);
}
template <class T>
QUERN_INLINE Triple<T> into_own(const UnitQuaternion<T>& q, const Triple<T>& v) { return rotated(T(-1.0) * q.vector, q.scalar, v); }
template <class T>
QUERN_INLINE Triple<T> into_fixed(const UnitQuaternion<T>& q, const Triple<T>& v) { return rotated(q.vector, q.scalar, v); }

template <class T>
struct SineCosine {
  T sine, cosine;
};

// By their series where an angle is as small as a step's.
template <class T>
QUERN_INLINE SineCosine<T> sine_and_cosine(const T& angle) {
  const T s = angle * angle, s2 = s * s, one(1.0);
  const T odd = (one + s * T(-1.0 / 6)) + s2 * ((T(1.0 / 120) + s * T(-1.0 / 5040)) + s2 * (T(1.0 / 362880) - s * T(1.0 / 39916800)));
  const T even = (one + s * T(-1.0 / 2)) + s2 * ((T(1.0 / 24) + s * T(-1.0 / 720)) + s2 * (T(1.0 / 40320) - s * T(1.0 / 3628800)));
  const T sine = angle * odd, limit(0.01);
  if (!any(s > limit)) return {sine, even};
  return {select(s > limit, each(angle, [](double a) { return std::sin(a); }), sine), select(s > limit, each(angle, [](double a) { return std::cos(a); }), even)};
}

// See turned_freely. `own`: the angular momentum in the body's own axes, `rates`: the time over the moments.
template <class T>
QUERN_INLINE UnitQuaternion<T> turned(UnitQuaternion<T> q, Triple<T> own, const Triple<T>& rates) {
  // Turns about one axis; u and v follow it in the order of the axes.
  const auto turn = [](const T& angle, T& own_u, T& own_v, T& w, T& along, T& x, T& y) __attribute__((always_inline)) {
    const auto [half_sine, half_cosine] = sine_and_cosine(T(0.5) * angle);
    const T cosine = T(1.0) - T(2.0) * half_sine * half_sine, sine = T(2.0) * half_sine * half_cosine;
    // The body turns forwards, so that the momentum, which stays, turns backwards in its axes.
    const T momentum_u = own_u, momentum_v = own_v;
    own_u = cosine * momentum_u + sine * momentum_v;
    own_v = cosine * momentum_v - sine * momentum_u;
    // q times the turn about that axis.
    const T old_w = w, old_along = along, old_x = x, old_y = y;
    w = half_cosine * old_w - half_sine * old_along;
    along = half_cosine * old_along + half_sine * old_w;
    x = half_cosine * old_x + half_sine * old_y;
    y = half_cosine * old_y - half_sine * old_x;
  };
  Triple<T>& u = q.vector;
  const T half(0.5);
  turn(half * rates.z * own.z, own.x, own.y, q.scalar, u.z, u.x, u.y);
  turn(half * rates.y * own.y, own.z, own.x, q.scalar, u.y, u.z, u.x);
  turn(rates.x * own.x, own.y, own.z, q.scalar, u.x, u.y, u.z);
  turn(half * rates.y * own.y, own.z, own.x, q.scalar, u.y, u.z, u.x);
  turn(half * rates.z * own.z, own.x, own.y, q.scalar, u.z, u.x, u.y);
  const T inverse = T(1.0) / square_root(dot(u, u) + q.scalar * q.scalar);
  return {inverse * u, inverse * q.scalar};
}

}  // namespace quern
