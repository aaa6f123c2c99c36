// A norm of norms, of which both sides of a superquadric are made: ((|s_x x|^p + |s_y y|^p)^{P/p} + |s_z z|^P)^{1/P}.
#pragma once
#include <algorithm>
#include <cmath>
#include "src/base/vec.hpp"

namespace quern {

// With 1/semi-axes and the exponents n it is the gauge of the body: 1 on the surface, t at t times that place. With the semi-axes and
// the conjugate exponents n/(n−1) it is its support function: how far the body reaches along a direction. Each one's gradient takes
// a place on the surface to its normal, or a normal to its place.
//
// Powers are taken of ratios in [0, 1] alone, so that nothing overflows, however large the exponent or far the place.
struct NestedNorm {
  Vec3 scale;
  double outer, inner;  // P, p > 1

  bool round() const { return outer == 2 && inner == 2; }

  // The value at x ≠ 0.
  double value(const Vec3& x) const {
    const Vec3 u = scale.cwiseProduct(x);
    if (round()) return u.norm();
    return pair(pair(std::abs(u.x()), std::abs(u.y()), inner).size, std::abs(u.z()), outer).size;
  }

  struct First {
    double value;
    Vec3 gradient;
  };
  First first(const Vec3& x) const {
    const Vec3 u = scale.cwiseProduct(x);
    if (round()) {
      const double size = u.norm();
      return {size, scale.cwiseProduct(u) / size};
    }
    const Pair ring = pair(std::abs(u.x()), std::abs(u.y()), inner), whole = pair(ring.size, std::abs(u.z()), outer);
    return {whole.size, gradient(x, ring, whole)};
  }

  struct Second {
    double value;
    Vec3 gradient;
    Mat3 hessian;  // homogeneous of degree −1; finite everywhere, very large where the norm has a kink
  };
  Second second(const Vec3& x) const {
    const Vec3 u = scale.cwiseProduct(x);
    if (round()) {
      const double size = u.norm();
      const Vec3 slope = scale.cwiseProduct(u) / size;
      Mat3 hessian = -slope * slope.transpose();
      hessian.diagonal() += scale.cwiseProduct(scale);
      return {size, slope, hessian / size};
    }
    const Pair ring = pair(std::abs(u.x()), std::abs(u.y()), inner), whole = pair(ring.size, std::abs(u.z()), outer);
    const Vec3 s{std::copysign(scale.x(), x.x()), std::copysign(scale.y(), x.y()), std::copysign(scale.z(), x.z())};
    // Of each norm of two, q (v, −u)(v, −u)ᵀ: the other eigenvalue is zero.
    const Vec3 across{whole.v * ring.slope_u() * s.x(), whole.v * ring.slope_v() * s.y(), -whole.u * s.z()};
    const Vec3 across_ring{ring.v * s.x(), -ring.u * s.y(), 0};
    const double bend = whole.bend(outer) / whole.size;
    const double bend_ring = std::min(most, whole.slope_u() * ring.bend(inner) * whole.size / std::max(ring.size, least * whole.size)) / whole.size;
    return {whole.size, gradient(x, ring, whole), bend * across * across.transpose() + bend_ring * across_ring * across_ring.transpose()};
  }

 private:
  static constexpr double least = 1e-290;  // ratios below are taken as this, that fractions stay finite
  static constexpr double most = 1e9;      // second derivatives at a kink are taken as this, times the scales, that others stand beside them

  // The norm of two, (a^p + b^p)^{1/p}, with u = a/size, v = b/size and their powers.
  struct Pair {
    double size, u, v, u_power, v_power;
    double slope_u() const { return u_power / u; }  // u^{p−1}, the derivative of the size
    double slope_v() const { return v_power / v; }
    // The factor of (v, −u)(v, −u)ᵀ / size in the Hessian: (p−1) u^{p−2} v^{p−2}.
    double bend(double p) const { return (p - 1) * std::min(most, (slope_u() / u) * (slope_v() / v)); }
  };
  static Pair pair(double a, double b, double p) {
    const bool a_larger = a > b;
    const double large = a_larger ? a : b, small = a_larger ? b : a;
    const double ratio = large > 0 ? std::max(small / large, least) : 1;
    const double power = p == 2 ? ratio * ratio : std::pow(ratio, p), sum = 1 + power;
    const double root = p == 2 ? std::sqrt(sum) : std::pow(sum, 1 / p);
    const double of_large = 1 / root, of_small = ratio / root, large_power = 1 / sum, small_power = power / sum;
    return a_larger ? Pair{large * root, of_large, of_small, large_power, small_power} : Pair{large * root, of_small, of_large, small_power, large_power};
  }
  Vec3 gradient(const Vec3& x, const Pair& ring, const Pair& whole) const {
    const double along = whole.slope_u();
    const auto one = [](double size, double of) { return of == 0 ? 0 : std::copysign(size, of); };
    return {one(scale.x() * along * ring.slope_u(), x.x()), one(scale.y() * along * ring.slope_v(), x.y()), one(scale.z() * whole.slope_v(), x.z())};
  }
};

}  // namespace quern
