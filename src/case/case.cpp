#include "src/case/case.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include "src/base/error.hpp"
#include "src/case/agglomerate_input.hpp"
#include "src/case/csv.hpp"
#include "src/case/echo.hpp"
#include "src/case/effects_input.hpp"
#include "src/case/medium_input.hpp"
#include "src/case/mill_input.hpp"
#include "src/case/reading.hpp"
#include "src/case/shape_input.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_names = 250;  // indices of materials and species are bytes, 255 means a wall

std::string default_name(const std::string& file) {
  const fs::path path = fs::absolute(file).lexically_normal();
  const std::string stem = path.stem().string();
  return stem == "case" && path.has_parent_path() ? path.parent_path().filename().string() : stem;
}

Material read_material(const Values& v, const std::string& name) {
  const std::string t = "material." + name;
  return {name, v.number(t + ".density"), v.number_if(t + ".young").value_or(0), v.number(t + ".poisson")};
}

PairCase read_pair(const Values& v, const std::string& a, const std::string& b, const std::vector<std::string>& materials, std::vector<std::string>& warnings) {
  const std::string t = a == "default" ? "pair.default" : "pair." + a + "." + b;
  PairCase pair;
  pair.a = a, pair.b = b;
  pair.where = v.where.at(split_path(t));
  for (const std::string& name : {a, b}) {
    if (a == "default" || std::find(materials.begin(), materials.end(), name) != materials.end()) continue;
    const std::string nearest = nearest_word(name, materials);
    v.refuse(t, fmt::format("found \"{}\", which is no material of this case; allowed is {}.{}", name, quoted_list(materials),
                            nearest.empty() ? "" : " Did you mean " + nearest + "?"));
  }
  const auto optional = [&](const char* leaf) { return v.number_if(t + "." + leaf); };
  const auto number = [&](const char* leaf) { return v.number(t + "." + leaf); };
  const std::string law = v.text(t + ".law");
  pair.law = law == "linear"        ? LawKind::linear
             : law == "deresiewicz" ? LawKind::deresiewicz
             : law == "power_law"   ? LawKind::power_law
             : law == "linearized"  ? LawKind::linearized
                                    : LawKind::hertz_mindlin;
  pair.restitution = optional("restitution");
  pair.friction = number("friction");
  pair.normal_stiffness = optional("normal_stiffness");
  pair.penetration_factor = optional("penetration_factor");
  pair.max_speed = optional("max_speed");
  pair.tangential_stiffness = optional("tangential_stiffness");
  pair.tangential_ratio = number("tangential_ratio");
  pair.normal_damping = optional("normal_damping");
  pair.stiffness_coefficient = optional("stiffness_coefficient");
  pair.stiffness_exponent = number("stiffness_exponent");
  pair.damping_coefficient = optional("damping_coefficient");
  pair.damping_exponent = number("damping_exponent");
  pair.impact_mass = optional("impact_mass");
  pair.impact_speed = optional("impact_speed");
  pair.reference_speed = number("reference_speed");
  pair.reference_diameter = optional("reference_diameter");
  const std::string rolling = v.text(t + ".rolling");
  pair.rolling.coefficient = number("rolling_friction");
  pair.rolling.damping_ratio = number("rolling_damping");
  pair.rolling.model = rolling == "none" || pair.rolling.coefficient == 0 ? RollingModel::none
                       : rolling == "constant_torque"                    ? RollingModel::constant_torque
                                                                         : RollingModel::elastic_plastic;

  const std::string why = "the law " + law;
  switch (pair.law) {
    case LawKind::linear:
      require(v, t, "restitution", why);
      if (pair.penetration_factor) require(v, t, "max_speed", "penetration_factor");
      else require(v, t, "normal_stiffness", why + " (or penetration_factor and max_speed)");
      if (pair.penetration_factor && pair.normal_stiffness) v.refuse(t + ".penetration_factor", "found together with normal_stiffness; allowed is one of the two");
      break;
    case LawKind::hertz_mindlin: require(v, t, "restitution", why); break;
    case LawKind::deresiewicz:
      require(v, t, "restitution", why);
      if (*pair.restitution < 1)
        warnings.push_back(fmt::format("{}: the deresiewicz law has the restitution {} at {} m/s (reference_speed) alone; it falls with speed.", t, *pair.restitution, pair.reference_speed));
      break;
    case LawKind::power_law:
      for (const char* leaf : {"stiffness_coefficient", "damping_coefficient", "impact_mass", "impact_speed"}) require(v, t, leaf, why);
      break;
    case LawKind::linearized:
      if (pair.stiffness_coefficient) {
        for (const char* leaf : {"damping_coefficient", "impact_mass", "impact_speed"}) require(v, t, leaf, why + " from stiffness_coefficient");
      } else {
        require(v, t, "normal_stiffness", why + " (or stiffness_coefficient and damping_coefficient)");
        require(v, t, "normal_damping", why);
      }
      break;
  }
  read_effects(v, t, pair);
  if (pair.restitution && (pair.law == LawKind::power_law || pair.law == LawKind::linearized))
    warnings.push_back(fmt::format("{}: the {} law takes its restitution from its damping; the restitution {} that is asked for is not used.", t, law, *pair.restitution));
  return pair;
}

