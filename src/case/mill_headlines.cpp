#include "src/case/mill_headlines.hpp"
#include <cmath>
#include <numbers>
#include "mills/power_models.hpp"

namespace quern {
namespace {

// As the models have it: their critical speed is that of a point on the shell, and they know one density of balls.
MillCharge charge_of(const Case& c, const Built& built) {
  const Particles& balls = built.simulation.particles;
  double mass = 0, solid = 0;
  for (Index i = 0; i < balls.owned; ++i) {
    mass += balls.mass(i);
    solid += ball_volume(built.simulation.solid_radius(i));
  }
  MillCharge charge;
  charge.diameter = c.mill->diameter;
  charge.length = c.mill->length;
  charge.filling = built.filling;
  charge.gravity = c.gravity.norm();
  charge.speed_fraction = std::abs(c.mill->speed) / critical_speed(charge.diameter, 0, charge.gravity);
  charge.ball_density = mass / solid;
  charge.porosity = bulk_porosity;
  return charge;
}

std::vector<Headline> planetary_headlines(const Case& c, const Built& built) {
  const PlanetaryMill& mill = *c.planetary;
  const double disc = std::abs(mill.speed), gravity = c.gravity.norm();
  std::vector<Headline> lines = {{"disc_speed", mill.speed, "rad/s", {}, "speed of the disc"},
                                 {"filling", built.filling, "1", {}, "bulk volume of the charge (porosity 0.4) over the volume of the vials"}};
  if (gravity > 0) lines.push_back({"centrifugal_factor", 0.5 * mill.disc_diameter * disc * disc / gravity, "1", {}, "pull of the disc at the middle of a vial over gravity"});
  if (mill.tilt > 0) return lines;
  lines.push_back({"vial_speed", absolute_ratio(mill) * mill.speed, "rad/s", {}, "speed of the vials against the fixed frame"});
  lines.push_back({"critical_speed", c.critical_speed, "rad/s", {}, "speed of the vials against the fixed frame at which the largest ball stays on the shell, without gravity"});
  if (c.critical_speed > 0)
    lines.push_back({"speed_fraction", std::abs(absolute_ratio(mill)) * disc / c.critical_speed, "1", {}, "speed of the vials against the fixed frame over critical speed"});
  return lines;
}

std::vector<Headline> stirred_headlines(const Case& c, const Built& built) {
  const double speed = c.stirred->speed, tip = tip_radius(stirrer_of(built.simulation.walls));
  return {{"stirrer_speed", speed, "rad/s", {}, "speed of the stirrer"},
          {"tip_speed", tip * std::abs(speed), "m/s", {}, "speed of the part of the stirrer that is farthest from its axis"},
          {"filling", built.filling, "1", {}, "bulk volume of the charge (porosity 0.4) over the volume of the vessel less shaft, discs and pins"}};
}

}  // namespace

std::vector<Headline> mill_headlines(const Case& c, const Built& built) {
  if (c.stirred) return stirred_headlines(c, built);
  if (c.planetary) return planetary_headlines(c, built);
  if (!c.mill) return {};
  std::vector<Headline> lines = {{"critical_speed", c.critical_speed, "rad/s", {}, "speed at which the largest ball stays on the shell"},
                                 {"speed_fraction", c.mill->speed / c.critical_speed, "1", {}, "speed over critical speed"},
                                 {"filling", built.filling, "1", {}, "bulk volume of the charge (porosity 0.4) over the volume of the mill"}};
  if (!(built.filling > 0 && built.filling < 1) || !(c.gravity.norm() > 0)) return lines;
  const MillCharge charge = charge_of(c, built);
  const auto add = [&](const char* key, double power, const char* description) {
    if (std::isfinite(power) && power > 0) lines.push_back({key, power, "W", {}, description});
  };
  constexpr double repose = 40 * std::numbers::pi / 180;
  add("power_hogg_fuerstenau", hogg_fuerstenau_power(charge, repose), "by Hogg & Fuerstenau's torque model for a charge that leans at 40 degrees");
  constexpr double most = 1;  // up to which the other two were fitted
  if (charge.speed_fraction > most) return lines;
  add("power_morrell", morrell_c_power(charge), "by Morrell's C-model, without losses; its angles come from a laboratory mill, its constants from far larger ones");
  add("power_bond", bond_power(charge), "by Bond's equation, bearings included; fitted to mills of 2.4 m and more");
  return lines;
}

}  // namespace quern
