#include "src/case/build.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/effects_input.hpp"
#include "src/case/insertion.hpp"
#include "src/case/reading.hpp"
#include "src/case/shape_input.hpp"
#include "src/contact/linearize.hpp"
#include "src/contact/restitution.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "src/wall/stl.hpp"

namespace quern {
namespace {

std::string key_of(const PairCase& pair) { return pair.a == "default" ? "pair.default" : "pair." + pair.a + "." + pair.b; }

Wall wall_of(const WallCase& w, Index frame, const Pose& carrier) {
  Wall wall;
  wall.name = w.name;
  wall.material = w.material;
  wall.frame = frame;
  wall.rest.origin = w.point;
  wall.rest.axes = axes_with_z(w.axis);
  wall.pose = frame < 0 ? wall.rest : carried(carrier, wall.rest);
  switch (w.type) {
    case WallCase::Type::plane: wall.surface = Plane{}; break;
    case WallCase::Type::cylinder:
    case WallCase::Type::cone: wall.surface = Revolved{w.radius, -0.5 * w.length, w.end_radius, 0.5 * w.length, w.side}; break;
    case WallCase::Type::disc: wall.surface = Revolved{w.inner_radius, 0, w.radius, 0, Revolved::Side::both}; break;
    case WallCase::Type::mesh:
      try {
        StlReport report;
        wall.surface = read_stl(w.file, w.scale, report);
        if (!report.closed && !w.open)
          refuse(w.where, "wall." + w.name + ".file", fmt::format("found an open surface with {} open edges in {}; allowed is a closed one, or open = true", report.open_edges, w.file));
      } catch (const InputError& e) {
        const std::string what = e.what();
        if (what.starts_with(w.where)) throw;
        refuse(w.where, "wall." + w.name + ".file", what);
      }
      break;
  }
  return wall;
}

struct Largest {
  double diameter = 0, mass = 0;
  Index count = 0;
};

// The greatest particle of each material.
std::vector<Largest> largest_of(const Simulation& s) {
  std::vector<Largest> largest(s.materials.size());
  for (Index i = 0; i < s.particles.owned; ++i) {
    Largest& one = largest[s.particles.material[static_cast<std::size_t>(i)]];
    if (2 * s.particles.radius(i) > one.diameter) one.diameter = 2 * s.particles.radius(i), one.mass = s.particles.mass(i);
    ++one.count;
  }
  return largest;
}

void make_laws(const Case& c, Simulation& s) {
  const std::size_t count = s.materials.size();
  const std::vector<Largest> largest = largest_of(s);
  std::vector<bool> on_walls(count);
  for (const Wall& wall : s.walls) on_walls[wall.material] = true;
  s.pair_kind.assign(count * count, no_law);
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a; b < count; ++b) {
      const bool balls_a = largest[a].diameter > 0, balls_b = largest[b].diameter > 0;
      if (!((balls_a && (balls_b || on_walls[b])) || (balls_b && on_walls[a]))) continue;
      const PairCase* chosen = nullptr;
      for (const PairCase& pair : c.pairs) {
        if (pair.a == "default" && chosen == nullptr) chosen = &pair;
        const std::string &first = s.materials[a].name, &second = s.materials[b].name;
        if ((pair.a == first && pair.b == second) || (pair.a == second && pair.b == first)) chosen = &pair;
      }
      if (!chosen && a == b && largest[a].count == 1 && !on_walls[a]) continue;  // a single ball never meets itself
      if (!chosen)
        throw InputError(fmt::format("{}: pair.{}.{} is missing, but {} and {} can meet; needed is a table of that name or [pair.default].", c.file,
                                     s.materials[a].name, s.materials[b].name, s.materials[a].name, s.materials[b].name));
      const Largest& ball = largest[a].diameter > largest[b].diameter ? largest[a] : largest[b];
      if (s.pair_laws.size() >= 255) throw InputError(c.file + ": more than 255 pairs of materials can meet; allowed are at most 255.");
      s.pair_laws.push_back(law_of(*chosen, s.materials[a], s.materials[b], ball.mass, ball.diameter, c.file));
      s.pair_kind[a * count + b] = s.pair_kind[b * count + a] = static_cast<std::uint8_t>(s.pair_laws.size() - 1);
    }
  }
}

