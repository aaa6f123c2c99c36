#include "mills/power_models.hpp"
#include <algorithm>
#include <cmath>
#include <string>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr double pi = 3.141592653589793;

void check(const MillCharge& c, double most_speed_fraction) {
  const bool sizes = c.diameter > 0 && c.length > 0 && c.ball_density > 0 && c.gravity > 0 &&
                     std::isfinite(c.diameter * c.length * c.ball_density * c.gravity);
  const bool shares = c.filling >= 0 && c.filling <= 1 && c.porosity >= 0 && c.porosity < 1;
  if (!sizes || !shares)
    throw InputError("A power model needs diameter, length, density and gravity above 0, and filling and porosity between 0 and 1.");
  if (!(c.speed_fraction >= 0 && c.speed_fraction <= most_speed_fraction)) {
    throw InputError("The speed fraction is outside the power model's range, which ends at " + std::to_string(most_speed_fraction) + ".");
  }
}

double bulk_density(const MillCharge& c) { return c.ball_density * (1 - c.porosity); }
double critical(const MillCharge& c) { return std::sqrt(2 * c.gravity / c.diameter); }

// Half the angle that a segment with this share of a circle's area subtends at its centre.
double half_angle(double share) {
  double low = 0, high = pi;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    ((2 * middle - std::sin(2 * middle)) / (2 * pi) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double hogg_fuerstenau_power(const MillCharge& charge, double angle_of_repose) {
  check(charge, 1e9);
  const double half_chord = 0.5 * charge.diameter * std::sin(half_angle(charge.filling));
  const double moment = 2.0 / 3 * half_chord * half_chord * half_chord;
  const double torque = bulk_density(charge) * charge.gravity * charge.length * moment * std::sin(angle_of_repose);
  return torque * charge.speed_fraction * critical(charge);
}

MorrellShape morrell_shape(const MillCharge& charge) {
  check(charge, 1.0);
  const double filling = charge.filling, speed = charge.speed_fraction, radius = 0.5 * charge.diameter;
  MorrellShape shape;
  // The speed at which the charge centrifuges.
  const double limit = std::max(speed, 0.35 * (3.3364 - filling));
  shape.toe = 2.5307 * (1.2796 - filling) * (1 - std::exp(-19.42 * (limit - speed))) + pi / 2;
  shape.shoulder = pi / 2 - (shape.toe - pi / 2) * ((0.3386 + 0.1041 * speed) + (1.54 - 2.5673 * speed) * filling);
  const double span = 2 * pi + shape.shoulder - shape.toe;
  const double lift = std::sin(shape.shoulder) - std::sin(shape.toe);
  shape.active_fraction = 1;
  if (speed > 0) {
    const double mean_radius = 0.5 * radius * (1 + std::sqrt(std::max(0.0, 1 - 2 * pi * filling / span)));
    const double mean_turns = 0.5 * speed * critical(charge) / (2 * pi);
    const double riding = span / (2 * pi * mean_turns), falling = std::sqrt(2 * mean_radius * std::max(0.0, lift) / charge.gravity);
    shape.active_fraction = riding / (riding + falling);
  }
  shape.inner_radius = radius * std::sqrt(std::max(0.0, 1 - 2 * pi * shape.active_fraction * filling / span));
  return shape;
}

double morrell_c_power(const MillCharge& charge) {
  const MorrellShape shape = morrell_shape(charge);
  const double r_m = 0.5 * charge.diameter, r_i = shape.inner_radius, turns = charge.speed_fraction * critical(charge) / (2 * pi);
  // Layers turn the slower the farther inside they are: N(r) = N_m r_m (r − z r_i) / (r (r_m − z r_i)).
  const double z = std::pow(1 - charge.filling, 0.4532), arm = r_m - z * r_i;
  if (arm <= 0) return 0;
  const double lift = std::sin(shape.shoulder) - std::sin(shape.toe), density = bulk_density(charge), length = charge.length;
  const double potential = pi * charge.gravity * length * turns * r_m / (3 * arm) *
                           (2 * std::pow(r_m, 3) - 3 * z * r_m * r_m * r_i + std::pow(r_i, 3) * (3 * z - 2)) * density * lift;
  const double kinetic = length * density * std::pow(turns * r_m * pi / arm, 3) * (std::pow(arm, 4) - std::pow(r_i * (z - 1), 4));
  return potential + kinetic;
}

double bond_power(const MillCharge& charge) {
  check(charge, 1.0);
  constexpr double dry = 1.08;
  const double speed = charge.speed_fraction;
  const double tonnes = 1e-3 * bulk_density(charge) * charge.filling * 0.25 * pi * charge.diameter * charge.diameter * charge.length;
  const double kilowatts_per_tonne =
      4.879 * std::pow(charge.diameter, 0.3) * (3.2 - 3 * charge.filling) * speed * (1 - 0.1 / std::pow(2, 9 - 10 * speed));
  return 1e3 * dry * kilowatts_per_tonne * tonnes;
}

}  // namespace quern