SizeDistribution read_sizes(const Values& v, const std::string& t) {
  const auto has = [&](const char* leaf) { return v.has(t + "." + leaf); };
  const auto number = [&](const char* leaf) { return v.number(t + "." + leaf); };
  const auto need = [&](const char* leaf, const std::string& kind) { require(v, t, leaf, "sizes of kind " + kind); };
  std::string kind = has("diameters") ? "list" : has("median") ? "lognormal" : has("modulus") ? "rosin_rammler" : has("table") ? "table" : "mono";
  if (has("sizes")) kind = v.text(t + ".sizes");
  try {
    if (kind == "mono") {
      need("diameter", kind);
      return SizeDistribution::mono(number("diameter"));
    }
    if (kind == "list") {
      need("diameters", kind);
      if (has("counts") == has("mass_fractions")) v.refuse(t, "a list of diameters needs counts or mass_fractions, one of the two");
      const std::string amounts = has("counts") ? ".counts" : ".mass_fractions";
      const std::size_t found = v.numbers(t + amounts).size(), wanted = v.numbers(t + ".diameters").size();
      if (found != wanted) v.refuse(t + amounts, fmt::format("found {} numbers; allowed are as many as diameters, {}", found, wanted));
      return SizeDistribution::list(v.numbers(t + ".diameters"), v.numbers(t + amounts), has("counts") ? Weight::number : Weight::mass);
    }
    if (kind == "table") {
      need("table", kind);
      const std::string file = beside(v, t + ".table");
      const NumberTable table = read_numbers(file);
      if (table.columns.size() != 2) v.refuse(t + ".table", fmt::format("found {} columns in {}; allowed are two, diameter [m] and mass fraction finer [1]", table.columns.size(), file));
      return SizeDistribution::table(table.columns[0], table.columns[1]);
    }
    need("smallest", kind), need("largest", kind);
    if (kind == "lognormal") {
      need("median", kind), need("sigma", kind);
      return SizeDistribution::lognormal(number("median"), number("sigma"), v.text(t + ".weight") == "mass" ? Weight::mass : Weight::number, number("smallest"), number("largest"));
    }
    need("size", kind), need("modulus", kind);
    return SizeDistribution::rosin_rammler(number("size"), number("modulus"), number("smallest"), number("largest"));
  } catch (const InputError& e) {
    if (std::string_view(e.what()).find(t) != std::string_view::npos) throw;
    v.refuse(t, e.what());
  }
}