double bulk_volume(const Simulation& s) {
  double sum = 0;
  for (Index i = 0; i < s.particles.owned; ++i) sum += ball_volume(s.solid_radius(i));
  return sum / (1 - bulk_porosity);
}

// The greatest speed of approach to reckon with: in a mill, shell or stirrer against a ball that fell through it (in a vial, by the pull of
// the disc); otherwise the fastest ball against one like it, after falling through the space the balls take up.
double greatest_speed(const Case& c, const Simulation& s) {
  const double g = c.gravity.norm();
  if (c.mill) return 0.5 * c.mill->diameter * std::abs(c.mill->speed) + std::sqrt(2 * g * c.mill->diameter);
  if (c.planetary) {
    const PlanetaryMill& mill = *c.planetary;
    const double across = mill.tilt == 0 ? mill.vial_diameter : std::hypot(mill.vial_diameter, mill.vial_length);
    const double pull = mill.speed * mill.speed * 0.5 * (mill.disc_diameter + across) + g;
    return 0.5 * mill.vial_diameter * std::abs(turn_at(vial_motion(mill, 0), mill.ramp).speed) + std::sqrt(2 * pull * across);
  }
  if (c.stirred) {
    const StirredMill& mill = *c.stirred;
    return tip_radius(stirrer_of(s.walls)) * std::abs(mill.speed) + std::sqrt(2 * g * std::hypot(mill.diameter, mill.length));
  }
  double fastest = 0, low = 1e300, high = -1e300;
  for (Index i = 0; i < s.particles.owned; ++i) {
    const auto row = static_cast<std::size_t>(i);
    fastest = std::max(fastest, vec(s.particles.velocity[row]).norm());
    const double height = g > 0 ? -vec(s.particles.position[row]).dot(c.gravity) / g : 0;
    low = std::min(low, height - s.particles.radius(i)), high = std::max(high, height + s.particles.radius(i));
  }
  for (const Wall& wall : s.walls)
    if (g > 0) low = std::min(low, -wall.pose.origin.dot(c.gravity) / g);
  return std::max(0.1, 2 * fastest + std::sqrt(2 * g * std::max(0.0, high - low)));
}

bool hertzian(const ContactLaw& law) { return std::holds_alternative<HertzMindlin>(law) || std::holds_alternative<Deresiewicz>(law); }

// How a step compares with the Rayleigh time of the particle that has the shortest, where a Hertzian law acts.
std::string beside_rayleigh(const Simulation& s, double step) {
  if (std::none_of(s.pair_laws.begin(), s.pair_laws.end(), [](const PairLaw& pair) { return hertzian(pair.law); })) return "";
  double shortest = 0, diameter = 0;
  for (Index i = 0; i < s.particles.owned; ++i) {
    const Material& material = s.materials[s.particles.material[static_cast<std::size_t>(i)]];
    if (!(material.young > 0)) continue;
    const double time = rayleigh_time(s.particles.radius(i), material);
    if (shortest == 0 || time < shortest) shortest = time, diameter = 2 * s.particles.radius(i);
  }
  if (shortest == 0) return "";
  return fmt::format("; it is {:.3g} times the Rayleigh time, {:.3g} s, of a {:.4g} mm ball", step / shortest, shortest, 1e3 * diameter);
}

