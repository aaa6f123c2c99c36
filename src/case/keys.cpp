#include "src/case/keys.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <sstream>

namespace quern {
namespace {

using enum KeyKind;
constexpr Range any{};
constexpr Range positive{0, no_bound, true};
constexpr Range not_negative{0, no_bound, false};
constexpr Range up_to_one{0, 1, true};
constexpr Range share{0, 1, false};

constexpr Key table[] = {
    // The run
    {"name", text, "", "", any, "", "Name of the case; default: of its folder, or of its file", ""},
    {"title", text, "", "\"\"", any, "", "One line that says what the case is", ""},
    {"duration", number, "s", "required", positive, "", "Simulated time; with observe.stop_at_interval: the longest", ""},
    {"seed", whole, "1", "1", {0, 9e15}, "", "Seed of everything drawn at random", ""},
    {"gravity", vector, "m/s2", "[0, 0, -9.81]", {-1e6, 1e6}, "", "Gravity in the fixed frame", ""},
    {"time_step.value", number, "s", "", positive, "", "Time step; default: fraction of the limit", ""},
    {"time_step.fraction", number, "1", "0.2", up_to_one, "", "Fraction of the Rayleigh time that the automatic step takes for Hertzian contacts", "S4 eq. 4; Li et al. 2005"},
    {"time_step.unsafe", flag, "", "false", any, "", "Allow a time step above the limit", ""},

    // Materials and pairs
    {"material.<name>.density", number, "kg/m3", "required", positive, "", "Density", ""},
    {"material.<name>.young", number, "Pa", "", positive, "", "Young's modulus; needed by hertz_mindlin and deresiewicz", ""},
    {"material.<name>.poisson", number, "1", "0.3", {-0.99, 0.5}, "", "Poisson's ratio", ""},
    {"pair.<a>.<b>.law", word, "", "\"hertz_mindlin\"", any, "linear hertz_mindlin deresiewicz power_law linearized", "Contact law of two materials; pair.default serves every pair without a table of its own", ""},
    {"pair.<a>.<b>.restitution", number, "1", "", up_to_one, "", "Coefficient of restitution of a head-on collision", "Schwager & Pöschel 2007"},
    {"pair.<a>.<b>.friction", number, "1", "0", {0, 100}, "", "Coefficient of sliding friction", ""},
    {"pair.<a>.<b>.normal_stiffness", number, "N/m", "", positive, "", "linear, linearized: stiffness of the normal spring", "S0 eq. 1, table 3"},
    {"pair.<a>.<b>.penetration_factor", number, "1", "", positive, "", "linear, instead of normal_stiffness: f in k = f² m v²/d², which lets a ball of the pair's greatest mass m and diameter d penetrate d/f at max_speed", "S0 eq. 2"},
    {"pair.<a>.<b>.max_speed", number, "m/s", "", positive, "", "linear, with penetration_factor: the greatest speed v that is expected", "S0 eq. 2"},
    {"pair.<a>.<b>.tangential_stiffness", number, "N/m", "", not_negative, "", "linear, power_law, linearized: stiffness of the tangential spring", "S0 table 3"},
    {"pair.<a>.<b>.tangential_ratio", number, "1", "0.6666666666666666", {0, 10}, "", "Tangential stiffness over normal stiffness, where tangential_stiffness is not given", "S0 table 3"},
    {"pair.<a>.<b>.normal_damping", number, "kg/s", "", not_negative, "", "linearized: damping q' of the normal dashpot", "S0 table 2"},
    {"pair.<a>.<b>.stiffness_coefficient", number, "1", "", positive, "", "power_law, linearized: k in k δ^r [N/m^r]", "S0 eq. 12"},
    {"pair.<a>.<b>.stiffness_exponent", number, "1", "1.6", {1, 3}, "", "power_law, linearized: r", "S0 eq. 13"},
    {"pair.<a>.<b>.damping_coefficient", number, "1", "", not_negative, "", "power_law, linearized: q in q δ^s v [N s/m^(s+1)]", "S0 eq. 12"},
    {"pair.<a>.<b>.damping_exponent", number, "1", "0.8", {0, 3}, "", "power_law, linearized: s", "S0 eq. 13"},
    {"pair.<a>.<b>.impact_mass", number, "kg", "", positive, "", "power_law, linearized from k and q: effective mass of the typical impact", "S0 eqs. 23–24"},
    {"pair.<a>.<b>.impact_speed", number, "m/s", "", positive, "", "power_law, linearized from k and q: speed of the typical impact", "S0 eqs. 23–24"},
    {"pair.<a>.<b>.reference_speed", number, "m/s", "1", positive, "", "deresiewicz: the speed at which the restitution is as asked; it falls with speed", "S2 eqs. 1.3–1.4"},
    {"pair.<a>.<b>.reference_diameter", number, "m", "", positive, "", "deresiewicz: the ball whose restitution is as asked; default: the largest of the pair", "S2 eqs. 1.3–1.4"},
    {"pair.<a>.<b>.rolling", word, "", "\"elastic_plastic\"", any, "none constant_torque elastic_plastic", "Model of rolling resistance", "S2 eq. 1.2; Ai et al. 2011"},
    {"pair.<a>.<b>.rolling_friction", number, "1", "0", {0, 10}, "", "Coefficient of rolling friction; 0 switches rolling resistance off", "S2 eq. 1.2; Ai et al. 2011"},
    {"pair.<a>.<b>.rolling_damping", number, "1", "0.3", {0, 10}, "", "elastic_plastic: damping of the rolling spring over critical damping", "Ai et al. 2011"},

    // Effects of a pair beyond its law (docs/effects.md)
    {"pair.<a>.<b>.tangential_compliance", number, "1", "1", {0, 1000}, "", "Compliance of the tangential spring over that of the law; 0: none, the bodies stick without a spring", "Mindlin 1949; Maw et al. 1976"},
    {"pair.<a>.<b>.torsional_friction", number, "1", "0", {0, 10}, "", "Friction μ_t about the normal: a moment up to μ_t R* F_n", ""},
    {"pair.<a>.<b>.restitution_exponent", number, "1", "0", {0, 2}, "", "linear, hertz_mindlin: q in 1 − e(v) = (1 − e)(v/v₁)^q, v the approach speed at first touch and v₁ the reference_speed; 0.2: viscoelastic spheres", "Schwager & Pöschel 1998"},
    {"pair.<a>.<b>.viscoelastic_time", number, "s", "0", not_negative, "", "A in a further damping force −A (dF_e/dδ) v_n", "Kuwabara & Kono 1987; Brilliantov et al. 1996"},
    {"pair.<a>.<b>.hardening", number, "1/m", "0", not_negative, "", "h in F_e → F_e (1 + h δ)", ""},
    {"pair.<a>.<b>.stiffness_power", number, "1", "0", {-0.5, 2}, "", "p in F_e → F_e (δ/δ₁)^p", ""},
    {"pair.<a>.<b>.reference_overlap", number, "m", "1e-6", positive, "", "with stiffness_power: δ₁", ""},
    {"pair.<a>.<b>.powder_layers", number, "1", "0", {0, 100}, "", "Layers n of powder between the bodies: F_e → F_e (1 + n)^(−r), r the law's exponent, and its damping times 1 + n", "after S0 fig. 6"},
    {"pair.<a>.<b>.unloading_ratio", number, "1", "1", {1, 1e4}, "", "Stiffness of unloading over that of loading: the contact keeps an indentation", "Walton & Braun 1986"},
    {"pair.<a>.<b>.yield_pressure", number, "Pa", "", positive, "", "hertz_mindlin, deresiewicz: greatest pressure of the contact, beyond which it flattens; default: none", "Thornton 1997; Thornton & Ning 1998"},
    {"pair.<a>.<b>.surface_energy", number, "J/m2", "0", not_negative, "", "hertz_mindlin, deresiewicz: work of adhesion w; pull-off is 3/2 π w R*", "Johnson, Kendall & Roberts 1971"},
    {"pair.<a>.<b>.wave_admittance", number, "s/kg", "0", not_negative, "", "1/(ρcA) of a long rod behind the contact, whose end moves with F/(ρcA)", "S0 eq. 11; Goldsmith 1960"},
    {"pair.<a>.<b>.film_viscosity", number, "Pa s", "0", not_negative, "", "Viscosity η of a film that opposes approach and parting: 6π η R*² v_n/h, h the gap", "Reynolds 1886"},
    {"pair.<a>.<b>.film_thickness", number, "m", "", positive, "", "with film_viscosity: gap below which the film acts, that on both bodies together", ""},
    {"pair.<a>.<b>.film_cutoff", number, "m", "", positive, "", "with film_viscosity: least gap that counts, of the size of the roughness", ""},
    {"pair.<a>.<b>.bridge_volume", number, "m3", "0", not_negative, "", "Volume of the bridge of liquid that forms where bodies touch", "Willett et al. 2000"},
    {"pair.<a>.<b>.surface_tension", number, "N/m", "0.0728", positive, "", "with bridge_volume: surface tension", "Willett et al. 2000"},
    {"pair.<a>.<b>.wetting_angle", number, "rad", "0", {0, 1.5}, "", "with bridge_volume: contact angle of liquid and solid", "Willett et al. 2000"},
    {"pair.<a>.<b>.extra_force_variable", word, "", "\"overlap\"", any, "overlap normal_velocity time", "What a further normal force depends on: the overlap [m], the speed of approach [m/s; negative while the bodies part] or the time since first touch [s]", ""},
    {"pair.<a>.<b>.extra_force_phase", word, "", "\"both\"", any, "both loading unloading", "When it acts: always, while the bodies approach, or while they part", ""},
    {"pair.<a>.<b>.extra_force_at", numbers, "1", "", any, "", "Up to 32 ascending values of that variable in SI units", ""},
    {"pair.<a>.<b>.extra_force", numbers, "N", "", any, "", "The force at each, linear in between and constant beyond; the whole normal force stays repulsive", ""},

    // Species and their sizes
    {"species.<name>.material", name, "", "required", any, "", "Material of its particles", ""},
    {"species.<name>.density", number, "kg/m3", "", positive, "", "Density; default: of the material", ""},
    {"species.<name>.shape", word, "", "\"sphere\"", any, "sphere superquadric", "Shape of its particles", ""},
    {"species.<name>.semi_axes", vector, "m", "", positive, "", "superquadric: a, b, c in (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1; their proportions, where a size distribution tells the diameters of balls of the same volume", "Barr 1981; Jaklič et al. 2000"},
    {"species.<name>.exponents", numbers, "1", "[2, 2]", {2, 20}, "", "superquadric: n1, n2; 2, 2 is an ellipsoid, larger ones are boxier", "Barr 1981; Jaklič et al. 2000"},
    {"species.<name>.sizes", word, "", "", any, "mono list lognormal rosin_rammler table", "Kind of size distribution; default: told by the keys that are given", ""},
    {"species.<name>.diameter", number, "m", "", positive, "", "mono: diameter", ""},
    {"species.<name>.diameters", numbers, "m", "", positive, "", "list: the diameters", ""},
    {"species.<name>.counts", numbers, "1", "", not_negative, "", "list: how many of each diameter, in proportion", ""},
    {"species.<name>.mass_fractions", numbers, "1", "", not_negative, "", "list: mass of each diameter, in proportion", ""},
    {"species.<name>.median", number, "m", "", positive, "", "lognormal: median diameter", "Hatch & Choate 1929"},
    {"species.<name>.sigma", number, "1", "", {0, 3, true}, "", "lognormal: standard deviation of ln d", "Hatch & Choate 1929"},
    {"species.<name>.weight", word, "", "\"mass\"", any, "number mass", "lognormal: what the median counts", ""},
    {"species.<name>.size", number, "m", "", positive, "", "rosin_rammler: the size below which 63.2 % of the mass is", "Rosin & Rammler 1933"},
    {"species.<name>.modulus", number, "1", "", {0, 100, true}, "", "rosin_rammler: modulus of uniformity", "Rosin & Rammler 1933"},
    {"species.<name>.smallest", number, "m", "", positive, "", "lognormal, rosin_rammler: diameters below are cut off", ""},
    {"species.<name>.largest", number, "m", "", positive, "", "lognormal, rosin_rammler: diameters above are cut off", ""},
    {"species.<name>.table", file, "", "", any, "", "table: CSV file of diameter [m] and mass fraction finer [1], beside the case", ""},

    // Bodies of bonded grains
    {"bond.<a>.<b>.young", number, "Pa", "", positive, "", "Young's modulus of the cement between grains of two species; bond.default serves every two without a table of their own", "Potyondy & Cundall 2004"},
    {"bond.<a>.<b>.stiffness_ratio", number, "1", "2.5", {1, 100}, "", "Normal over shear stiffness, E_b/G_b", "Potyondy & Cundall 2004"},
    {"bond.<a>.<b>.normal_stiffness", number, "N/m3", "", positive, "", "Normal stiffness per area, instead of young", "S2 eq. 1.5"},
    {"bond.<a>.<b>.tensile_strength", number, "Pa", "", positive, "", "Greatest stress of tension and bending; default: it never fails so", "S2 eq. 1.10"},
    {"bond.<a>.<b>.shear_strength", number, "Pa", "", positive, "", "Greatest stress of shear and twist; default: it never fails so", "S2 eq. 1.11"},
    {"bond.<a>.<b>.strength", word, "", "\"constant\"", any, "constant normal weibull", "How the strengths of bonds scatter: none, about the given mean, or Weibull's law with the given scale", "Weibull 1951"},
    {"bond.<a>.<b>.deviation", number, "1", "0", {0, 1}, "", "normal: standard deviation over mean", ""},
    {"bond.<a>.<b>.modulus", number, "1", "", {0, 1000, true}, "", "weibull: modulus", "Weibull 1951"},
    {"bond.<a>.<b>.rate_exponent", number, "1", "0", {0, 1}, "", "Strength grows as (rate/reference_rate)^n with the nominal rate of strain of a body, its speed at the start over its size", "Kipp, Grady & Chen 1980 (n = 1/3)"},
    {"bond.<a>.<b>.reference_rate", number, "1/s", "1", positive, "", "Rate of strain up to which the strength is as given", ""},
    {"bond.<a>.<b>.size_exponent", number, "1", "0", {-1, 3}, "", "Strength falls as (size/reference_size)^(−q) with the size of the body; weakest links: q = 3/modulus", "Weibull 1939"},
    {"bond.<a>.<b>.reference_size", number, "m", "", positive, "", "with size_exponent: size of a body, across, whose strength is as given", ""},
    {"bond.<a>.<b>.damping", number, "1", "0.05", {0, 1}, "", "Damping of the four springs over critical damping", ""},
    {"bond.<a>.<b>.radius_ratio", number, "1", "1", {0, 2, true}, "", "Radius of the bond over that of the smaller grain", "Potyondy & Cundall 2004"},
    {"agglomerate.<name>.shape", word, "", "", any, "sphere cylinder box superquadric mesh", "Shape that grains fill", ""},
    {"agglomerate.<name>.radius", number, "m", "", positive, "", "sphere, cylinder: radius", ""},
    {"agglomerate.<name>.length", number, "m", "", positive, "", "cylinder: length, along z", ""},
    {"agglomerate.<name>.size", vector, "m", "", positive, "", "box: edges; superquadric: lengths along x, y, z", ""},
    {"agglomerate.<name>.exponent", number, "1", "2", {2, 20}, "", "superquadric: exponent; 2: ellipsoid", "Jaklič et al. 2000"},
    {"agglomerate.<name>.file", file, "", "", any, "", "mesh: STL file of a closed surface about the origin", ""},
    {"agglomerate.<name>.scale", number, "1", "1", positive, "", "mesh: metres per unit of the file", ""},
    {"agglomerate.<name>.grains", names, "", "", any, "", "Species of the grains", ""},
    {"agglomerate.<name>.shares", numbers, "1", "", not_negative, "", "Volume of the grains of each species, in proportion; default: equal", ""},
    {"agglomerate.<name>.solid_fraction", number, "1", "", {0, 0.74, true}, "", "Volume of the grains over that of the shape; default: as dense as packs easily, 0.54 or, in a body of few grains, less", ""},
    {"agglomerate.<name>.bonding", word, "", "\"gap\"", any, "gap triangulation", "Which grains are bonded: all nearer than the gap, or of those the neighbours in the regular triangulation", ""},
    {"agglomerate.<name>.gap", number, "m", "", not_negative, "", "Gap of two surfaces up to which they are bonded; default: a tenth of the smallest grain's diameter", ""},
    {"agglomerate.<name>.assembly", file, "", "", any, "", "CSV file of the grains, instead of a shape: x, y, z, diameter [m] and optionally kind, the place of its species in `grains` from 0", ""},

    // Motion frames and walls
    {"frame.<name>.parent", name, "", "", any, "", "Frame in which this one moves; default: the fixed frame", ""},
    {"frame.<name>.motion", word, "", "required", any, "rotation table translation oscillation", "How it moves in its parent", ""},
    {"frame.<name>.axis", vector, "1", "[0, 0, 1]", any, "", "rotation, table: direction of the axis in the parent", ""},
    {"frame.<name>.centre", vector, "m", "[0, 0, 0]", any, "", "rotation, table: a point of the axis in the parent", ""},
    {"frame.<name>.speed", number, "rad/s", "0", any, "", "rotation: angular speed", ""},
    {"frame.<name>.ramp", number, "s", "0", not_negative, "", "rotation, translation: time from rest to full speed", ""},
    {"frame.<name>.times", numbers, "s", "", any, "", "table: ascending instants", ""},
    {"frame.<name>.speeds", numbers, "rad/s", "", any, "", "table: angular speed at each instant, linear in between", ""},
    {"frame.<name>.velocity", vector, "m/s", "[0, 0, 0]", any, "", "translation: velocity in the parent", ""},
    {"frame.<name>.amplitude", vector, "m", "[0, 0, 0]", any, "", "oscillation: amplitude in the parent", ""},
    {"frame.<name>.frequency", number, "Hz", "0", not_negative, "", "oscillation: frequency", ""},
    {"frame.<name>.phase", number, "rad", "0", any, "", "oscillation: phase at the start", ""},
    {"wall.<name>.type", word, "", "required", any, "plane cylinder cone disc mesh", "Kind of surface", ""},
    {"wall.<name>.material", name, "", "required", any, "", "Its material", ""},
    {"wall.<name>.frame", name, "", "", any, "", "Frame that carries it; default: fixed", ""},
    {"wall.<name>.point", vector, "m", "[0, 0, 0]", any, "", "A point of a plane, the centre of a disc, the middle of the axis of a cylinder or cone, the place of a mesh's origin", ""},
    {"wall.<name>.axis", vector, "1", "[0, 0, 1]", any, "", "Normal of a plane or disc (into the free side), axis of a cylinder or cone, direction of a mesh's z axis", ""},
    {"wall.<name>.radius", number, "m", "", positive, "", "cylinder, disc: radius; cone: radius at the start of the axis", ""},
    {"wall.<name>.end_radius", number, "m", "", not_negative, "", "cone: radius at the end of the axis", ""},
    {"wall.<name>.inner_radius", number, "m", "0", not_negative, "", "disc: radius of the hole", ""},
    {"wall.<name>.length", number, "m", "", positive, "", "cylinder, cone: length", ""},
    {"wall.<name>.side", word, "", "\"both\"", any, "inside outside both", "cylinder, cone: the side on which particles are", ""},
    {"wall.<name>.file", file, "", "", any, "", "mesh: STL file (ASCII or binary), beside the case", ""},
    {"wall.<name>.scale", number, "1", "1", positive, "", "mesh: metres per unit of the file", ""},
    {"wall.<name>.open", flag, "", "false", any, "", "mesh: allow a surface that is not closed", ""},

    // The mill
    {"mill.type", word, "", "\"tumbling\"", any, "tumbling planetary stirred", "Kind of mill", ""},
    {"mill.diameter", number, "m", "", positive, "", "Inside the shell; planetary: inside a vial; stirred: inside the vessel", ""},
    {"mill.length", number, "m", "", positive, "", "Inside the ends, or the period along a mill without ends; planetary: inside a vial; stirred: inside the vessel", ""},
    {"mill.length_ratio", number, "1", "", positive, "", "Length over diameter, instead of length", ""},
    {"mill.speed", number, "rad/s", "", any, "", "Speed of rotation, right-handed about the axis; planetary: of the disc; stirred: of the stirrer", ""},
    {"mill.speed_fraction", number, "1", "", {-3, 3}, "", "tumbling: speed as a fraction of the critical speed √(2g/(D − d)), with d the greatest diameter of the charge", ""},
    {"mill.ramp", number, "s", "0", not_negative, "", "Time from rest to full speed", ""},
    {"mill.filling", number, "1", "", {0, 0.9, true}, "", "Bulk volume of the charge (porosity 0.4) over the volume of the mill (planetary: of each vial; stirred: of the vessel less shaft, discs and pins); for insertions that tell no amount", ""},
    {"mill.material", name, "", "", any, "", "Material of shell, lifters and ends, vials, vessel and stirrer; may be left out if the case has only one", ""},
    {"mill.axis", vector, "1", "", any, "", "Direction of the axis, planetary: of the disc, stirred: from the start of the vessel to its end; default: tumbling [0, 1, 0], planetary and stirred [0, 0, 1]", ""},
    {"mill.centre", vector, "m", "[0, 0, 0]", any, "", "Middle of the mill; planetary: of the disc, between the middles of the vials; stirred: of the vessel", ""},
    {"mill.ends", word, "", "\"walls\"", any, "walls periodic", "tumbling: end walls, or a slice of an endless mill (the axis must then lie along x, y or z)", ""},
    {"mill.disc_diameter", number, "m", "", positive, "", "planetary: diameter of the circle on which the middles of the vials travel", ""},
    {"mill.vials", whole, "1", "1", {1, 12}, "", "planetary: number of vials, evenly spread, all filled alike", ""},
    {"mill.speed_ratio", number, "1", "", {-100, 100}, "", "planetary: speed of the vials over that of the disc; negative: the other way round", ""},
    {"mill.speed_ratio_to", word, "", "\"disc\"", any, "disc fixed", "planetary: whether that speed of the vials is counted against the disc or against the fixed frame (one less against the disc)", ""},
    {"mill.vial_tilt", number, "rad", "0", {0, 1.5707963267949}, "", "planetary: angle of the vials' axes from the disc's, outward; 90 degrees: they lie like spokes", ""},
    {"mill.vial_file", file, "", "", any, "", "planetary: STL file of the inside of a vial, instead of a cylinder with ends: z along its axis, x away from the disc's axis, origin in its middle; diameter and length then tell the part that is filled", ""},
    {"mill.vial_scale", number, "1", "1", positive, "", "planetary: metres per unit of that file", ""},
    {"mill.axes", word, "", "\"fixed\"", any, "fixed disc", "planetary: the axes in which the motion is computed, and in which places and velocities are written; those of the disc turn with it, with centrifugal, Coriolis and Euler forces", "Landau & Lifshitz, Mechanics, § 39"},
    {"mill.shaft.diameter", number, "m", "", positive, "", "stirred: diameter of the shaft", ""},
    {"mill.shaft.clearance", number, "m", "0", not_negative, "", "stirred: from the start of the vessel to the shaft's flat end; 0: it passes through both ends", ""},
    {"mill.stirrer_material", name, "", "", any, "", "stirred: material of shaft, discs and pins; default: mill.material", ""},
    {"mill.discs.count", whole, "1", "0", {0, 1000}, "", "stirred: number of discs on the shaft", ""},
    {"mill.discs.diameter", number, "m", "", positive, "", "Diameter of the discs", ""},
    {"mill.discs.thickness", number, "m", "", positive, "", "Their thickness", ""},
    {"mill.discs.spacing", number, "m", "", positive, "", "Distance of their middles; default: the length of the vessel over their number and one", ""},
    {"mill.discs.first", number, "m", "", positive, "", "From the start of the vessel to the middle of the first disc; default: all of them about the middle of the vessel", ""},
    {"mill.discs.holes", whole, "1", "0", {0, 1000}, "", "Number of round holes through each disc", ""},
    {"mill.discs.hole_diameter", number, "m", "", positive, "", "Diameter of the holes", ""},
    {"mill.discs.hole_circle", number, "m", "", positive, "", "Diameter of the circle on which their middles lie", ""},
    {"mill.pins.rows", whole, "1", "0", {0, 1000}, "", "stirred: number of rows of pins along the shaft", ""},
    {"mill.pins.per_row", whole, "1", "2", {1, 1000}, "", "Number of pins in a row, evenly spread", ""},
    {"mill.pins.diameter", number, "m", "", positive, "", "Diameter of the pins", ""},
    {"mill.pins.tip_circle", number, "m", "", positive, "", "Diameter of the circle on which their tips travel", ""},
    {"mill.pins.spacing", number, "m", "", positive, "", "Distance of the rows; default: the length of the vessel over their number and one", ""},
    {"mill.pins.first", number, "m", "", positive, "", "From the start of the vessel to the first row; default: all of them about the middle of the vessel", ""},
    {"mill.pins.twist", number, "rad", "", {0, 6.2831853071796}, "", "Angle by which each row is turned against the one before; default: half of that between two pins", ""},
    {"mill.stirrer_file", file, "", "", any, "", "stirred: STL file of the stirrer, instead of shaft, discs and pins: z along the axis, origin in the middle of the vessel", ""},
    {"mill.stirrer_scale", number, "1", "1", positive, "", "stirred: metres per unit of that file", ""},
    {"mill.vessel_file", file, "", "", any, "", "stirred: STL file of the inside of the vessel, in the same axes, instead of a cylinder with ends; diameter and length then tell the part that is filled", ""},
    {"mill.vessel_scale", number, "1", "1", positive, "", "stirred: metres per unit of that file", ""},
    {"mill.bearing_torque", number, "N m", "0", not_negative, "", "Torque that the bearings take, at any speed and filling; power and torque are those of the drive, losses included", ""},
    {"mill.gear_loss", number, "1", "0", {0, 1}, "", "What the gears take, as a part of the power that they hand on", ""},
    {"mill.campaign_time", number, "s", "0", not_negative, "", "tumbling: for which the lifters have been in use", ""},
    {"mill.lifters.count", whole, "1", "0", {0, 1000}, "", "tumbling: number of lifters", ""},
    {"mill.lifters.height", number, "m", "", positive, "", "Height above the shell", ""},
    {"mill.lifters.wear", number, "m", "0", not_negative, "", "Height that is worn off already", ""},
    {"mill.lifters.wear_rate", number, "m/s", "0", not_negative, "", "Height that wears off in a second of mill.campaign_time", ""},
    {"mill.lifters.width", number, "m", "", positive, "", "Width at the shell", ""},
    {"mill.lifters.face_angle", number, "rad", "1.5707963267948966", {0.0, 1.5707963267949, true}, "", "trapezoid: angle between face and shell", ""},
    {"mill.lifters.shape", word, "", "\"rectangular\"", any, "rectangular trapezoid bar", "Cross-section", ""},

    // What is put in
    {"insert.<name>.species", name, "", "", any, "", "What is inserted: particles of this species", ""},
    {"insert.<name>.agglomerate", name, "", "", any, "", "What is inserted, instead of a species: bonded bodies of this kind", ""},
    {"insert.<name>.turn", vector, "rad", "[0, 0, 0]", any, "", "list of agglomerates or superquadrics: by which they are turned, a vector along the axis whose length is the angle; packed and raining ones are turned at random", ""},
    {"insert.<name>.method", word, "", "", any, "packing rain list", "packing: dense, from the bottom; rain: at random, dilute; list: at given places. Default: list where positions or a file are given, otherwise packing", ""},
    {"insert.<name>.count", whole, "1", "", {1, 2e9}, "", "Number of particles or agglomerates; in a planetary mill: in each vial", ""},
    {"insert.<name>.mass", number, "kg", "", positive, "", "Mass of particles; in a planetary mill: in each vial", ""},
    {"insert.<name>.filling", number, "1", "", {0, 0.9, true}, "", "Bulk volume (porosity 0.4) over the volume of the mill, or of the region where there is no mill", ""},
    {"insert.<name>.velocity", vector, "m/s", "[0, 0, 0]", any, "", "Velocity at the start, in the fixed frame; what fills a planetary mill: against its disc", ""},
    {"insert.<name>.speed", number, "m/s", "", not_negative, "", "Speed at the start, along `velocity`, whose own length then does not count", ""},
    {"insert.<name>.spin", vector, "rad/s", "[0, 0, 0]", any, "", "Angular velocity at the start, in the fixed frame; what fills a planetary mill: against its disc", ""},
    {"insert.<name>.positions", vectors, "m", "", any, "", "list: centres", ""},
    {"insert.<name>.file", file, "", "", any, "", "list: CSV file with columns x, y, z [m] and optionally diameter [m], vx, vy, vz [m/s], wx, wy, wz [rad/s]", ""},
    {"insert.<name>.allowed_overlap", number, "1", "1e-6", {0, 0.1}, "", "list: largest overlap at the start, in radii; the grains of a bed at rest lie in their contacts", ""},
    {"insert.<name>.region.shape", word, "", "\"mill\"", any, "mill box cylinder sphere", "Where packing and rain put particles", ""},
    {"insert.<name>.region.centre", vector, "m", "[0, 0, 0]", any, "", "Its centre", ""},
    {"insert.<name>.region.axis", vector, "1", "[0, 0, 1]", any, "", "cylinder: direction of its axis", ""},
    {"insert.<name>.region.size", vector, "m", "", positive, "", "box: edges along x, y, z", ""},
    {"insert.<name>.region.radius", number, "m", "", positive, "", "cylinder, sphere: radius", ""},
    {"insert.<name>.region.length", number, "m", "", positive, "", "cylinder: length", ""},

    // Forces on single bodies
    {"medium.density", number, "kg/m3", "1.2", positive, "", "Density of the fluid around the bodies, which is at rest in the fixed frame; no effect by itself", ""},
    {"medium.viscosity", number, "Pa s", "1.8e-5", positive, "", "Its dynamic viscosity; no effect by itself", ""},
    {"medium.drag", word, "", "\"coefficient\"", any, "coefficient schiller_naumann", "What the air drag −½ C_D ρ A |v| v of a ball takes as C_D: drag_coefficient, or drag_coefficient times the curve of a smooth sphere", "Schiller & Naumann 1933"},
    {"medium.drag_coefficient", number, "1", "0", {0, 1000}, "", "Drag coefficient, with schiller_naumann the factor on the curve (1: a smooth sphere); 0 switches air drag off", "Newton; Schiller & Naumann 1933"},
    {"medium.viscous_drag", number, "Pa s", "0", not_negative, "", "Viscosity η of the drag −3π η d v; 0 switches viscous drag off", "Stokes 1851"},
    {"medium.buoyancy", number, "kg/m3", "0", not_negative, "", "Density ρ of the displaced fluid in the force −ρ V g; 0 switches buoyancy off", "Archimedes"},
    {"medium.added_mass_coefficient", number, "1", "0", {0, 100}, "", "Added mass C ρ V, by which the inertia of a ball grows, over the mass of the displaced fluid of medium.density; 0.5 for a sphere, 0 switches it off", "Lamb, Hydrodynamics, § 92"},
    {"medium.magnus_coefficient", number, "1", "0", {-100, 100}, "", "C in the Magnus force C ρ π R³ ω×v; 1 in creeping flow, 0 switches it off", "Rubinow & Keller 1961"},
    {"force.<name>.variable", word, "", "required", any, "speed x y z vx vy vz spin time", "What the force on each ball depends on: its speed, place, velocity or spin (rad/s), or the time", ""},
    {"force.<name>.direction", word, "", "required", any, "against_velocity x y z lift against_spin", "Its direction: against the velocity (what brakes takes at most half of it in a step), along an axis, or along ω×v; against_spin: a torque against the spin", ""},
    {"force.<name>.at", numbers, "1", "required", any, "", "Ascending values of the variable, in SI units, at least two", ""},
    {"force.<name>.values", numbers, "N", "required", any, "", "The force (against_spin: torque, N m) at each, linear in between and constant beyond the ends", ""},

    // Space
    {"periodic.x", numbers, "m", "", any, "", "[from, to]: space repeats along x", ""},
    {"periodic.y", numbers, "m", "", any, "", "[from, to]: space repeats along y", ""},
    {"periodic.z", numbers, "m", "", any, "", "[from, to]: space repeats along z", ""},

    // What is watched and written
    {"output.frames", number, "s", "0", not_negative, "", "Time between frames (results.h5, ParaView); 0: only the first and the last state", ""},
    {"output.energy", number, "s", "0", not_negative, "", "Time between rows of energy.csv; 0: a thousandth of the run", ""},
    {"output.paraview", flag, "", "true", any, "", "Write frames/*.vtp", ""},
    {"output.trajectory", flag, "", "true", any, "", "Write the particles of each frame into results.h5", ""},
    {"output.stages", numbers, "s", "", not_negative, "", "Ascending times at which pictures of the charge are drawn, stage_1.png …; where grains are bonded cut open and by fragment", ""},
    {"output.pictures", flag, "", "true", any, "", "Draw pictures", ""},
    {"observe.start", number, "s", "", not_negative, "", "Averages begin here; default: where the power is found to be steady", "White 1997"},
    {"observe.power", flag, "", "true", any, "", "Torque and power of the driven walls", ""},
    {"observe.power_interval", number, "s", "0.01", positive, "", "Torque and power are averaged over this long", ""},
    {"observe.driven_walls", names, "", "", any, "", "Walls whose torque makes the power; default: every wall that a frame moves", ""},
    {"observe.shell_force", flag, "", "true", any, "", "Force on the driven walls against time, and its spectrum", "S1"},
    {"observe.force_interval", number, "s", "0.001", positive, "", "Time between samples of that force", ""},
    {"observe.band", numbers, "Hz", "[20, 150]", not_negative, "", "Band of that spectrum", "S1"},
    {"observe.spectrum", flag, "", "true", any, "", "Collisions and their energy spectra", ""},
    {"observe.bins_per_decade", whole, "1", "10", {1, 100}, "", "Bins of the energy spectra", ""},
    {"observe.long_contact", number, "s", "0", not_negative, "", "Contacts that last longer are counted apart; 0: 1000 time steps", ""},
    {"observe.stop_at_interval", number, "1", "", {0, 1, true}, "", "The run ends once the 95 % intervals of E_i and of the collisions per second are ± this part of them, or narrower, and stay so; duration is then the longest", "Glynn & Whitt 1992"},
    {"observe.stop_at_bin_interval", number, "1", "", {0, 1, true}, "", "The same for the collisions per second of every bin of impact energy that carries at least 1 % of E_i; with stop_at_interval: when both are met", "Glynn & Whitt 1992"},
    {"observe.convergence_interval", number, "s", "", positive, "", "Time between rows of convergence.csv, at which the run may end so; default: a two-hundredth of the duration", ""},
    {"observe.charge", flag, "", "true", any, "", "Angles, heights and polar fields of the charge of a mill", ""},
    {"observe.charge_interval", number, "s", "0", not_negative, "", "Time between samples of the charge; 0: 1/360 of a revolution, at least 20 steps", ""},
    {"observe.angle_cells", whole, "1", "120", {12, 3600}, "", "Cells of the polar fields around the mill", ""},
    {"observe.radius_cells", whole, "1", "20", {2, 1000}, "", "Cells of the polar fields along the radius", ""},
    {"observe.track", wholes, "1", "", {0, 2e9}, "", "Particles (ids: order of insertion, from 0) whose place, velocity and spin are written against time, track.csv", ""},
    {"observe.track_interval", number, "s", "0", not_negative, "", "Time between rows of track.csv and signal.csv; 0: a thousandth of the run", ""},
    {"observe.signal", flag, "", "false", any, "", "Write what the instruments show of the first particle, signal.csv: place, velocity, spin, and force and displacement at the nearest wall", ""},
    {"observe.loading", names, "", "", any, "", "Walls that load a specimen of bonded grains: their way and force against time, loading.csv; headline numbers are those of the first", ""},
    {"observe.loading_interval", number, "s", "", positive, "", "Those forces are averaged over this long; default: a five-hundredth of the duration", ""},
    {"observe.strain", flag, "", "false", any, "", "Strain along and across the motion of the first of them, in the middle half of the specimen", ""},
    {"observe.gauges", vectors, "m", "", any, "", "Places on the specimen; recorded is how far the first moves along that motion, less the mean of the others", ""},
    {"observe.discharge.point", vector, "m", "", any, "", "A point of a plane, such as that of an outlet; the mass that passes through it is written against time, discharge.csv", ""},
    {"observe.discharge.direction", vector, "1", "", any, "", "Direction out, across that plane; default: that of gravity", ""},
    {"observe.discharge.interval", number, "s", "", positive, "", "Time between rows of discharge.csv; default: a five-hundredth of the duration", ""},
    {"observe.contact_history", flag, "", "false", any, "", "Write every contact (contacts.csv) and its force and overlap at each step (contact_history.csv); for at most 1000 particles", ""},
    {"observe.fragments", flag, "", "true", any, "", "Where grains are bonded: damage against time, the fragments at the end, every bond that failed", ""},
    {"observe.fragment_interval", number, "s", "", positive, "", "Time between rows of damage.csv; default: a thousandth of the duration", ""},
    {"observe.impact_direction", vector, "1", "", any, "", "Direction with which those of cracks are compared; default: that in which the bodies move at the start, else down", ""},
    {"observe.line.point", vector, "m", "", any, "", "A point of the line of the velocity profile; default: through the mill's centre, across the free surface", ""},
    {"observe.line.direction", vector, "1", "", any, "", "Direction of that line", ""},

    // What shows it: none of this acts on the motion
    {"instrument.clock_shift", number, "s", "0", any, "", "By which the clock of the recording is late: what it shows at t happened at t − shift", ""},
    {"instrument.<channel>.offset", number, "1", "0", any, "", "Added to what is shown, in the channel's SI unit. A channel is x, y, z, vx … wz, force or displacement, or one of position, velocity, spin for all three", ""},
    {"instrument.<channel>.gain", number, "1", "1", positive, "", "Factor of the scale", ""},
    {"instrument.<channel>.curvature", number, "1", "0", any, "", "Quadratic distortion of the scale: curvature × value² is added, in one over the channel's SI unit", ""},
    {"instrument.<channel>.lag", number, "s", "0", not_negative, "", "Time constant of a first-order lag", ""},
    {"instrument.<channel>.clock_shift", number, "s", "0", any, "", "By which the clock of this channel is late, beside that of the recording", ""},
    {"instrument.<channel>.saturation", number, "1", "", positive, "", "Greatest value shown, either way, in the channel's SI unit; default: none", ""},

    // A comparison with recordings (quern diagnose)
    {"diagnose.free", names, "", "", any, "", "Keys of the case that may be calibrated, such as \"pair.ball.plate.restitution\"; gravity.z names a component of a vector", ""},
    {"diagnose.initial_state", word, "", "\"recording\"", any, "recording case", "Trajectories begin with a place and velocity estimated from each run (and the spin, where it is recorded), or as the case and the conditions say", ""},
    {"diagnose.held_out", number, "1", "0.25", {0, 0.8}, "", "Part of the runs that is sealed for the last check, where the recording has no column held_out", ""},
    {"diagnose.bounds.<key>", numbers, "1", "", any, "", "[least, greatest] of a free key, in its SI unit; default: the key's range, within a factor ten of the case's value", ""},
};

bool is_placeholder(std::string_view segment) { return segment.starts_with('<'); }

// Levenshtein distance; exchanging two neighbours counts one.
int edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = static_cast<int>(i + j);
        continue;
      }
      const int change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

bool matches(const Path& pattern, const Path& path, bool prefix) {
  if (prefix ? path.size() >= pattern.size() : path.size() != pattern.size()) return false;
  for (std::size_t k = 0; k < path.size(); ++k)
    if (!is_placeholder(pattern[k]) && pattern[k] != path[k]) return false;
  return true;
}

const std::vector<Path>& patterns() {
  static const std::vector<Path> split = [] {
    std::vector<Path> all;
    for (const Key& key : table) all.push_back(split_path(key.path));
    return all;
  }();
  return split;
}

// [pair.default] and [bond.default] stand for two names.
Path expanded(const Path& path) {
  if (path.size() >= 2 && (path[0] == "pair" || path[0] == "bond") && path[1] == "default") {
    Path longer = path;
    longer.insert(longer.begin() + 2, "default");
    return longer;
  }
  return path;
}

// The pattern nearest to a path among those offered, with the path's own names in it.
struct Nearest {
  explicit Nearest(const Path& path) : full(expanded(path)) {}

