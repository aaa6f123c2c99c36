// Classical models of the power that a tumbling ball mill draws: bands for judging a simulation, not a replacement for it. All take
// a dry charge.
#pragma once

namespace quern {

// What all models are told.
struct MillCharge {
  double diameter = 0;         // of the mill, inside [m]
  double length = 0;           // inside [m]
  double filling = 0;          // bulk volume of the charge / mill volume, 0 to 1
  double speed_fraction = 0;   // of the critical speed √(2g/D) at which a point on the shell is weightless
  double ball_density = 7800;  // solid [kg/m³]
  double porosity = 0.4;       // of the charge at rest
  double gravity = 9.81;       // [m/s²]
};

// Each throws InputError unless the sizes, density and gravity are above 0, and filling, speed_fraction (Morrell: up to 1) and
// porosity are where the model has a meaning.

// Torque model: the charge at rest is a segment of a circle whose surface leans at the angle of repose [rad]; its weight acts on the
// arm between the centre of gravity and the axis, and the power is that torque times the mill's angular speed. The segment's
// first moment is (2/3) (R sin θ)³ with 2θ the angle that it subtends: P = ρ_b g L sin α ω (2/3) R³ sin³θ, and
// (2θ − sin 2θ)/2π = filling. Without a loss of power at high speed it overestimates from about 80 % of the critical speed on.
// Scales as D^2.5 L. Hogg, R. & Fuerstenau, D. W. (1972), Power relationships for tumbling mills, Trans. SME-AIME 252, 418–423.
double hogg_fuerstenau_power(const MillCharge& charge, double angle_of_repose);  // [W]

// Where Morrell's charge lies: angles counted against the turning from the 3 o'clock direction of a mill that turns clockwise, so that
// sin is the height over the axis.
struct MorrellShape {
  double toe = 0, shoulder = 0;  // [rad]
  double inner_radius = 0;       // of the active charge [m]
  double active_fraction = 0;    // of the charge that rides with the shell; the rest is in flight
};
MorrellShape morrell_shape(const MillCharge& charge);

// The C-model (full, but for a cylindrical mill without conical ends, a dry charge and no slurry pool): the rate at which the charge
// between inner radius, shoulder and toe gains potential and kinetic energy. Morrell, S. (1996), Power draw of wet tumbling mills and
// its relationship to charge dynamics, part 1: a continuum approach to mathematical modelling of mill power draw, Trans. Instn Min.
// Metall. C 105, 43–53; eqs. of toe, shoulder, inner radius and net power. The empirical toe and shoulder come from a glass-ended
// laboratory mill with lifters at fillings from 0.15 to 0.5 and speeds above about half the critical.
double morrell_c_power(const MillCharge& charge);  // [W]

// Power at the pinion, bearing losses included. Bond's equation for wet overflow ball mills in metric form: kW per tonne of balls = 4.879
// D^0.3 (3.2 − 3 J) φ (1 − 0.1/2^(9 − 10 φ)), D in metres; times 1.08 for dry grinding, as here. Its correction for small balls in mills
// above 3.3 m is left out. Bond, F. C. (1961), Crushing and grinding calculations, Brit. Chem. Eng. 6, 378–385 and 543–548, in the metric
// form of Rowland, C. A. & Kjos, D. M. (1980), Rod and ball mills, in Mular & Bhappu (eds), Mineral Processing Plant Design, SME. Fitted to
// mills of 2.4 m and more.
double bond_power(const MillCharge& charge);  // [W]

}  // namespace quern