// Springs so soft that balls sink into each other change what is simulated.
void warn_of_soft_contacts(Built& built) {
  constexpr double soft = 0.1;  // greatest overlap over radius
  const Simulation& s = built.simulation;
  const std::vector<Largest> largest = largest_of(s);
  for (std::size_t a = 0; a < largest.size(); ++a) {
    if (!(largest[a].diameter > 0)) continue;
    const std::uint8_t kind = s.pair_kind[a * largest.size() + a];
    if (kind == no_law) continue;
    const PairLaw& law = s.pair_laws[kind];
    const double overlap = collide_head_on(law, 0.25 * largest[a].diameter, 0.5 * largest[a].mass, built.expected_speed).peak_overlap / (0.5 * largest[a].diameter);
    if (overlap > soft)
      built.warnings.push_back(fmt::format("pair.{0}.{0}: the contact is soft: balls that meet at {1:.3g} m/s overlap by {2:.2g} of their radius.", s.materials[a].name, built.expected_speed, overlap));
  }
}

void choose_time_step(const Case& c, Built& built) {
  Simulation& s = built.simulation;
  if (c.looked_at) {
    s.clock.time_step = c.time_step.value();
    return;
  }
  built.expected_speed = greatest_speed(c, s);
  built.limit = time_step_limit(s, built.expected_speed, c.time_step_fraction);
  s.clock.time_step = c.time_step.value_or(built.limit.recommended);
  if (s.clock.time_step <= built.limit.limit) return;
  const std::string too_large = fmt::format("found {:.3g} s, above the limit of {:.3g} s: {}{}", s.clock.time_step, built.limit.limit, built.limit.reason,
                                            beside_rayleigh(s, s.clock.time_step));
  if (!c.unsafe_time_step) throw InputError(fmt::format("{}: time_step.value: {}. Allowed is less, or time_step.unsafe = true.", c.time_step_where, too_large));
  built.warnings.push_back("time_step.value: " + too_large + "; the case says that it is unsafe.");
}

void fill_observers(const Case& c, Built& built) {
  ObserverSettings& o = built.observe = c.observe;
  const std::vector<Wall>& walls = built.simulation.walls;
  const auto wall_of_key = [&](const std::string& key, const std::string& name) {
    const auto found = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.name == name; });
    if (found == walls.end()) {
      std::string names;
      for (const Wall& wall : walls) names += (names.empty() ? "" : ", ") + wall.name;
      throw InputError(fmt::format("{}: {}: found \"{}\", which is no wall; allowed is {}.", c.file, key, name, names.empty() ? "a wall, of which this case has none" : "one of " + names));
    }
    return static_cast<int>(found - walls.begin());
  };
  for (const std::string& name : c.driven_walls) o.driven_walls.push_back(wall_of_key("observe.driven_walls", name));
  for (const std::string& name : c.loading_walls) {
    const int index = wall_of_key("observe.loading", name);
    const Wall& wall = walls[static_cast<std::size_t>(index)];
    const Vec3 way = wall.frame < 0 ? Vec3::Zero().eval() : carried(poses_at(built.simulation.frames, c.duration)[static_cast<std::size_t>(wall.frame)], wall.rest).origin - wall.pose.origin;
    if (!(way.norm() > 0)) throw InputError(fmt::format("{}: observe.loading: found \"{}\", which does not move away; allowed is a wall on a frame with motion = \"translation\".", c.file, name));
    o.loading.push_back({index, way.normalized()});
  }
  if (!o.loading.empty() && built.simulation.bonds.empty())
    throw InputError(fmt::format("{}: observe.loading: found no bonded grains; allowed is a case that inserts an agglomerate.", c.file));
  const Index count = built.simulation.particles.owned;
  for (const int id : o.track)
    if (id >= count) throw InputError(fmt::format("{}: observe.track: found particle {}; allowed are 0 to {}, in the order of insertion.", c.file, id, count - 1));
  constexpr Index few = 1000;
  if (o.contact_history && count > few) throw InputError(fmt::format("{}: observe.contact_history: found {} particles; allowed are at most {}.", c.file, count, few));
  o.planetary = c.planetary;
  if (o.planetary) o.planetary->vessel.reset();
  if (c.stirred) {
    const StirredMill& mill = *c.stirred;
    o.mill = MillAxis{mill.centre, mill.axis.normalized(), mill.speed, 0.5 * mill.diameter, mill.length, 0};
  }
  if (!c.mill) return;
  o.mill = MillAxis{c.mill->centre, c.mill->axis.normalized(), c.mill->speed, 0.5 * c.mill->diameter, c.mill->length, c.mill->lifters.count > 0 ? c.mill->lifters.height : 0};
}

