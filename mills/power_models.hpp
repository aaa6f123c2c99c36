// Classical models of the power that a tumbling ball mill draws: bands for judging a simulation, not a replacement for it.
#pragma once

namespace quern {

// What all models are told.
struct MillCharge {
  double diameter = 0;         // of the mill, inside [m]
  double length = 0;           // inside [m]
  double filling = 0;          // bulk volume of the charge / mill volume, 0 to 1
  double speed_fraction = 0;   // of the critical speed √(2g/D)
  double ball_density = 7800;  // solid [kg/m³]
  double porosity = 0.4;       // of the charge at rest
  double gravity = 9.81;       // [m/s²]

  double bulk_density() const { return ball_density * (1 - porosity); }  // of a dry charge, voids empty [kg/m³]
};

double hogg_fuerstenau_power(const MillCharge& charge, double angle_of_repose);
double morrell_c_power(const MillCharge& charge);
double bond_power(const MillCharge& charge);

}  // namespace quern
