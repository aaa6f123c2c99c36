// What a fluid at rest does to a sphere that moves through it. Added mass, which is no force but inertia, is Simulation::carried_density.
//
// Each `rate` tells how fast the force can change the motion of a sphere of that radius and inertia, up to that speed and spin [1/s];
// the time step must be short against its inverse.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/field/load.hpp"

namespace quern {

// F = −½ C ρ A |v| v, with A = π R².
struct AirDrag {
  static constexpr const char* name = "air_drag";
  double coefficient = 0;  // C [-]
  double density = 0;      // ρ [kg/m³]

  const AirDrag& at(double, double) const { return *this; }
  FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad&) const {
    const Vec3 v = vec(velocity);
    return {-0.5 * coefficient * density * std::numbers::pi * position.w * position.w * v.norm() * v};
  }
  double rate(double radius, double inertia, double speed, double) const {
    return coefficient * density * std::numbers::pi * radius * radius * speed / inertia;
  }
};

// The drag of a smooth sphere from creeping flow to Newton's range, times C: F = −½ C C_D ρ A |v| v with
//   C_D = max(24/Re (1 + 0.15 Re^0.687), 0.44), Re = ρ |v| d/η
// (Schiller & Naumann 1933). Written as Stokes' force times a factor, it has no quotient at rest.
struct SphereDrag {
  static constexpr const char* name = "air_drag";
  double factor = 1;     // C [-]
  double density = 0;    // ρ [kg/m³]
  double viscosity = 0;  // η [Pa s]

  double reynolds(double radius, double speed) const { return density * speed * 2 * radius / viscosity; }
  const SphereDrag& at(double, double) const { return *this; }
  FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad&) const {
    const Vec3 v = vec(velocity);
    const double re = reynolds(position.w, v.norm());
    return {-factor * 6 * std::numbers::pi * viscosity * position.w * std::max(1 + 0.15 * std::pow(re, 0.687), 0.44 / 24 * re) * v};
  }
  double rate(double radius, double inertia, double speed, double) const {
    const double re = reynolds(radius, speed);
    return factor * 6 * std::numbers::pi * viscosity * radius * std::max(1 + 1.687 * 0.15 * std::pow(re, 0.687), 2 * 0.44 / 24 * re) / inertia;
  }
};

// F = −3π η d v (Stokes 1851).
struct ViscousDrag {
  static constexpr const char* name = "viscous_drag";
  double viscosity = 0;  // η [Pa s]

  const ViscousDrag& at(double, double) const { return *this; }
  FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad&) const {
    return {-6 * std::numbers::pi * viscosity * position.w * vec(velocity)};
  }
  double rate(double radius, double inertia, double, double) const { return 6 * std::numbers::pi * viscosity * radius / inertia; }
};

// F = −ρ V g.
struct Buoyancy {
  static constexpr const char* name = "buoyancy";
  double density = 0;           // ρ of the fluid [kg/m³]
  Vec3 gravity = Vec3::Zero();  // [m/s²]

  const Buoyancy& at(double, double) const { return *this; }
  FieldLoad operator()(const Quad& position, const Quad&, const Quad&) const { return {-density * ball_volume(position.w) * gravity}; }
  double rate(double, double, double, double) const { return 0; }
};

// F = C ρ π R³ ω×v (Rubinow & Keller 1961, C = 1 in creeping flow).
struct Magnus {
  static constexpr const char* name = "magnus";
  double coefficient = 0;  // C [-]
  double density = 0;      // ρ [kg/m³]

  const Magnus& at(double, double) const { return *this; }
  FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad& spin) const {
    return {coefficient * density * std::numbers::pi * position.w * position.w * position.w * vec(spin).cross(vec(velocity))};
  }
  double rate(double radius, double inertia, double, double spin) const {
    return std::abs(coefficient) * density * std::numbers::pi * radius * radius * radius * spin / inertia;
  }
};

}  // namespace quern