Motion read_motion(const Values& v, const std::string& t) {
  const std::string motion = v.text(t + ".motion");
  if (motion == "rotation") return turning(v.vector(t + ".centre"), direction(v, t + ".axis"), v.number(t + ".speed"), v.number(t + ".ramp"));
  if (motion == "translation") return Translating{v.vector(t + ".velocity"), v.number(t + ".ramp")};
  if (motion == "oscillation") return Oscillating{v.vector(t + ".amplitude"), v.number(t + ".frequency"), v.number(t + ".phase")};
  require(v, t, "times", "a motion by table"), require(v, t, "speeds", "a motion by table");
  const std::vector<double> times = v.numbers(t + ".times"), speeds = v.numbers(t + ".speeds");
  if (times.empty() || times.size() != speeds.size()) v.refuse(t + ".speeds", fmt::format("found {} numbers; allowed are as many as times, {}, and at least one", speeds.size(), times.size()));
  if (std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) != times.end()) v.refuse(t + ".times", "found instants out of order; allowed are ascending ones");
  return RotatingByTable{v.vector(t + ".centre"), direction(v, t + ".axis"), times, speeds};
}

// Frames with parents before their children. `carriers`: the mill's own frames.
std::vector<FrameCase> read_frames(const Values& v, const std::vector<std::string>& carriers) {
  std::vector<std::string> names = v.names("frame");
  const auto carries = [&](const std::string& name) { return std::find(carriers.begin(), carriers.end(), name) != carriers.end(); };
  for (const std::string& name : names)
    if (carries(name)) v.refuse("frame." + name, "found the name of the mill's own frame; allowed is any other");
  std::vector<std::string> parents = names;
  parents.insert(parents.end(), carriers.begin(), carriers.end());
  std::vector<FrameCase> ordered;
  std::vector<std::string> open;
  const std::function<void(const std::string&)> visit = [&](const std::string& name) {
    if (std::any_of(ordered.begin(), ordered.end(), [&](const FrameCase& f) { return f.name == name; })) return;
    const std::string t = "frame." + name;
    if (std::find(open.begin(), open.end(), name) != open.end()) v.refuse(t + ".parent", "found a frame that moves in itself; allowed is a parent that does not move in its child");
    open.push_back(name);
    FrameCase frame{name, "", read_motion(v, t)};
    if (v.has(t + ".parent")) {
      index_of(v, t + ".parent", parents, "frame");
      frame.parent = v.text(t + ".parent");
      if (!carries(frame.parent)) visit(frame.parent);
    }
    open.pop_back();
    ordered.push_back(frame);
  };
  for (const std::string& name : names) visit(name);
  return ordered;
}

WallCase read_wall(const Values& v, const std::string& name, const std::vector<std::string>& materials, const std::vector<std::string>& frames) {
  const std::string t = "wall." + name, type = v.text(t + ".type");
  WallCase wall;
  wall.name = name;
  wall.where = v.where.at(split_path(t));
  wall.type = type == "plane"      ? WallCase::Type::plane
              : type == "cylinder" ? WallCase::Type::cylinder
              : type == "cone"     ? WallCase::Type::cone
              : type == "disc"     ? WallCase::Type::disc
                                   : WallCase::Type::mesh;
  wall.material = index_of(v, t + ".material", materials, "material");
  if (v.has(t + ".frame")) index_of(v, t + ".frame", frames, "frame"), wall.frame = v.text(t + ".frame");
  wall.point = v.vector(t + ".point");
  wall.axis = direction(v, t + ".axis");
  const auto need = [&](const char* leaf) { require(v, t, leaf, "a wall of type " + type); };
  if (type == "cylinder" || type == "cone" || type == "disc") need("radius");
  if (type == "cylinder" || type == "cone") need("length");
  if (type == "cone") need("end_radius");
  if (type == "mesh") need("file");
  wall.radius = v.number_if(t + ".radius").value_or(0);
  wall.end_radius = type == "cone" ? v.number(t + ".end_radius") : wall.radius;
  wall.inner_radius = v.number(t + ".inner_radius");
  wall.length = v.number_if(t + ".length").value_or(0);
  if (type == "disc" && wall.inner_radius >= wall.radius) v.refuse(t + ".inner_radius", fmt::format("found {} m; allowed is less than the radius, {} m", wall.inner_radius, wall.radius));
  const std::string side = v.text(t + ".side");
  wall.side = side == "inside" ? Revolved::Side::inside : side == "outside" ? Revolved::Side::outside : Revolved::Side::both;
  if (type == "mesh") wall.file = beside(v, t + ".file");
  wall.scale = v.number(t + ".scale");
  wall.open = v.flag(t + ".open");
  return wall;
}