  void offer(const Path& pattern, bool key) {
    int distance = 0;
    Path named = pattern;
    for (std::size_t k = 0; k < std::max(pattern.size(), full.size()); ++k) {
      if (k >= pattern.size() || k >= full.size()) distance += 4;
      else if (is_placeholder(pattern[k])) named[k] = full[k];
      else distance += edit_distance(pattern[k], full[k]);
    }
    // A key may have been written in the wrong table: its last word decides then.
    if (key && !is_placeholder(pattern.back())) distance = std::min(distance, 6 + 3 * edit_distance(pattern.back(), full.back()));
    // Or without the tables around it.
    if (key && full.size() >= 2 && pattern.size() > full.size() && std::equal(full.rbegin(), full.rend(), pattern.rbegin())) distance = std::min(distance, 1);
    if (distance >= least) return;
    least = distance;
    if (named.size() >= 3 && (named[0] == "pair" || named[0] == "bond") && named[1] == "default" && named[2] == "default") named.erase(named.begin() + 2);
    name = join_path(named);
  }

  Path full;
  int least = 1 << 20;
  std::string name;
};

}  // namespace

std::span<const Key> all_keys() { return table; }

Path split_path(std::string_view dotted) {
  Path path(1);
  for (const char c : dotted) {
    if (c == '.') path.emplace_back();
    else path.back() += c;
  }
  return path;
}

