#include "src/case/shape_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include "src/base/error.hpp"
#include "src/case/reading.hpp"
#include "src/contact/shape_contacts.hpp"
#include "src/field/shape_fields.hpp"
#include "src/particle/turning.hpp"
#include "src/wall/shape_walls.hpp"

namespace quern {

std::optional<Superquadric> read_shape(const Values& v, const std::string& t) {
  const bool superquadric = v.text(t + ".shape") == "superquadric";
  if (!superquadric) {
    if (v.has(t + ".semi_axes")) v.refuse(t + ".semi_axes", "only a superquadric has it; allowed is shape = \"superquadric\" beside it");
    if (v.numbers(t + ".exponents") != std::vector<double>{2, 2})  // the complete case states the default
      v.refuse(t + ".exponents", "only a superquadric has others than 2, 2; allowed is shape = \"superquadric\" beside it");
    return std::nullopt;
  }
  require(v, t, "semi_axes", "the shape superquadric");
  const std::vector<double> exponents = v.numbers(t + ".exponents");
  if (exponents.size() != 2) v.refuse(t + ".exponents", fmt::format("found {} numbers; allowed are two, n1 and n2", exponents.size()));
  const Vec3 axes = v.vector(t + ".semi_axes");
  constexpr double slimmest = 50;
  if (axes.maxCoeff() > slimmest * axes.minCoeff())
    v.refuse(t + ".semi_axes", fmt::format("found a longest one {:.3g} times the shortest; allowed is up to {:g} times", axes.maxCoeff() / axes.minCoeff(), slimmest));
  return make_superquadric(axes, exponents[0], exponents[1]);
}

bool has_sizes(const Values& v, const std::string& t) {
  constexpr const char* keys[] = {".sizes", ".diameter", ".diameters", ".median", ".modulus", ".table"};
  return std::any_of(std::begin(keys), std::end(keys), [&](const char* key) { return v.has(t + key); });
}

double held_by(const Superquadric& shape, double diameter) { return diameter * shape.bounding_radius / shape.volume_radius; }

void refuse_shaped_grains(const Values& v, const Case& c) {
  for (const AgglomerateCase& body : c.agglomerates) {
    const auto check = [&](std::uint8_t species) {
      if (c.species[species].shape)
        v.refuse("agglomerate." + body.name, fmt::format("found grains of {}, which are superquadrics; allowed are species of spheres", c.species[species].name));
    };
    for (const GrainPortion& portion : body.request.portions) check(portion.species);
    for (const Grain& grain : body.grains) check(grain.species);
  }
}

void add_shape(Simulation& s, const Case& c, std::uint8_t species, const Vec3& centre, double holding_diameter, const Mat3& turn, const Vec3& velocity, const Vec3& spin) {
  const SpeciesCase& kind = c.species[species];
  if (s.shapes.empty()) s.shapes.push_back(make_superquadric({1, 1, 1}, 2, 2));
  auto known = std::find_if(s.shapes.begin() + 1, s.shapes.end(), [&](const Superquadric& shape) {
    return shape.semi_axes() == kind.shape->semi_axes() && shape.n1() == kind.shape->n1() && shape.n2() == kind.shape->n2();
  });
  if (known == s.shapes.end()) known = s.shapes.insert(s.shapes.end(), *kind.shape);
  const Index row = s.particles.add_shape(triple(centre), *kind.shape, static_cast<std::uint8_t>(known - s.shapes.begin()), 0.5 * holding_diameter / known->bounding_radius, kind.density, kind.material, species);
  const Rotation q = Rotation(turn).normalized();
  s.particles.orientation[static_cast<std::size_t>(row)] = {q.x(), q.y(), q.z(), q.w()};
  set(s.particles.velocity[static_cast<std::size_t>(row)], velocity);
  set_spin(s.particles, row, spin);
}

double largest_shape_overlap(const Simulation& s) {
  const Particles& p = s.particles;
  double most = 0;
  const auto body = [&](std::size_t i) { return placed(s.shapes.data(), p.shape[i], p.position[i], p.orientation[i]); };
  const auto radius = [](const PlacedShape& shape) { return shape.size * shape.shape->volume_radius; };
  for (std::size_t i = 0; i < p.shape.size(); ++i) {
    if (p.shape[i] == 0) continue;
    const PlacedShape own = body(i);
    for (std::size_t j = 0; j < p.shape.size(); ++j) {
      if (j == i || (j > i && p.shape[j] != 0)) continue;
      PlacedShape other = body(j);
      other.centre = own.centre + vec(s.domain.nearest(triple(Vec3(other.centre - own.centre))));
      if ((other.centre - own.centre).norm() >= p.position[i].w + p.position[j].w) continue;
      const ShapeContact c = touch(own, other);
      if (c.touching) most = std::max(most, c.overlap / std::min(radius(own), radius(other)));
    }
    for (const Wall& wall : s.walls) {
      ShapeContact contacts[most_places];
      const int count = touch_shape(wall, own, contacts);
      for (int k = 0; k < count; ++k) most = std::max(most, contacts[k].overlap / radius(own));
    }
  }
  return most;
}

void refuse_unfit_for_shapes(const Case& c, const Simulation& s) {
  if (s.shapes.empty()) return;
  for (const Wall& wall : s.walls)
    if (!takes_shapes(wall))
      throw InputError(fmt::format("{}: found superquadrics and the wall {}, a cone; with superquadrics allowed are planes, cylinders, discs and meshes.", c.file, wall.name));
  for (std::size_t a = 0; a < s.materials.size(); ++a)
    for (std::size_t b = a; b < s.materials.size(); ++b)
      if (const std::uint8_t kind = s.pair_kind[a * s.materials.size() + b]; kind != no_law && s.pair_laws[kind].extras.any())
        throw InputError(fmt::format("{}: found superquadrics and effects beyond the law in the pair of {} and {}; with superquadrics allowed is the law with friction and rolling.",
                                     c.file, s.materials[a].name, s.materials[b].name));
  if (s.carried_density > 0 || !std::all_of(s.fields.begin(), s.fields.end(), [](const Field& field) { return takes_shapes(field); }))
    throw InputError(fmt::format("{}: found superquadrics and added mass, the force of a table or a turning frame; with superquadrics allowed are gravity, drag, buoyancy and lift.", c.file));
  if (!s.bonds.empty()) throw InputError(fmt::format("{}: found superquadrics and bonded agglomerates; allowed is one of the two.", c.file));
  if (c.observe.contact_history) throw InputError(fmt::format("{}: observe.contact_history: found superquadrics, whose contacts it does not follow; allowed is false.", c.file));
}

}  // namespace quern