InsertCase read_insert(const Values& v, const std::string& name, const Case& c, bool mill) {
  const std::string t = "insert." + name;
  InsertCase insert;
  insert.name = name;
  insert.where = v.where.at(split_path(t));
  if (v.has(t + ".species") == v.has(t + ".agglomerate")) v.refuse(t, "an insertion needs a species or an agglomerate, one of the two");
  if (v.has(t + ".species")) insert.species = index_of(v, t + ".species", names_of(c.species), "species");
  else insert.agglomerate = index_of(v, t + ".agglomerate", names_of(c.agglomerates), "agglomerate");
  insert.turn = v.vector(t + ".turn");
  insert.velocity = v.vector(t + ".velocity");
  if (const auto speed = v.number_if(t + ".speed")) {
    if (insert.velocity.norm() == 0) v.refuse(t + ".speed", "a direction is missing; `velocity` gives it, such as velocity = [0, 0, -1]");
    insert.velocity *= *speed / insert.velocity.norm();
  }
  insert.spin = v.vector(t + ".spin");
  const bool listed = v.has(t + ".positions") || v.has(t + ".file");
  const std::string method = v.has(t + ".method") ? v.text(t + ".method") : listed ? "list" : "packing";
  insert.method = method == "list" ? InsertCase::Method::list : method == "rain" ? InsertCase::Method::rain : InsertCase::Method::packing;
  if (insert.method == InsertCase::Method::list) {
    if (v.has(t + ".positions") == v.has(t + ".file")) v.refuse(t, "the method list needs positions or a file, one of the two");
    if (v.has(t + ".positions")) {
      for (const Vec3& position : v.vectors(t + ".positions")) insert.balls.push_back({position, insert.velocity, insert.spin, 0});
    } else {
      const std::string file = beside(v, t + ".file");
      const NumberTable table = read_numbers(file);
      for (const std::string& column : table.names) {
        const std::vector<std::string> known = {"x", "y", "z", "diameter", "vx", "vy", "vz", "wx", "wy", "wz"};
        if (std::find(known.begin(), known.end(), column) == known.end())
          v.refuse(t + ".file", fmt::format("found the column \"{}\" in {}; allowed are {}", column, file, fmt::join(known, ", ")));
      }
      for (const char* column : {"x", "y", "z"})
        if (!table.find(column)) v.refuse(t + ".file", fmt::format("the column {} [m] is missing in {}", column, file));
      for (std::size_t row = 0; row < table.columns[0].size(); ++row) {
        const auto cell = [&](const char* column, double otherwise) { return table.find(column) ? (*table.find(column))[row] : otherwise; };
        insert.balls.push_back({{cell("x", 0), cell("y", 0), cell("z", 0)},
                                {cell("vx", insert.velocity.x()), cell("vy", insert.velocity.y()), cell("vz", insert.velocity.z())},
                                {cell("wx", insert.spin.x()), cell("wy", insert.spin.y()), cell("wz", insert.spin.z())},
                                cell("diameter", 0)});
        if (table.find("diameter") && !(insert.balls.back().diameter > 0)) v.refuse(t + ".file", fmt::format("found the diameter {} in {}; allowed is more than 0 m", insert.balls.back().diameter, file));
      }
    }
    insert.allowed_overlap = v.number(t + ".allowed_overlap");
    if (insert.balls.empty()) v.refuse(t + ".positions", "found no position; allowed is at least one");
    return insert;
  }
  const int amounts = v.has(t + ".count") + v.has(t + ".mass") + v.has(t + ".filling");
  if (amounts > 1) v.refuse(t, "count, mass and filling exclude each other; found more than one of them");
  if (amounts == 0 && !v.has("mill.filling")) v.refuse(t, "an amount is missing; allowed is one of count, mass and filling (or mill.filling)");
  insert.count = v.has(t + ".count") ? v.whole(t + ".count") : 0;
  insert.mass = v.number_if(t + ".mass").value_or(0);
  insert.filling = v.has(t + ".filling") ? v.number(t + ".filling") : amounts == 0 ? v.number("mill.filling") : 0;
  const std::string shape = v.text(t + ".region.shape");
  insert.shape = shape == "box" ? InsertCase::Shape::box : shape == "cylinder" ? InsertCase::Shape::cylinder : shape == "sphere" ? InsertCase::Shape::sphere : InsertCase::Shape::mill;
  if (shape == "mill" && !mill) v.refuse(t + ".region.shape", "found mill, but the case has no [mill]; allowed is box, cylinder or sphere");
  const auto need = [&](const char* leaf) { require(v, t + ".region", leaf, "a region of shape " + shape); };
  if (shape == "box") need("size"), insert.size = v.vector(t + ".region.size");
  if (shape == "cylinder" || shape == "sphere") need("radius"), insert.radius = v.number(t + ".region.radius");
  if (shape == "cylinder") need("length"), insert.length = v.number(t + ".region.length");
  if (shape != "mill") insert.centre = v.vector(t + ".region.centre"), insert.axis = direction(v, t + ".region.axis");
  return insert;
}

