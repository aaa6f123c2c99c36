#include "src/case/effects_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include "src/case/reading.hpp"

namespace quern {
namespace {

ForceTable read_table(const Values& v, const std::string& t) {
  ForceTable table;
  const bool given = v.has(t + ".extra_force");
  if (given != v.has(t + ".extra_force_at")) v.refuse(t + (given ? ".extra_force" : ".extra_force_at"), "extra_force and extra_force_at make a table together; allowed is both or neither");
  if (!given) return table;
  const std::string variable = v.text(t + ".extra_force_variable"), phase = v.text(t + ".extra_force_phase");
  table.variable = variable == "time" ? ForceTable::Variable::time : variable == "overlap" ? ForceTable::Variable::overlap : ForceTable::Variable::normal_velocity;
  table.phase = phase == "loading" ? ForceTable::Phase::loading : phase == "unloading" ? ForceTable::Phase::unloading : ForceTable::Phase::both;
  const std::vector<double> at = v.numbers(t + ".extra_force_at"), force = v.numbers(t + ".extra_force");
  if (at.empty() || at.size() > ForceTable::most_points) v.refuse(t + ".extra_force_at", fmt::format("found {} numbers; allowed are 1 to {}", at.size(), ForceTable::most_points));
  if (force.size() != at.size()) v.refuse(t + ".extra_force", fmt::format("found {} numbers; allowed are as many as extra_force_at, {}", force.size(), at.size()));
  if (std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) != at.end()) v.refuse(t + ".extra_force_at", "found numbers out of order; allowed are ascending ones");
  if (table.variable != ForceTable::Variable::normal_velocity && at[0] < 0)
    v.refuse(t + ".extra_force_at", fmt::format("found {}; allowed are numbers from 0 where the variable is the {}", at[0], variable));
  table.points = static_cast<int>(at.size());
  std::copy(at.begin(), at.end(), table.at);
  std::copy(force.begin(), force.end(), table.force);
  return table;
}

}  // namespace

void read_effects(const Values& v, const std::string& t, PairCase& pair) {
  const auto number = [&](const char* leaf) { return v.number(t + "." + leaf); };
  const auto needs_law = [&](const char* leaf, bool fits, const char* allowed) {
    if (!fits) v.refuse(t + "." + leaf, fmt::format("found with the law {}, which cannot have it; allowed are the laws {}", v.text(t + ".law"), allowed));
  };
  const bool hertzian = pair.law == LawKind::hertz_mindlin || pair.law == LawKind::deresiewicz;
  Extras& x = pair.effects;
  x.tangential_compliance = number("tangential_compliance");
  x.restitution.exponent = number("restitution_exponent");
  if (x.restitution.exponent != 0) needs_law("restitution_exponent", pair.law == LawKind::linear || pair.law == LawKind::hertz_mindlin, "linear and hertz_mindlin");
  x.viscoelastic_time = number("viscoelastic_time");
  pair.unloading_ratio = number("unloading_ratio");
  x.plastic.yield_pressure = v.number_if(t + ".yield_pressure").value_or(0);
  x.stiffening = {number("hardening"), number("stiffness_power"), number("reference_overlap"), number("powder_layers")};
  if (x.plastic.yield_pressure > 0) {
    needs_law("yield_pressure", hertzian, "hertz_mindlin and deresiewicz");
    if (pair.unloading_ratio > 1) v.refuse(t + ".yield_pressure", "found together with unloading_ratio; allowed is one of the two");
    if (x.stiffening.on()) v.refuse(t + ".yield_pressure", "found together with hardening or stiffness_power, with which the contact is not Hertz's; allowed is one of them");
  }
  x.table = read_table(v, t);
  x.adhesion.work = number("surface_energy");
  if (x.adhesion.work > 0) needs_law("surface_energy", hertzian, "hertz_mindlin and deresiewicz");
  x.wave_admittance = number("wave_admittance");
  x.torsion.coefficient = number("torsional_friction");
  x.lubrication.viscosity = number("film_viscosity");
  if (x.lubrication.viscosity > 0) {
    require(v, t, "film_thickness", "film_viscosity"), require(v, t, "film_cutoff", "film_viscosity");
    x.lubrication.thickness = number("film_thickness"), x.lubrication.cutoff = number("film_cutoff");
    if (x.lubrication.cutoff >= x.lubrication.thickness)
      v.refuse(t + ".film_cutoff", fmt::format("found {} m; allowed is less than film_thickness, {} m", x.lubrication.cutoff, x.lubrication.thickness));
  }
  x.bridge = {number("bridge_volume"), number("surface_tension"), number("wetting_angle")};
}

Extras extras_of(const PairCase& pair, const ContactLaw& law) {
  Extras x = pair.effects;
  const double exponent = std::visit([](const auto& chosen) { return chosen.exponent(); }, law) + x.stiffening.power_more;
  x.plastic.unloading_slope = pair.unloading_ratio == 1 ? 1 : std::pow(pair.unloading_ratio, 1 / exponent);
  const double young = std::holds_alternative<HertzMindlin>(law)  ? std::get<HertzMindlin>(law).effective_young
                       : std::holds_alternative<Deresiewicz>(law) ? std::get<Deresiewicz>(law).effective_young
                                                                  : 0;
  x.plastic.effective_young = x.adhesion.effective_young = young;
  x.restitution.mapping = pair.law == LawKind::linear ? SpeedRestitution::Mapping::linear : SpeedRestitution::Mapping::hertz;
  x.restitution.reference_speed = pair.reference_speed;
  x.restitution.restitution = pair.restitution.value_or(1);
  if (x.restitution.restitution == 1) x.restitution.exponent = 0;  // no loss at any speed
  return x;
}

}  // namespace quern