// A closed surface, turned so that its free side is inside (a vessel) or outside (a stirrer), whichever way the file's triangles look.
Mesh read_part(const Case& c, const MeshFile& file, const std::string& key, FreeSide free_side) {
  try {
    StlReport report;
    Mesh mesh = read_stl(file.name, file.scale, report);
    if (!report.closed) throw InputError(fmt::format("found an open surface with {} open edges in {}; allowed is a closed one", report.open_edges, file.name));
    double sixfold_volume = 0;
    for (const auto& t : mesh.triangles) sixfold_volume += mesh.vertices[static_cast<std::size_t>(t[0])].dot(mesh.vertices[static_cast<std::size_t>(t[1])].cross(mesh.vertices[static_cast<std::size_t>(t[2])]));
    if ((sixfold_volume > 0) == (free_side == FreeSide::inside)) {
      std::vector<std::array<Index, 3>> turned = mesh.triangles;
      for (auto& t : turned) std::swap(t[1], t[2]);
      mesh = make_mesh(mesh.vertices, std::move(turned));
    }
    return mesh;
  } catch (const InputError& e) {
    refuse(c.file, key, e.what());
  }
}

// The case with the parts that it takes from files.
Case with_parts(Case c) {
  if (!c.vial_file.name.empty()) c.planetary->vessel = read_part(c, c.vial_file, "mill.vial_file", FreeSide::inside);
  if (!c.vessel_file.name.empty()) c.stirred->vessel = read_part(c, c.vessel_file, "mill.vessel_file", FreeSide::inside);
  if (!c.stirrer_file.name.empty()) c.stirred->stirrer = read_part(c, c.stirrer_file, "mill.stirrer_file", FreeSide::outside);
  for (AgglomerateCase& body : c.agglomerates)
    if (!body.mesh.name.empty()) body.request.shape = read_part(c, body.mesh, "agglomerate." + body.name + ".file", FreeSide::outside);
  return c;
}

// From the fixed frame to the axes of the disc, which coincide at time 0.
void turn_with_disc(const PlanetaryMill& mill, Simulation& s) {
  const Turn disc = turn_at(disc_motion(mill), 0);
  const Vec3 speed = disc.speed * disc.axis;
  for (std::size_t k = 0; k < s.particles.position.size(); ++k) {
    add(s.particles.velocity[k], -speed.cross(vec(s.particles.position[k]) - disc.centre));
    add(s.particles.spin[k], -speed);
  }
  s.fields.push_back(TurningFrame{disc_motion(mill), s.gravity});
}

}  // namespace

