#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <cmath>
#include <memory>
#include <numbers>
#include "src/case/build.hpp"
#include "src/cli/commands.hpp"
#include "src/cli/soften.hpp"
#include "src/contact/restitution.hpp"

namespace quern {
namespace {

struct CheckWords {
  std::string file;
  std::vector<std::string> overrides;
  bool complete = false;
};

constexpr double particle_steps_per_second = 2e6;  // of one core, a cautious figure
constexpr double bytes_per_particle = 1300;        // arrays, candidates and the memory of about four contacts

std::string time_words(double seconds) {
  if (seconds < 100) return fmt::format("{:.3g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.3g} min", seconds / 60);
  if (seconds < 172800) return fmt::format("{:.3g} h", seconds / 3600);
  return fmt::format("{:.3g} days", seconds / 86400);
}

void print_particles(const Case& c, const Simulation& s) {
  fmt::print("Particles   {} spheres\n", s.particles.owned);
  for (std::size_t k = 0; k < s.species.size(); ++k) {
    Index count = 0;
    double mass = 0, least = 1e300, most = 0;
    for (Index i = 0; i < s.particles.owned; ++i) {
      if (s.particles.species[static_cast<std::size_t>(i)] != k) continue;
      ++count, mass += s.particles.mass(i), least = std::min(least, 2 * s.particles.radius(i)), most = std::max(most, 2 * s.particles.radius(i));
    }
    if (count == 0) fmt::print("            {}: none is inserted\n", s.species[k].name);
    else fmt::print("            {}: {} of {}, {:.4g} kg, diameter {:.4g}{} mm\n", s.species[k].name, count, c.materials[s.species[k].material].name, mass, 1e3 * least, most > least ? fmt::format(" to {:.4g}", 1e3 * most) : "");
  }
}

void print_walls(const Simulation& s) {
  fmt::print("Walls       {}\n", s.walls.size());
  for (const Wall& wall : s.walls) {
    const auto* mesh = std::get_if<Mesh>(&wall.surface);
    const std::string kind = mesh ? fmt::format("mesh of {} triangles", mesh->triangles.size()) : std::holds_alternative<Plane>(wall.surface) ? "plane" : "surface of revolution";
    fmt::print("            {}: {} of {}{}\n", wall.name, kind, s.materials[wall.material].name, wall.frame < 0 ? ", fixed" : ", on the frame " + s.frames[static_cast<std::size_t>(wall.frame)].name);
  }
}

void print_laws(const Built& built) {
  const Simulation& s = built.simulation;
  for (std::size_t a = 0; a < s.materials.size(); ++a) {
    for (std::size_t b = a; b < s.materials.size(); ++b) {
      const std::uint8_t kind = s.pair_kind[a * s.materials.size() + b];
      if (kind == no_law) continue;
      const PairLaw& pair = s.pair_laws[kind];
      const char* name = std::visit([](const auto& law) { return law.name; }, pair.law);
      fmt::print("Contact     {}–{}: {}, {}\n", s.materials[a].name, s.materials[b].name, name,
                 pair.rolling.model == RollingModel::none ? "no rolling resistance" : fmt::format("rolling resistance {}", pair.rolling.coefficient));
    }
  }
}

void print_fields(const Simulation& s) {
  std::string names;
  for (const Field& field : s.fields) names += (names.empty() ? "" : ", ") + name_of(field);
  if (s.carried_density > 0) names += (names.empty() ? "" : ", ") + std::string("added_mass");
  if (!names.empty()) fmt::print("Forces      {}\n", names);
}

void print_bodies(const Built& built) {
  for (const auto& [name, body] : built.bodies) {
    fmt::print("Agglomerate {}: {} grains, {} bonds, {:.3g} bonds at a grain", name, body.grains, body.bonds, body.coordination);
    if (body.solid_fraction > 0) fmt::print(", solid fraction {:.3g} (porosity {:.3g})", body.solid_fraction, 1 - body.solid_fraction);
    fmt::print("{}\n", body.pieces == 1 ? "" : fmt::format(", in {} pieces that no bond joins", body.pieces));
  }
}

int explain(const CheckWords& words) {
  const Case c = read_case(words.file, words.overrides);
  const Built built = build_case(c);
  const Simulation& s = built.simulation;
  if (words.complete) {
    fmt::print("{}", c.text);
    return 0;
  }
  fmt::print("Case        {}{}\n", c.name, c.title.empty() ? "" : ": " + c.title);
  print_particles(c, s);
  print_bodies(built);
  print_walls(s);
  print_laws(built);
  print_fields(s);
  if (c.mill) {
    const double per_minute = 60 / (2 * std::numbers::pi);
    fmt::print("Mill        diameter {:.4g} m, length {:.4g} m, filling {:.3g} %\n", c.mill->diameter, c.mill->length, 100 * built.filling);
    fmt::print("            critical speed {:.4g} rpm; turns at {:.4g} rpm, {:.3g} % of it\n", c.critical_speed * per_minute, c.mill->speed * per_minute, 100 * c.mill->speed / c.critical_speed);
  }
  if (c.planetary) {
    const PlanetaryMill& mill = *c.planetary;
    const double per_minute = 60 / (2 * std::numbers::pi);
    fmt::print("Mill        planetary, {} of {:.4g} mm x {:.4g} mm on a disc of {:.4g} mm; filling {:.3g} %\n", mill.vials == 1 ? "one vial" : fmt::format("{} vials", mill.vials),
               1e3 * mill.vial_diameter, 1e3 * mill.vial_length, 1e3 * mill.disc_diameter, 100 * built.filling);
    fmt::print("            disc {:.4g} rpm, vials {:.4g} rpm against it; computed in the axes of the {}\n", mill.speed * per_minute,
               turn_at(vial_motion(mill, 0), mill.ramp).speed * per_minute, mill.axes == PlanetaryMill::Axes::disc ? "disc" : "fixed frame");
    if (mill.tilt == 0)
      fmt::print("            vials {:.4g} rpm against the fixed frame; {:.4g} rpm would keep the largest ball on the shell\n", absolute_ratio(mill) * mill.speed * per_minute, c.critical_speed * per_minute);
  }
  if (c.stirred) {
    const StirredMill& mill = *c.stirred;
    const double per_minute = 60 / (2 * std::numbers::pi);
    fmt::print("Mill        stirred, vessel {:.4g} mm x {:.4g} mm, filling {:.3g} %\n", 1e3 * mill.diameter, 1e3 * mill.length, 100 * built.filling);
    const std::string stirrer = c.stirrer_file.name.empty() ? fmt::format("{} discs, {} pins", mill.discs.count, mill.pins.rows * mill.pins.per_row) : c.stirrer_file.name;
    fmt::print("            stirrer ({}) {:.4g} rpm; {:.3g} m/s at its tip\n", stirrer, mill.speed * per_minute,
               tip_radius(stirrer_of(s.walls)) * std::abs(mill.speed));
  }
  const double steps = std::ceil(c.duration / s.clock.time_step);
  fmt::print("Time step   {:.4g} s ({}); the limit is {:.4g} s, {}\n", s.clock.time_step, c.time_step ? "as asked" : "chosen", built.limit.limit, built.limit.reason);
  fmt::print("            greatest speed of approach reckoned with: {:.3g} m/s\n", built.expected_speed);
  fmt::print("Run         {:.4g} s in {:.0f} steps\n", c.duration, steps);
  fmt::print("Estimate    {:.3g} MB of memory, about {} on one core (at {:.1g} particle-steps per second)\n", 20 + 1e-6 * bytes_per_particle * s.particles.owned,
             time_words(steps * s.particles.owned / particle_steps_per_second), particle_steps_per_second);
  for (const std::string& warning : built.warnings) fmt::print("Warning     {}\n", warning);
  return 0;
}

}  // namespace

void add_check(CLI::App& program, Action& action) {
  auto words = std::make_shared<CheckWords>();
  CLI::App* command = program.add_subcommand("check", "Reads and explains a case without running it");
  command->add_option("CASE", words->file, "Case file (TOML)")->required();
  command->add_option("--set", words->overrides, "key=value, laid over the case; may be repeated");
  command->add_flag("--complete", words->complete, "Print the complete case with every default instead");
  auto softer = std::make_shared<SoftenWords>();
  CLI::Option* soften_by = command->add_option("--soften", softer->factor, "Run the case as it is and with contacts FACTOR times as soft (default 10), and tell which outputs move")
                               ->type_name("FACTOR")->expected(0, 1)->default_str("10")->check(CLI::Range(1.1, 1e6));
  command->add_option("--threads", softer->threads, "With --soften: number of threads; default: as many as pay")->check(CLI::Range(1, 1024))->needs(soften_by);
  command->add_option("--out", softer->directory, "With --soften: directory of the runs; default out/<case name>_soften")->needs(soften_by);
  command->callback([words, softer, soften_by, &action] {
    softer->file = words->file, softer->overrides = words->overrides;
    const bool asked = soften_by->count() > 0;
    action = [words, softer, asked] { return asked ? soften(*softer) : explain(*words); };
  });
}

}  // namespace quern