std::string join_path(const Path& path) { return fmt::format("{}", fmt::join(path, ".")); }

const Key* find_key(const Path& path) {
  const Path full = expanded(path);
  for (std::size_t k = 0; k < patterns().size(); ++k)
    if (matches(patterns()[k], full, false)) return &table[k];
  return nullptr;
}

bool is_table(const Path& path) {
  const Path full = expanded(path);
  return std::any_of(patterns().begin(), patterns().end(), [&](const Path& pattern) { return matches(pattern, full, true); });
}

std::string nearest_key(const Path& path) {
  Nearest nearest(path);
  for (const Path& pattern : patterns()) nearest.offer(pattern, true);
  return nearest.name;
}

std::string nearest_table(const Path& path) {
  Nearest nearest(path);
  for (const Path& pattern : patterns())
    for (std::size_t depth = 1; depth < pattern.size(); ++depth) nearest.offer(Path(pattern.begin(), pattern.begin() + static_cast<std::ptrdiff_t>(depth)), false);
  return nearest.name;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
  std::string best;
  int least = 1 + static_cast<int>(word.size()) / 2;
  for (const std::string& candidate : words) {
    const int distance = edit_distance(word, candidate);
    if (distance <= least) least = distance - 1, best = candidate;
  }
  return best;
}