PairLaw law_of(const PairCase& pair, const Material& a, const Material& b, double mass, double diameter, const std::string& file) {
  const auto elastic = [&] {
    for (const Material* m : {&a, &b})
      if (!(m->young > 0)) throw InputError(fmt::format("{}: material.{}.young is missing, needed for the law of {}; allowed is more than 0 Pa, or a text such as \"206 GPa\".", file, m->name, key_of(pair)));
  };
  const auto tangential = [&](double normal) { return pair.tangential_stiffness.value_or(pair.tangential_ratio * normal); };
  const auto power = [&] { return PowerLaw{*pair.stiffness_coefficient, pair.stiffness_exponent, *pair.damping_coefficient, pair.damping_exponent, 0, pair.friction}; };
  PairLaw law{Linear{}, pair.rolling, {}};
  switch (pair.law) {
    case LawKind::linear: {
      const double k = pair.normal_stiffness ? *pair.normal_stiffness : std::pow(*pair.penetration_factor * *pair.max_speed / diameter, 2) * mass;
      law.law = Linear{k, tangential(k), linear_damping_ratio(*pair.restitution), pair.friction};
      break;
    }
    case LawKind::hertz_mindlin:
      elastic();
      law.law = HertzMindlin{effective_young(a, b), effective_shear(a, b), hertz_damping_ratio(*pair.restitution), pair.friction};
      break;
    case LawKind::deresiewicz: {
      elastic();
      const double d = pair.reference_diameter.value_or(diameter);
      const double ball = mass * std::pow(d / diameter, 3), young = effective_young(a, b);
      const double poisson = 0.5 * (a.poisson + b.poisson);
      law.law = Deresiewicz{young, deresiewicz_damping_modulus(young, *pair.restitution, 0.25 * d, 0.5 * ball, pair.reference_speed),
                            pair.friction * (2 - poisson) / (2 * (1 - poisson)), pair.friction};
      break;
    }
    case LawKind::power_law: {
      PowerLaw chosen = power();
      chosen.tangential_stiffness = tangential(linearize(chosen, *pair.impact_mass, *pair.impact_speed).stiffness);
      law.law = chosen;
      break;
    }
    case LawKind::linearized: {
      double k = pair.normal_stiffness.value_or(0), q = pair.normal_damping.value_or(0);
      if (pair.stiffness_coefficient) {
        const Linearization l = linearize(power(), *pair.impact_mass, *pair.impact_speed);
        k = l.stiffness, q = l.damping;
      }
      law.law = Linearized{k, q, tangential(k), pair.friction};
      break;
    }
  }
  law.extras = extras_of(pair, law.law);
  return law;
}

Built build_case(const Case& given) {
  const Case c = with_parts(given);
  Built built;
  Simulation& s = built.simulation;
  built.warnings = c.warnings;
  s.materials = c.materials;
  for (const SpeciesCase& species : c.species) s.species.push_back({species.name, species.material});
  s.domain = c.domain;
  s.gravity = c.gravity;
  s.fields = c.fields;
  s.carried_density = c.carried_density;

  if (c.mill) s.frames.push_back(frame_of(*c.mill));
  if (c.planetary) s.frames = frames_of(*c.planetary);
  if (c.stirred) s.frames.push_back(frame_of(*c.stirred));
  const auto frame_index = [&](const std::string& name) {
    const auto found = std::find_if(s.frames.begin(), s.frames.end(), [&](const Frame& frame) { return frame.name == name; });
    return name.empty() ? Index{-1} : static_cast<Index>(found - s.frames.begin());
  };
  for (const FrameCase& frame : c.frames) s.frames.push_back({frame.name, frame_index(frame.parent), frame.motion});
  if (c.mill) s.walls = walls_of(*c.mill, 0);
  if (c.planetary) s.walls = walls_of(*c.planetary, 0);
  if (c.stirred) s.walls = walls_of(*c.stirred, 0);
  const std::vector<Pose> poses = poses_at(s.frames, 0);
  for (const WallCase& wall : c.walls) {
    const Index frame = frame_index(wall.frame);
    s.walls.push_back(wall_of(wall, frame, frame < 0 ? Pose{} : poses[static_cast<std::size_t>(frame)]));
  }

  built.bodies = insert_particles(c, s);
  if (c.planetary && c.planetary->axes == PlanetaryMill::Axes::disc) turn_with_disc(*c.planetary, s);
  make_laws(c, s);
  refuse_unfit_for_shapes(c, s);
  choose_time_step(c, built);
  if (!c.looked_at) warn_of_soft_contacts(built);
  fill_observers(c, built);
  if (const double space = mill_volume(c); space > 0) built.filling = bulk_volume(s) / space;
  return built;
}

Simulation build(const Case& c) { return build_case(c).simulation; }

}  // namespace quern
