#include "bonds/bonds.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <numbers>
#include <unordered_set>
#include "src/base/error.hpp"
#include "src/base/vec.hpp"
#include "src/contact/cell_grid.hpp"
#include "src/contact/kernels.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

std::uint64_t key_of(Index first, Index second) { return static_cast<std::uint64_t>(first) << 32 | static_cast<std::uint64_t>(second); }

double together(double a, double b) { return a * b / (a + b); }

}  // namespace

Index bond_particles(Bonds& bonds, Particles& particles, const Domain& domain, Index row, Index other_row, Index material_index,
                     std::uint64_t seed) {
  const BondMaterial& material = bonds.materials.at(at(material_index));
  check(material);
  if (row == other_row) throw InputError(fmt::format("particle {} cannot be bonded to itself.", particles.id[at(row)]));
  particles.keep_orientations();
  const bool ordered = particles.id[at(row)] < particles.id[at(other_row)];
  const std::size_t i = at(ordered ? row : other_row), j = at(ordered ? other_row : row);
  const Vec3 apart = vec(domain.nearest(xyz(particles.position[j]) - xyz(particles.position[i])));
  const double length = apart.norm();
  if (!(length > 0))
    throw InputError(fmt::format("particles {} and {} have the same centre and cannot be bonded.", particles.id[i], particles.id[j]));
  for (int axis = 0; axis < 3; ++axis)
    if (domain.period[axis] > 0 && std::abs(apart[axis]) > 0.49 * domain.period[axis])
      throw InputError(fmt::format("particles {} and {} are bonded over half a period of the domain; it must be longer.", particles.id[i],
                                   particles.id[j]));

  const Rotation first = rotation_of(particles.orientation[i]), relation = rotation_of(particles.orientation[j]).conjugate() * first;
  const double smaller = std::min(particles.position[i].w, particles.position[j].w);
  const double factor = strength_factor(material.strength, seed, particles.id[i], particles.id[j]);
  Bond bond{};
  bond.relation = {relation.x(), relation.y(), relation.z(), relation.w()};
  bond.axis = triple(Vec3(first.conjugate() * (apart / length)));
  bond.length = length;
  bond.radius = material.radius_ratio * smaller;
  bond.normal_stiffness = material.young > 0 ? material.young / length : material.normal_stiffness;
  bond.shear_stiffness = material.young > 0 ? material.shear_modulus / length : material.shear_stiffness;
  const double square = bond.radius * bond.radius, area = std::numbers::pi * square;
  const double stretching = bond.normal_stiffness * area, shearing = bond.shear_stiffness * area;
  const double mass = together(particles.velocity[i].w, particles.velocity[j].w),
               inertia = together(particles.spin[i].w, particles.spin[j].w);
  bond.normal_damping = 2 * material.damping.normal * std::sqrt(mass * stretching);
  bond.shear_damping = 2 * material.damping.shear * std::sqrt(mass * shearing);
  bond.bending_damping = 2 * material.damping.bending * std::sqrt(inertia * stretching * square / 4);
  bond.twisting_damping = 2 * material.damping.twisting * std::sqrt(inertia * shearing * square / 2);
  bond.tensile_strength = factor * material.strength.tensile;
  bond.shear_strength = factor * material.strength.shear;
  bond.overlap = std::max(0.0, particles.position[i].w + particles.position[j].w - length);
  bond.first = particles.id[i];
  bond.second = particles.id[j];
  bond.material = material_index;
  bond.state = BondState::intact;
  bonds.list.push_back(bond);
  return static_cast<Index>(bonds.list.size()) - 1;
}

std::int64_t bond_particles_nearer_than(Bonds& bonds, Particles& particles, const Domain& domain, double gap,
                                        const std::function<Index(Index, Index)>& material_of, std::uint64_t seed) {
  if (!(gap >= 0)) throw InputError(fmt::format("the gap within which particles are bonded is {:g} m; it must not be negative.", gap));
  std::unordered_set<std::uint64_t> bonded;
  for (const Bond& bond : bonds.list) bonded.insert(key_of(bond.first, bond.second));
  ThreadTeam alone(1);
  const std::vector<CellGrid> grids = make_grids(particles, domain, gap, alone);
  const std::size_t before = bonds.list.size();
  Found found;
  for (Index i = 0; i < particles.owned; ++i) {
    found.count = 0;
    for (const CellGrid& grid : grids) best_kernels().find_near(domain, grid, particles.position[at(i)], gap, i, found);
    std::sort(found.row.begin(), found.row.begin() + found.count);
    for (Index k = 0; k < found.count; ++k) {
      const Index j = found.row[at(k)], a = particles.id[at(i)], b = particles.id[at(j)];
      const Index material = material_of(i, j);
      if (material >= 0 && bonded.insert(key_of(std::min(a, b), std::max(a, b))).second)
        bond_particles(bonds, particles, domain, i, j, material, seed);
    }
  }
  return static_cast<std::int64_t>(bonds.list.size() - before);
}

std::int64_t bond_particles_nearer_than(Bonds& bonds, Particles& particles, const Domain& domain, double gap, Index material,
                                        std::uint64_t seed) {
  return bond_particles_nearer_than(
      bonds, particles, domain, gap, [material](Index, Index) { return material; }, seed);
}

}  // namespace quern
