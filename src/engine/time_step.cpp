#include "src/engine/time_step.hpp"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include "src/contact/restitution.hpp"

namespace quern {
namespace {

struct Smallest {
  double radius = 1e300, mass = 0;
};

bool hertzian(const ContactLaw& law) { return std::holds_alternative<HertzMindlin>(law) || std::holds_alternative<Deresiewicz>(law); }

double linear_stiffness(const ContactLaw& law) {
  if (const auto* linear = std::get_if<Linear>(&law)) return linear->normal_stiffness;
  if (const auto* linearized = std::get_if<Linearized>(&law)) return linearized->normal_stiffness;
  return 0;
}

const char* name_of(const ContactLaw& law) {
  return std::visit([](const auto& l) { return l.name; }, law);
}

// Of the law's own tangential spring at an overlap [N/m].
double tangential_stiffness(const ContactLaw& law, double radius, double mass, double overlap) {
  const Approach<double> a = head_on(overlap, 0, radius, mass);
  const double stretch = 1e-9 * overlap;
  return std::visit(
      [&](const auto& chosen) {
        NormalPart<double> part;
        chosen.normal(a, part);
        TangentialSpring<double> spring{{stretch, 0, 0}, 0};
        ContactForce<double> force{};
        chosen.tangential(a, part, part.elastic, 1.0, spring, force);
        return std::max(1e-300, -force.tangential.x / stretch);
      },
      law);
}

struct Search {
  TimeStepLimit found;
  void offer(double limit, double recommended, const std::string& reason) {
    if (found.limit == 0 || limit < found.limit) found.limit = limit, found.reason = reason;
    if (found.recommended == 0 || recommended < found.recommended) found.recommended = recommended;
  }
};

// Stiffness that a grain's bonds oppose to its motion and to its turning.
struct BondedStiffness {
  double translation = 0, rotation = 0;  // [N/m], [N m/rad]
};

void consider_bonds(const Simulation& s, Search& search) {
  if (s.bonds.empty()) return;
  std::map<Index, std::size_t> row_of;
  for (std::size_t row = 0; row < s.particles.id.size(); ++row) row_of[s.particles.id[row]] = row;
  std::vector<BondedStiffness> stiffness(s.particles.id.size());
  for (const Bond& bond : s.bonds.list) {
    if (bond.state != BondState::intact) continue;
    const double square = bond.radius * bond.radius, area = std::numbers::pi * square;
    const double normal = bond.normal_stiffness * area, shear = bond.shear_stiffness * area;
    for (const Index id : {bond.first, bond.second}) {
      BondedStiffness& sum = stiffness[row_of.at(id)];
      sum.translation += std::max(normal, shear);
      sum.rotation += std::max(normal * square / 4, shear * square / 2) + shear * bond.length * bond.length / 4;
    }
  }
  double shifting = 1e300, turning = 1e300;
  Index shifted = 0, turned = 0;
  for (std::size_t row = 0; row < stiffness.size(); ++row) {
    if (stiffness[row].translation == 0) continue;
    const double shift = std::sqrt(s.particles.velocity[row].w / stiffness[row].translation);
    const double turn = std::sqrt(s.particles.spin[row].w / stiffness[row].rotation);
    if (shift < shifting) shifting = shift, shifted = s.particles.id[row];
    if (turn < turning) turning = turn, turned = s.particles.id[row];
  }
  if (shifting < 1e300)
    search.offer(0.4 * shifting, 0.2 * shifting, fmt::format("0.4 √(m/Σk) = 0.4 × {:.3g} s of grain {} among its bonds", shifting, shifted));
  if (turning < 1e300)
    search.offer(0.4 * turning, 0.2 * turning,
                 fmt::format("0.4 √(I/Σk_rot) = 0.4 × {:.3g} s of grain {}, which its bonds keep from turning", turning, turned));
}

// Forces of fields that grow with velocity or with the place, on the smallest ball of each material.
void consider_fields(const Simulation& s, const std::map<std::uint8_t, Smallest>& by_material, double speed, Search& search) {
  if (s.fields.empty()) return;
  double spin = 0;
  for (const Quad& w : s.particles.spin) spin = std::max(spin, length(xyz(w)));
  for (const Field& field : s.fields) {
    for (const auto& [material, smallest] : by_material) {
      const double inertia = smallest.mass + s.carried_density * ball_volume(smallest.radius);
      const double rate = rate_of(field, smallest.radius, inertia, speed, spin);
      if (!(rate > 0)) continue;
      search.offer(0.2 / rate, 0.05 / rate,
                   fmt::format("a fifth of the {:.3g} s in which {} changes the motion of the smallest {} ball (diameter {:.4g} mm, at {:.3g} m/s)", 1 / rate, name_of(field),
                               s.materials[material].name, 2e3 * smallest.radius, speed));
    }
  }
}

}  // namespace

double rayleigh_time(double radius, const Material& material) {
  return std::numbers::pi * radius * std::sqrt(material.density / shear_modulus(material)) / (0.1631 * material.poisson + 0.8766);
}

TimeStepLimit time_step_limit(const Simulation& s, double speed, double fraction) {
  std::map<std::uint8_t, Smallest> by_material;
  for (Index i = 0; i < s.particles.owned; ++i) {
    Smallest& smallest = by_material[s.particles.material[static_cast<std::size_t>(i)]];
    // Another shape than a sphere counts as the ball within it, which is less than what resists a push beside its centre.
    double radius = s.particles.radius(i), mass = s.particles.mass(i);
    if (!s.particles.shape.empty()) {
      const Superquadric& shape = s.shapes[s.particles.shape[static_cast<std::size_t>(i)]];
      radius *= shape.semi_axes().minCoeff() / shape.bounding_radius;
      mass *= std::pow(radius / s.solid_radius(i), 3);
    }
    if (radius < smallest.radius) smallest = {radius, mass};
  }
  Search search;
  const std::size_t count = s.materials.size();
  const auto consider = [&](std::uint8_t a, const Smallest& first, std::uint8_t b, const Smallest* second) {
    const std::uint8_t kind = s.pair_kind[a * count + b];
    if (kind == no_law) return;
    const PairLaw& chosen = s.pair_laws[kind];
    const ContactLaw& law = chosen.law;
    const std::string pair = fmt::format("{} on {}{}", s.materials[a].name, second == nullptr ? "wall of " : "", s.materials[b].name);
    const double radius = second == nullptr ? first.radius : first.radius * second->radius / (first.radius + second->radius);
    const double mass = second == nullptr ? first.mass : first.mass * second->mass / (first.mass + second->mass);
    const HeadOnCollision collision = collide_head_on(chosen, radius, mass, speed);
    const double duration = collision.duration;
    search.offer(duration / 20, duration / 40,
                 fmt::format("a twentieth of the {:.3g} s that the shortest collision lasts ({}, {} law, at {:.3g} m/s)", duration, pair,
                             name_of(law), speed));
    if (collision.damping_rate > 0) {
      const double time = 1 / collision.damping_rate;
      search.offer(time / 5, time / 15,
                   fmt::format("a fifth of the {:.3g} s in which the damping alone stops an approach ({}, {} law)", time, pair, name_of(law)));
    }
    if (const double soft = chosen.extras.tangential_compliance; soft > 0 && soft < 1) {
      const double period = 2 * std::numbers::pi * std::sqrt(2.0 / 7.0 * mass * soft / tangential_stiffness(law, radius, mass, collision.peak_overlap));
      search.offer(period / 20, period / 40,
                   fmt::format("a twentieth of the {:.3g} s of a tangential swing ({}, {} law, tangential_compliance {:.3g})", period, pair, name_of(law), soft));
    }
    if (const Lubrication& film = chosen.extras.lubrication; film.viscosity > 0) {
      const double time = mass / film(0.0, radius);
      search.offer(time / 5, time / 15, fmt::format("a fifth of the {:.3g} s in which the thinnest film stops an approach ({}; film_cutoff sets it)", time, pair));
    }
    if (hertzian(law) && s.materials[a].young > 0) {
      const double rayleigh = rayleigh_time(first.radius, s.materials[a]);
      search.offer(0.3 * rayleigh, fraction * rayleigh,
                   fmt::format("0.3 of the Rayleigh time {:.3g} s of the smallest {} ball (diameter {:.4g} mm, {} law)", rayleigh,
                               s.materials[a].name, 2e3 * first.radius, name_of(law)));
    }
    if (const double stiffness = linear_stiffness(law); stiffness > 0) {
      const double step = 0.2 * std::sqrt(first.mass / stiffness);
      search.offer(step, step, fmt::format("0.2 √(m/k) of the lightest {} ball (m = {:.3g} kg, k = {:.3g} N/m)", s.materials[a].name, first.mass, stiffness));
    }
  };
  for (const auto& [a, first] : by_material) {
    for (const auto& [b, second] : by_material) consider(a, first, b, &second);
    for (const Wall& wall : s.walls) consider(a, first, wall.material, nullptr);
  }
  consider_bonds(s, search);
  consider_fields(s, by_material, speed, search);
  if (search.found.limit == 0 && by_material.empty()) search.found = {1e-3, 1e-3, "no particles yet: 1 ms"};
  if (search.found.limit == 0) search.found = {1, 1e-3, "nothing can touch: 1 s"};
  search.found.recommended = std::min(search.found.recommended, search.found.limit);
  return search.found;
}

}  // namespace quern
