#include "bonds/bond_list.hpp"
#include <algorithm>
#include <numbers>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// A lane that pulls at nothing and never fails.
void make_idle(BondBatch& b, int lane) {
  b.normal[lane] = b.shear[lane] = 0;
  b.normal_damping[lane] = b.shear_damping[lane] = b.bending_damping[lane] = b.twisting_damping[lane] = 0;
  b.tension_limit[lane] = b.shear_limit[lane] = 1e300;
  b.bond[lane] = -1;
}

}  // namespace

void BondList::push(const Bond& bond, Index index, Index first_offset, Index second_offset) {
  const int lane = count % bonds_per_batch;
  if (lane == 0) batches.emplace_back();
  BondBatch& b = batches.back();
  const double area = std::numbers::pi * bond.radius * bond.radius, square = bond.length * bond.length;
  b.axis[0][lane] = bond.axis.x, b.axis[1][lane] = bond.axis.y, b.axis[2][lane] = bond.axis.z;
  b.relation[0][lane] = bond.relation.x, b.relation[1][lane] = bond.relation.y, b.relation[2][lane] = bond.relation.z,
  b.relation[3][lane] = bond.relation.w;
  b.inverse_length[lane] = 1 / bond.length;
  b.normal[lane] = bond.normal_stiffness * area * square;
  b.shear[lane] = bond.shear_stiffness * area * square;
  b.slenderness[lane] = 2 * bond.radius / bond.length;
  b.tension_limit[lane] = bond.tensile_strength / (bond.normal_stiffness * bond.length);
  b.shear_limit[lane] = bond.shear_strength / (bond.shear_stiffness * bond.length);
  b.normal_damping[lane] = bond.normal_damping, b.shear_damping[lane] = bond.shear_damping;
  b.bending_damping[lane] = bond.bending_damping, b.twisting_damping[lane] = bond.twisting_damping;
  b.first[lane] = first_offset, b.second[lane] = second_offset;
  b.bond[lane] = index;
  b.spare[lane] = 0;
  ++count;
}

void BondList::close(Index idle_offset) {
  if (count % bonds_per_batch == 0) return;
  for (int lane = count % bonds_per_batch; lane < bonds_per_batch; ++lane) {
    BondBatch& b = batches.back();
    make_idle(b, lane);
    b.axis[0][lane] = 1, b.axis[1][lane] = b.axis[2][lane] = 0;
    b.relation[0][lane] = b.relation[1][lane] = b.relation[2][lane] = 0, b.relation[3][lane] = 1;
    b.inverse_length[lane] = 1, b.slenderness[lane] = 1;
    b.first[lane] = idle_offset, b.second[lane] = idle_offset + 4;
    b.spare[lane] = 0;
  }
}

void BondList::fail(BondBatch& batch, int lane, BondFailure failure) {
  failure.bond = batch.bond[lane];
  failures.push_back(failure);
  make_idle(batch, lane);
}

std::vector<std::vector<BondRow>> bonds_by_block(Bonds& bonds, const Particles& particles, const Domain& domain, Index block_size,
                                                 std::size_t blocks) {
  std::vector<std::vector<BondRow>> result(blocks);
  if (bonds.empty()) return result;
  Index most = 0;
  for (const Bond& bond : bonds.list) most = std::max(most, bond.second);
  std::vector<Index> row_of(at(most) + 1, -1);
  for (Index row = 0; row < particles.size(); ++row)
    if (particles.id[at(row)] <= most) row_of[at(particles.id[at(row)])] = row;
  for (std::size_t k = 0; k < bonds.list.size(); ++k) {
    Bond& bond = bonds.list[k];
    if (bond.state == BondState::released) continue;
    const Index first = row_of[at(bond.first)], second = row_of[at(bond.second)], low = std::min(first, second),
                high = std::max(first, second);
    if (bond.state == BondState::broken) {
      const Triple<double> apart = domain.nearest(xyz(particles.position[at(high)]) - xyz(particles.position[at(low)]));
      const double touching = particles.radius(low) + particles.radius(high);
      if (bond.overlap == 0 || dot(apart, apart) > touching * touching) bond.state = BondState::released;
      if (bond.state == BondState::released) continue;
    }
    result[at(low / block_size)].push_back({low, high, static_cast<Index>(k), first == low, bond.state == BondState::intact, bond.overlap});
  }
  for (std::vector<BondRow>& block : result)
    std::sort(block.begin(), block.end(),
              [](const BondRow& a, const BondRow& b) { return a.low != b.low ? a.low < b.low : a.bond < b.bond; });
  return result;
}

}  // namespace quern
