#include "src/case/medium_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include "src/case/reading.hpp"

namespace quern {
namespace {

// The forces see velocities in the axes of the motion; the fluid is at rest in the fixed frame.
void refuse_in_turning_axes(const Values& v, const Case& c, const std::string& key) {
  if (c.planetary && c.planetary->axes == PlanetaryMill::Axes::disc) v.refuse(key, "found with mill.axes = \"disc\"; allowed is mill.axes = \"fixed\"");
}

TableForce read_force(const Values& v, const std::string& name) {
  using enum TableForce::Variable;
  const std::string t = "force." + name;
  TableForce force;
  force.title = name;
  // In the order of the words in the table of keys.
  constexpr TableForce::Variable variables[] = {speed, x, y, z, vx, vy, vz, spin, time};
  constexpr TableForce::Direction directions[] = {TableForce::Direction::against_velocity, TableForce::Direction::x, TableForce::Direction::y, TableForce::Direction::z,
                                                  TableForce::Direction::lift, TableForce::Direction::against_spin};
  const auto place_of = [&](const std::string& key) {
    const std::vector<std::string> words = words_of(*find_key(split_path(key)));
    return static_cast<std::size_t>(std::find(words.begin(), words.end(), v.text(key)) - words.begin());
  };
  force.variable = variables[place_of(t + ".variable")];
  force.direction = directions[place_of(t + ".direction")];
  force.points = v.numbers(t + ".at");
  force.values = v.numbers(t + ".values");
  if (force.points.size() < 2) v.refuse(t + ".at", fmt::format("found {} number{}; allowed are at least two", force.points.size(), force.points.size() == 1 ? "" : "s"));
  if (std::adjacent_find(force.points.begin(), force.points.end(), std::greater_equal<>()) != force.points.end()) v.refuse(t + ".at", "found numbers out of order; allowed are ascending ones");
  if (force.values.size() != force.points.size()) v.refuse(t + ".values", fmt::format("found {} numbers; allowed are as many as in at, {}", force.values.size(), force.points.size()));
  return force;
}

}  // namespace

void read_medium(const Values& v, Case& c) {
  const double density = v.number("medium.density"), drag = v.number("medium.drag_coefficient"), viscous = v.number("medium.viscous_drag"),
               buoyancy = v.number("medium.buoyancy"), magnus = v.number("medium.magnus_coefficient");
  c.carried_density = v.number("medium.added_mass_coefficient") * density;
  for (const char* key : {"medium.drag_coefficient", "medium.viscous_drag", "medium.buoyancy", "medium.added_mass_coefficient", "medium.magnus_coefficient"})
    if (v.number(key) != 0) refuse_in_turning_axes(v, c, key);
  const bool curve = v.text("medium.drag") == "schiller_naumann";
  if (curve) require(v, "medium", "drag_coefficient", "drag = \"schiller_naumann\" (1: a smooth sphere)");
  if (drag > 0 && curve) c.fields.push_back(SphereDrag{drag, density, v.number("medium.viscosity")});
  if (drag > 0 && !curve) c.fields.push_back(AirDrag{drag, density});
  if (viscous > 0) c.fields.push_back(ViscousDrag{viscous});
  if (buoyancy > 0) c.fields.push_back(Buoyancy{buoyancy, c.gravity});
  if (magnus != 0) c.fields.push_back(Magnus{magnus, density});
}

void read_forces(const Values& v, Case& c) {
  for (const std::string& name : v.names("force")) {
    refuse_in_turning_axes(v, c, "force." + name);
    c.fields.push_back(read_force(v, name));
  }
}

}  // namespace quern
