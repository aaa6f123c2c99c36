#include "src/case/bodies.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/reading.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

const Bodies::Body& Bodies::body(std::size_t agglomerate) {
  if (made_[agglomerate]) return *made_[agglomerate];
  const AgglomerateCase& c = case_.agglomerates[agglomerate];
  Body made;
  double shape_volume = 0;
  try {
    made.grains = c.grains;
    if (c.grains.empty()) made.grains = pack_body(c.request), shape_volume = volume(c.request.shape);
    made.pairs = c.triangulated ? triangulated_pairs(made.grains, c.gap) : near_pairs(made.grains, c.gap);
  } catch (const InputError& e) {
    refuse(c.where, "agglomerate." + c.name, e.what());
  }
  for (const Grain& grain : made.grains) {
    const double solid = std::numbers::pi / 6 * std::pow(grain.diameter, 3);
    made.reach = std::max(made.reach, grain.position.norm() + 0.5 * grain.diameter);
    made.solid += solid;
    made.mass += solid * case_.species[grain.species].density;
  }
  made.report = describe(made.grains, made.pairs, shape_volume);
  if (made.report.bonds == 0 && made.grains.size() > 1)
    refuse(c.where, "agglomerate." + c.name + ".gap", fmt::format("found no two grains nearer than {:.3g} m; allowed is a gap at which they are bonded", c.gap));
  made_[agglomerate] = std::move(made);
  return *made_[agglomerate];
}

// A bond between two species: of the table with their names, or of [bond.default]. Materials come into the simulation as they are used.
Index Bodies::material_of(const AgglomerateCase& agglomerate, std::uint8_t a, std::uint8_t b) {
  const std::string &first = case_.species[a].name, &second = case_.species[b].name;
  const BondCase* chosen = nullptr;
  for (const BondCase& bond : case_.bonds) {
    if (bond.a == "default" && chosen == nullptr) chosen = &bond;
    if ((bond.a == first && bond.b == second) || (bond.a == second && bond.b == first)) chosen = &bond;
  }
  if (chosen == nullptr)
    refuse(agglomerate.where, "agglomerate." + agglomerate.name,
           fmt::format("found grains of {} beside {} without a table [bond.{}.{}]; allowed is such a table, or [bond.default]", first, second, first, second));
  std::vector<BondMaterial>& materials = simulation_.bonds.materials;
  const auto known = std::find_if(materials.begin(), materials.end(), [&](const BondMaterial& m) { return m.name == chosen->material.name; });
  if (known != materials.end()) return static_cast<Index>(known - materials.begin());
  materials.push_back(chosen->material);
  return static_cast<Index>(materials.size()) - 1;
}

void Bodies::add(std::size_t agglomerate, const Vec3& centre, const Mat3& turn, const Vec3& velocity, const Vec3& spin) {
  const Body& one = body(agglomerate);
  const AgglomerateCase& c = case_.agglomerates[agglomerate];
  Particles& particles = simulation_.particles;
  const Index first = particles.owned;
  for (const Grain& grain : one.grains) {
    const SpeciesCase& species = case_.species[grain.species];
    const Vec3 arm = turn * grain.position;
    const std::size_t row = at(particles.add_sphere(triple(Vec3(centre + arm)), 0.5 * grain.diameter, species.density, species.material, grain.species));
    set(particles.velocity[row], velocity + spin.cross(arm));
    set(particles.spin[row], spin);
  }
  particles.keep_orientations();
  const double size = 2 * one.reach, rate = velocity.norm() / size;
  try {
    for (const auto& [i, j] : one.pairs) {
      const Index material = material_of(c, one.grains[at(i)].species, one.grains[at(j)].species);
      const Index bond = bond_particles(simulation_.bonds, particles, simulation_.domain, first + i, first + j, material, case_.seed);
      const double factor = body_factor(simulation_.bonds.materials[at(material)].strength, size, rate);
      if (factor != 1) simulation_.bonds.list[at(bond)].tensile_strength *= factor, simulation_.bonds.list[at(bond)].shear_strength *= factor;
    }
  } catch (const InputError& e) {
    if (std::string_view(e.what()).find("agglomerate.") != std::string_view::npos) throw;
    refuse(c.where, "agglomerate." + c.name, e.what());
  }
}

Portion Bodies::portion(const InsertCase& insert, double reference_volume) {
  const Body& one = body(*insert.agglomerate);
  Portion portion;
  portion.sizes = SizeDistribution::mono(2 * one.reach);
  portion.count = insert.count;
  if (insert.mass > 0) portion.count = std::llround(insert.mass / one.mass);
  if (insert.filling > 0) portion.count = std::llround(insert.filling * reference_volume * (1 - bulk_porosity) / one.solid);
  return portion;
}

std::vector<std::pair<std::string, BodyReport>> Bodies::reports() const {
  std::vector<std::pair<std::string, BodyReport>> all;
  for (std::size_t k = 0; k < made_.size(); ++k)
    if (made_[k]) all.emplace_back(case_.agglomerates[k].name, made_[k]->report);
  return all;
}

}  // namespace quern
