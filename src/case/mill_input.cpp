#include "src/case/mill_input.hpp"
#include <fmt/format.h>
#include "src/base/error.hpp"
#include "src/case/reading.hpp"

namespace quern {
namespace {

// The mill's keys that only another kind of mill has (those with a default stand in every complete case).
void refuse_keys_of_others(const Values& v, const std::string& type) {
  struct Own {
    const char *key, *type;
  };
  constexpr Own keys[] = {{"mill.speed_fraction", "tumbling"},   {"mill.length_ratio", "tumbling"},    {"mill.lifters.height", "tumbling"},
                          {"mill.lifters.width", "tumbling"},    {"mill.campaign_time", "tumbling"},   {"mill.disc_diameter", "planetary"},  {"mill.speed_ratio", "planetary"},
                          {"mill.vial_file", "planetary"},       {"mill.shaft.diameter", "stirred"},   {"mill.discs.diameter", "stirred"},
                          {"mill.discs.thickness", "stirred"},   {"mill.discs.spacing", "stirred"},    {"mill.discs.hole_diameter", "stirred"},
                          {"mill.discs.hole_circle", "stirred"}, {"mill.pins.diameter", "stirred"},    {"mill.pins.tip_circle", "stirred"},
                          {"mill.pins.spacing", "stirred"},      {"mill.pins.twist", "stirred"}, {"mill.discs.first", "stirred"}, {"mill.pins.first", "stirred"},       {"mill.stirrer_file", "stirred"},
                          {"mill.stirrer_material", "stirred"},  {"mill.vessel_file", "stirred"}};
  for (const auto& [key, owner] : keys)
    if (type != owner && v.has(key)) v.refuse(key, fmt::format("a {} mill has none; allowed is to leave it out", type));
  for (const char* key : {"mill.bearing_torque", "mill.gear_loss"})
    if (type == "planetary" && v.has(key)) v.refuse(key, "the two drives of a planetary mill are without losses here; allowed is to leave it out");
}

// What wear leaves of the lifters.
double worn_height(const Values& v) {
  const double height = v.number("mill.lifters.height");
  const double worn = v.number("mill.lifters.wear") + v.number("mill.lifters.wear_rate") * v.number("mill.campaign_time");
  constexpr double least = 0.02;  // of its height must be left of a lifter
  if (worn > (1 - least) * height) v.refuse("mill.lifters.height", fmt::format("found {:g} m, of which {:g} m are worn off; allowed is to wear at most {:g} % off", height, worn, 100 * (1 - least)));
  return height - worn;
}

// What every kind of mill has.
template <class Mill>
void read_place(const Values& v, Mill& mill) {
  mill.ramp = v.number("mill.ramp");
  mill.centre = v.vector("mill.centre");
  if (v.has("mill.axis")) mill.axis = direction(v, "mill.axis");
}

std::uint8_t read_material(const Values& v, const std::vector<std::string>& materials) {
  if (v.has("mill.material")) return index_of(v, "mill.material", materials, "material");
  if (materials.size() > 1) v.refuse("mill.material", "this is missing; allowed is " + quoted_list(materials));
  return 0;
}

MeshFile read_mesh(const Values& v, const std::string& key) {
  if (!v.has("mill." + key + "_file")) return {};
  return {beside(v, "mill." + key + "_file"), v.number("mill." + key + "_scale")};
}

template <class Mill>
void check_mill(const Values& v, const Mill& mill) {
  try {
    check(mill);
  } catch (const InputError& e) {
    v.refuse("mill", e.what());
  }
}

TumblingMill read_tumbling(const Values& v, const std::vector<std::string>& materials) {
  TumblingMill mill;
  require(v, "mill", "diameter", "a mill");
  if (v.has("mill.length") == v.has("mill.length_ratio")) v.refuse("mill", "a mill needs length or length_ratio, one of the two");
  if (v.has("mill.speed") == v.has("mill.speed_fraction")) v.refuse("mill", "a mill needs speed or speed_fraction, one of the two");
  mill.diameter = v.number("mill.diameter");
  mill.length = v.has("mill.length") ? v.number("mill.length") : v.number("mill.length_ratio") * mill.diameter;
  read_place(v, mill);
  mill.ends = v.text("mill.ends") == "periodic" ? TumblingMill::Ends::periodic : TumblingMill::Ends::walls;
  mill.material = read_material(v, materials);
  mill.lifters.count = static_cast<int>(v.whole("mill.lifters.count"));
  if (mill.lifters.count > 0) {
    require(v, "mill.lifters", "height", "lifters"), require(v, "mill.lifters", "width", "lifters");
    mill.lifters.height = worn_height(v);
    mill.lifters.width = v.number("mill.lifters.width");
    mill.lifters.face_angle = v.number("mill.lifters.face_angle");
    const std::string shape = v.text("mill.lifters.shape");
    mill.lifters.shape = shape == "trapezoid" ? Lifters::Shape::trapezoid : shape == "bar" ? Lifters::Shape::bar : Lifters::Shape::rectangular;
  }
  return mill;
}

PlanetaryMill read_planetary(const Values& v, const std::vector<std::string>& materials) {
  PlanetaryMill mill;
  for (const char* leaf : {"disc_diameter", "diameter", "length", "speed", "speed_ratio"}) require(v, "mill", leaf, "a planetary mill");
  mill.disc_diameter = v.number("mill.disc_diameter");
  mill.vial_diameter = v.number("mill.diameter");
  mill.vial_length = v.number("mill.length");
  mill.vials = static_cast<int>(v.whole("mill.vials"));
  mill.speed = v.number("mill.speed");
  mill.ratio = v.number("mill.speed_ratio");
  mill.ratio_to = v.text("mill.speed_ratio_to") == "fixed" ? PlanetaryMill::RatioTo::fixed : PlanetaryMill::RatioTo::disc;
  mill.tilt = v.number("mill.vial_tilt");
  read_place(v, mill);
  mill.axes = v.text("mill.axes") == "disc" ? PlanetaryMill::Axes::disc : PlanetaryMill::Axes::fixed;
  mill.material = read_material(v, materials);
  check_mill(v, mill);
  return mill;
}

StirrerDiscs read_discs(const Values& v) {
  StirrerDiscs discs;
  discs.count = static_cast<int>(v.whole("mill.discs.count"));
  if (discs.count == 0) return discs;
  require(v, "mill.discs", "diameter", "discs"), require(v, "mill.discs", "thickness", "discs");
  discs.diameter = v.number("mill.discs.diameter");
  discs.thickness = v.number("mill.discs.thickness");
  discs.spacing = v.number_if("mill.discs.spacing").value_or(0);
  discs.first = v.number_if("mill.discs.first").value_or(0);
  discs.holes = static_cast<int>(v.whole("mill.discs.holes"));
  if (discs.holes == 0) return discs;
  require(v, "mill.discs", "hole_diameter", "holes"), require(v, "mill.discs", "hole_circle", "holes");
  discs.hole_diameter = v.number("mill.discs.hole_diameter");
  discs.hole_circle = v.number("mill.discs.hole_circle");
  return discs;
}

StirrerPins read_pins(const Values& v) {
  StirrerPins pins;
  pins.rows = static_cast<int>(v.whole("mill.pins.rows"));
  if (pins.rows == 0) return pins;
  require(v, "mill.pins", "diameter", "pins"), require(v, "mill.pins", "tip_circle", "pins");
  pins.per_row = static_cast<int>(v.whole("mill.pins.per_row"));
  pins.diameter = v.number("mill.pins.diameter");
  pins.tip_circle = v.number("mill.pins.tip_circle");
  pins.spacing = v.number_if("mill.pins.spacing").value_or(0);
  pins.first = v.number_if("mill.pins.first").value_or(0);
  pins.twist = v.number_if("mill.pins.twist").value_or(-1);
  return pins;
}

StirredMill read_stirred(const Values& v, const std::vector<std::string>& materials) {
  StirredMill mill;
  for (const char* leaf : {"diameter", "length", "speed"}) require(v, "mill", leaf, "a stirred mill");
  mill.diameter = v.number("mill.diameter");
  mill.length = v.number("mill.length");
  mill.speed = v.number("mill.speed");
  read_place(v, mill);
  mill.vessel_material = mill.stirrer_material = read_material(v, materials);
  if (v.has("mill.stirrer_material")) mill.stirrer_material = index_of(v, "mill.stirrer_material", materials, "material");
  if (v.has("mill.stirrer_file")) {
    for (const char* key : {"mill.shaft.diameter", "mill.discs.diameter", "mill.pins.diameter"})
      if (v.has(key)) v.refuse(key, "found together with mill.stirrer_file; allowed is one of the two");
    return mill;  // checked when the file is read
  }
  require(v, "mill.shaft", "diameter", "a stirred mill (or mill.stirrer_file)");
  mill.shaft_diameter = v.number("mill.shaft.diameter");
  mill.clearance = v.number("mill.shaft.clearance");
  mill.discs = read_discs(v);
  mill.pins = read_pins(v);
  check_mill(v, mill);
  return mill;
}

}  // namespace

void read_mill(const Values& v, const std::vector<std::string>& materials, Case& c) {
  if (!v.has_table("mill")) return;
  const std::string type = v.text("mill.type");
  refuse_keys_of_others(v, type);
  if (type == "planetary") {
    c.planetary = read_planetary(v, materials);
    c.vial_file = read_mesh(v, "vial");
  } else if (type == "stirred") {
    c.stirred = read_stirred(v, materials);
    c.stirrer_file = read_mesh(v, "stirrer");
    c.vessel_file = read_mesh(v, "vessel");
  } else {
    c.mill = read_tumbling(v, materials);
  }
}

std::vector<std::string> mill_frames(const Case& c) {
  if (c.planetary) return names_of(frames_of(*c.planetary));
  if (c.stirred) return {"stirrer"};
  if (c.mill) return {c.mill->name};
  return {};
}

void finish_mill(const Values& v, double largest_diameter, Case& c) {
  try {
    if (c.mill) {
      c.critical_speed = critical_speed(c.mill->diameter, largest_diameter, c.gravity.norm());
      if (const auto fraction = v.number_if("mill.speed_fraction")) c.mill->speed = *fraction * c.critical_speed;
      else c.mill->speed = v.number("mill.speed");
      check(*c.mill);
      c.domain = domain_of(*c.mill);
    }
    if (c.planetary) c.critical_speed = critical_ratio(*c.planetary, largest_diameter) * std::abs(c.planetary->speed);
  } catch (const InputError& e) {
    v.refuse("mill", e.what());
  }
}

}  // namespace quern