ObserverSettings read_observers(const Values& v, Case& c) {
  ObserverSettings o;
  o.start_time = v.number_if("observe.start").value_or(-1);
  if (o.start_time >= c.duration) v.refuse("observe.start", fmt::format("found {} s; allowed is less than the duration, {} s", o.start_time, c.duration));
  o.power = v.flag("observe.power");
  o.power_interval = v.number("observe.power_interval");
  o.shell_force = v.flag("observe.shell_force");
  o.force_interval = v.number("observe.force_interval");
  const std::vector<double> band = v.numbers("observe.band");
  if (band.size() != 2 || !(band[0] < band[1])) v.refuse("observe.band", "allowed are two ascending frequencies [from, to]");
  o.band_from = band[0], o.band_to = band[1];
  o.spectrum = v.flag("observe.spectrum");
  o.bins_per_decade = static_cast<int>(v.whole("observe.bins_per_decade"));
  o.long_contact = v.number("observe.long_contact");
  o.convergence_interval = v.number_if("observe.convergence_interval").value_or(c.duration / 200);
  o.stop_at_interval = v.number_if("observe.stop_at_interval").value_or(0);
  o.stop_at_bin_interval = v.number_if("observe.stop_at_bin_interval").value_or(0);
  for (const char* key : {"observe.stop_at_interval", "observe.stop_at_bin_interval"})
    if (v.has(key) && !o.spectrum) v.refuse(key, "found with observe.spectrum = false; allowed is to leave it out, or to count collisions");
  o.charge = v.flag("observe.charge");
  o.charge_interval = v.number("observe.charge_interval");
  o.angle_cells = static_cast<int>(v.whole("observe.angle_cells"));
  o.radius_cells = static_cast<int>(v.whole("observe.radius_cells"));
  if (v.has("observe.line.point") || v.has("observe.line.direction")) {
    require(v, "observe.line", "point", "a line"), require(v, "observe.line", "direction", "a line");
    o.velocity_line = ProfileLine{v.vector("observe.line.point"), direction(v, "observe.line.direction")};
  }
  if (v.has("observe.track"))
    for (const double id : v.numbers("observe.track")) o.track.push_back(static_cast<int>(id));
  o.track_interval = v.number("observe.track_interval");
  if (o.track_interval == 0) o.track_interval = 1e-3 * c.duration;
  if (v.flag("observe.signal")) o.signal = c.instrument;
  o.contact_history = v.flag("observe.contact_history");
  o.fragments = v.flag("observe.fragments");
  o.fragment_interval = v.number_if("observe.fragment_interval").value_or(c.duration / 1000);
  if (v.has("observe.impact_direction")) o.impact_direction = direction(v, "observe.impact_direction");
  if (v.has("observe.loading")) c.loading_walls = v.texts("observe.loading");
  for (const char* key : {"observe.loading_interval", "observe.strain", "observe.gauges"})
    if (v.has(key) && (key != std::string_view("observe.strain") || v.flag(key))) require(v, "observe", "loading", key);
  o.loading_interval = v.number_if("observe.loading_interval").value_or(c.duration / 500);
  o.strain = v.flag("observe.strain");
  if (v.has("observe.gauges")) o.gauges = v.vectors("observe.gauges");
  if (v.has("observe.discharge.point")) {
    const bool told = v.has("observe.discharge.direction");
    if (!told && c.gravity.isZero(0)) v.refuse("observe.discharge", "found no gravity and no direction; allowed is a direction out");
    o.discharge = OutletPlane{v.vector("observe.discharge.point"), told ? direction(v, "observe.discharge.direction") : c.gravity.normalized().eval()};
  }
  for (const char* key : {"observe.discharge.direction", "observe.discharge.interval"})
    if (v.has(key)) require(v, "observe.discharge", "point", key);
  o.discharge_interval = v.number_if("observe.discharge.interval").value_or(c.duration / 500);
  if (v.has("observe.driven_walls")) c.driven_walls = v.texts("observe.driven_walls");
  return o;
}

