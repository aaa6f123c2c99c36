// A force along the normal that a table gives: piecewise linear in the overlap [m], the approach speed [m/s] or the time since first
// touch [s], and constant beyond its ends; while the overlap grows, while it shrinks, or always.
#pragma once
#include "src/contact/approach.hpp"

namespace quern {

struct ForceTable {
  enum class Variable { overlap, normal_velocity, time };
  enum class Phase { both, loading, unloading };
  static constexpr int most_points = 32;
  int points = 0;  // 0: off
  Variable variable = Variable::overlap;
  Phase phase = Phase::both;
  double at[most_points] = {};      // ascending
  double force[most_points] = {};   // [N]

  bool on() const { return points > 0; }
  // A table over the overlap alone gives back what it took.
  bool stores() const { return variable == Variable::overlap && phase == Phase::both; }

  template <class T>
  QUERN_INLINE T value(const T& x) const {
    T sum(force[0]);
    for (int k = 0; k + 1 < points; ++k) {
      const double width = at[k + 1] - at[k];
      sum += T((force[k + 1] - force[k]) / width) * lesser(T(width), greater(T(0.0), x - T(at[k])));
    }
    return sum;
  }
  // ∫ from 0 to an overlap.
  template <class T>
  QUERN_INLINE T integral(const T& overlap) const {
    T sum = T(force[0]) * overlap;
    for (int k = 0; k + 1 < points; ++k) {
      const double width = at[k + 1] - at[k], slope = (force[k + 1] - force[k]) / width;
      const T into = greater(T(0.0), overlap - T(at[k])), within = lesser(T(width), into);
      sum += T(slope) * within * (into - T(0.5) * within);
    }
    return sum;
  }
  template <class T>
  QUERN_INLINE T operator()(const T& overlap, const T& closing, const T& age) const {
    const T whole = value(variable == Variable::overlap ? overlap : variable == Variable::normal_velocity ? closing : age);
    if (phase == Phase::both) return whole;
    const T zero(0.0);
    return phase == Phase::loading ? select(closing > zero, whole, zero) : select(closing > zero, zero, whole);
  }
};

}  // namespace quern
