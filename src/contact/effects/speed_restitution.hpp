// Restitution that falls with speed: 1 − e(v) = (1 − e₁)(v/v₁)^q, v the approach speed at first touch (q = 0.2: viscoelastic spheres,
// Schwager & Pöschel 1998). The law's dashpot is scaled at first touch to the damping ratio that measures e(v), and keeps that scale.
#pragma once

namespace quern {

struct SpeedRestitution {
  enum class Mapping { linear, hertz };
  double exponent = 0;         // q [-]; 0: off
  double restitution = 1;      // e₁ [-], below 1
  double reference_speed = 1;  // v₁ [m/s]
  Mapping mapping = Mapping::linear;  // of restitution to damping ratio: the law's

  static constexpr double least = 0.01;  // e(v) falls no further [-]
  double at(double speed) const;         // e(v)
  double damping_scale(double speed) const;  // of the law's dashpot; above 0
};

}  // namespace quern