InstrumentSettings read_instrument(const Values& v) {
  InstrumentSettings settings;
  settings.clock_shift = v.number("instrument.clock_shift");
  const std::vector<std::string> targets = {"x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "force", "displacement", "position", "velocity", "spin"};
  for (const std::string& name : v.names("instrument")) {
    const std::string t = "instrument." + name;
    if (std::find(targets.begin(), targets.end(), name) == targets.end()) v.refuse(t, fmt::format("found \"{}\", which is no channel; allowed is {}", name, quoted_list(targets)));
    Instrument one{v.number(t + ".offset"), v.number(t + ".gain"), v.number(t + ".curvature"), v.number(t + ".lag"), v.number(t + ".clock_shift")};
    if (const auto most = v.number_if(t + ".saturation")) one.saturation = *most;
    settings.channels.push_back({name, one});
  }
  return settings;
}

}  // namespace

Case case_of(const Values& v) {
  const std::string& file = v.file;
  Case c;
  c.file = file;
  c.name = v.has("name") ? v.text("name") : default_name(file);
  if (c.name.empty() || c.name.find('/') != c.name.npos || c.name == "." || c.name == "..") v.refuse("name", fmt::format("found \"{}\"; allowed is a name for a folder, without /", c.name));
  c.title = v.text("title");
  c.duration = v.number("duration");
  c.seed = static_cast<std::uint64_t>(v.whole("seed"));
  c.gravity = v.vector("gravity");
  c.time_step = v.number_if("time_step.value");
  c.time_step_where = c.time_step ? v.given.at({"time_step", "value"}).where : file;
  c.time_step_fraction = v.number("time_step.fraction");
  c.unsafe_time_step = v.flag("time_step.unsafe");

  const std::vector<std::string> materials = v.names("material");
  if (materials.empty()) v.refuse("", "the case has no material; at least one [material.<name>] is needed");
  if (materials.size() > most_names) v.refuse("", fmt::format("found {} materials; allowed are at most {}", materials.size(), most_names));
  for (const std::string& name : materials) {
    if (name == "default") v.refuse("material.default", "found the name default, which pairs use; allowed is any other");
    c.materials.push_back(read_material(v, name));
  }
  for (const std::string& a : v.names("pair")) {
    if (a == "default") c.pairs.push_back(read_pair(v, "default", "default", materials, c.warnings));
    else
      for (const std::string& b : v.names("pair." + a)) c.pairs.push_back(read_pair(v, a, b, materials, c.warnings));
  }
  const std::vector<std::string> species = v.names("species");
  if (species.size() > most_names) v.refuse("", fmt::format("found {} species; allowed are at most {}", species.size(), most_names));
  for (const std::string& name : species) {
    const std::string t = "species." + name;
    const std::uint8_t material = index_of(v, t + ".material", materials, "material");
    const std::optional<Superquadric> shape = read_shape(v, t);
    const bool told = !shape || has_sizes(v, t);
    SizeDistribution sizes = told ? read_sizes(v, t) : SizeDistribution::mono(2 * shape->bounding_radius);
    if (shape && told)
      for (double& diameter : sizes.diameter) diameter = held_by(*shape, diameter);
    c.species.push_back({name, material, v.number_if(t + ".density").value_or(c.materials[material].density),
                         sizes, shape});
  }

  read_agglomerates(v, c);
  refuse_shaped_grains(v, c);
  read_mill(v, materials, c);
  read_medium(v, c);
  read_forces(v, c);
  const bool has_mill = v.has_table("mill");
  const std::vector<std::string> carriers = mill_frames(c);
  c.frames = read_frames(v, carriers);
  std::vector<std::string> frames = names_of(c.frames);
  frames.insert(frames.end(), carriers.begin(), carriers.end());
  for (const std::string& name : v.names("wall")) c.walls.push_back(read_wall(v, name, materials, frames));
  for (const std::string& name : v.names("insert")) c.inserts.push_back(read_insert(v, name, c, has_mill));
  if (c.inserts.empty()) v.refuse("", "the case inserts nothing; at least one [insert.<name>] is needed");

  double largest = 0;
  for (const InsertCase& insert : c.inserts) {
    if (insert.agglomerate) {
      const AgglomerateCase& body = c.agglomerates[*insert.agglomerate];
      for (const GrainPortion& portion : body.request.portions) largest = std::max(largest, portion.sizes.largest());
      for (const Grain& grain : body.grains) largest = std::max(largest, grain.diameter);
      continue;
    }
    largest = std::max(largest, c.species[insert.species].sizes.largest());
    for (const InsertCase::Ball& ball : insert.balls) largest = std::max(largest, ball.diameter);
  }
  finish_mill(v, largest, c);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string key = std::string("periodic.") + "xyz"[axis];
    if (!v.has(key)) continue;
    const std::vector<double> ends = v.numbers(key);
    if (ends.size() != 2 || !(ends[0] < ends[1])) v.refuse(key, "allowed are two ascending places [from, to]");
    c.domain.lower[axis] = ends[0], c.domain.period[axis] = ends[1] - ends[0];
  }
  for (int axis = 0; axis < 3; ++axis)
    if (c.domain.period[axis] > 0 && c.domain.period[axis] < 2.5 * largest)
      v.refuse(v.has(std::string("periodic.") + "xyz"[axis]) ? std::string("periodic.") + "xyz"[axis] : "mill.length",
               fmt::format("found a period of {} m; allowed is at least 2.5 times the largest diameter, {} m", c.domain.period[axis], 2.5 * largest));

  if (v.has("output.stages")) {
    c.output.stages = v.numbers("output.stages");
    if (!std::is_sorted(c.output.stages.begin(), c.output.stages.end())) v.refuse("output.stages", "allowed are ascending times");
  }
  c.output = {v.number("output.frames"), v.number("output.energy"), v.flag("output.paraview"), v.flag("output.trajectory"), v.flag("output.pictures"), std::move(c.output.stages)};
  c.instrument = read_instrument(v);
  c.observe = read_observers(v, c);
  c.observe.drive = {v.number("mill.bearing_torque"), v.number("mill.gear_loss")};

  return c;
}

Case read_case(const std::string& file, const std::vector<std::string>& overrides) { return named_case_of(read_values(file, overrides)); }

Case named_case_of(Values v) {
  Case c = case_of(v);
  // The echo stands elsewhere: it names itself.
  if (!v.has("name")) v.given[{"name"}] = Value{c.name, find_key({"name"}), v.file};
  c.text = echo_of(std::move(v), c.files);
  return c;
}

}  // namespace quern
