// A ball that is dropped from rest and bounces: parabolas, each rebound `restitution` times as fast as what came before.
#pragma once
#include <cmath>

namespace quern {

// Height of its lowest place above the plate [m] at t [s], for contacts that take no time.
inline double bounce_height(double drop, double restitution, double t) {
  constexpr double g = 9.81;
  double touch = std::sqrt(2 * drop / g), speed = g * touch, z = drop - 0.5 * g * t * t;
  while (t > touch) {
    speed *= restitution;
    z = speed * (t - touch) - 0.5 * g * (t - touch) * (t - touch);
    touch += 2 * speed / g;
  }
  return z;
}

}  // namespace quern