std::vector<std::string> words_of(const Key& key) {
  std::istringstream stream(key.words);
  std::vector<std::string> words;
  for (std::string one; stream >> one;) words.push_back(one);
  return words;
}

std::string allowed_by(const Key& key) {
  const auto number_words = [&] {
    const std::string unit = std::string_view(key.unit) == "1" ? "" : fmt::format(" {}", key.unit);
    const Range& r = key.range;
    if (r.least == -no_bound && r.most == no_bound) return fmt::format("any finite number{}", unit.empty() ? "" : " in" + unit);
    if (r.most == no_bound) return fmt::format("{} {}{}", r.above_least ? "more than" : "at least", r.least, unit);
    return fmt::format("{} {} {} {}{}", r.above_least ? "more than" : "from", r.least, r.above_least ? "and at most" : "to", r.most, unit);
  };
  switch (key.kind) {
    case flag: return "true or false";
    case word: return fmt::format("one of {}", fmt::join(words_of(key), ", "));
    case text: return "a text";
    case name: return "a name";
    case names: return "a list of names";
    case file: return "the name of a file";
    case number: return number_words();
    case whole: return "a whole number " + number_words();
    case numbers: return "a list of numbers, each " + number_words();
    case wholes: return "a list of whole numbers, each " + number_words();
    case vector: return "three numbers [x, y, z], each " + number_words();
    case vectors: return "a list of [x, y, z], each number " + number_words();
  }
  return "";
}

}  // namespace quern
