#include "src/contact/cell_grid.hpp"
#include <algorithm>
#include <numeric>

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

struct Box {
  double lower[3] = {1e300, 1e300, 1e300}, upper[3] = {-1e300, -1e300, -1e300};
  void include(const Quad& q) {
    const double x[3] = {q.x, q.y, q.z};
    for (int axis = 0; axis < 3; ++axis) lower[axis] = std::min(lower[axis], x[axis]), upper[axis] = std::max(upper[axis], x[axis]);
  }
};

// Calls work(k) for each k below count, some thousands to a block of the team.
template <class Work>
void for_each(ThreadTeam& team, std::size_t count, Work&& work) {
  constexpr std::size_t share = 4096;
  team.run(static_cast<int>((count + share - 1) / share), [&](int block) {
    const std::size_t first = static_cast<std::size_t>(block) * share, last = std::min(count, first + share);
    for (std::size_t k = first; k < last; ++k) work(k);
  });
}

CellGrid make_grid(const Particles& particles, const Domain& domain, const std::vector<Index>& rows, double skin, ThreadTeam& team) {
  CellGrid grid;
  Box box;
  for (Index i : rows) {
    box.include(particles.position[at(i)]);
    grid.largest_radius = std::max(grid.largest_radius, particles.radius(i));
  }
  double cell = 2 * grid.largest_radius + skin;
  for (;; cell *= 1.5) {  // far-flung particles must not make the grid larger than the particles themselves
    double count = 1;
    for (int axis = 0; axis < 3; ++axis) {
      // Runs of particles lie along x: narrow cells there cut them to length.
      const double width = axis == 0 ? cell / 3 : cell;
      grid.wraps[axis] = domain.period[axis] > 0;
      const double extent = grid.wraps[axis] ? domain.period[axis] : box.upper[axis] - box.lower[axis];
      grid.lower[axis] = grid.wraps[axis] ? domain.lower[axis] : box.lower[axis];
      const double fitting = grid.wraps[axis] ? std::max(1.0, std::floor(extent / width)) : std::floor(extent / width) + 1;
      count *= fitting;
      grid.cells[axis] = static_cast<Index>(std::min(fitting, 1e6));
      grid.inverse_cell[axis] = grid.wraps[axis] ? fitting / extent : 1 / width;
    }
    if (count <= 16.0 * static_cast<double>(rows.size()) + 64) break;
  }
  const Index cells = grid.cells[0] * grid.cells[1] * grid.cells[2];
  std::vector<Index> cell_of(rows.size());
  grid.cell_start.assign(at(cells) + 1, 0);
  for_each(team, rows.size(), [&](std::size_t k) {
    const Quad& q = particles.position[at(rows[k])];
    cell_of[k] = (grid.cell_of(2, q.z) * grid.cells[1] + grid.cell_of(1, q.y)) * grid.cells[0] + grid.cell_of(0, q.x);
  });
  for (Index cell_here : cell_of) ++grid.cell_start[at(cell_here) + 1];
  std::partial_sum(grid.cell_start.begin(), grid.cell_start.end(), grid.cell_start.begin());
  std::vector<Index> next(grid.cell_start.begin(), grid.cell_start.end() - 1);
  constexpr std::size_t batch = 8;
  for (std::vector<double>* column : {&grid.x, &grid.y, &grid.z, &grid.radius}) column->resize(rows.size() + batch);
  grid.row.resize(rows.size() + batch);
  for (std::size_t k = 0; k < rows.size(); ++k) grid.row[at(next[at(cell_of[k])]++)] = rows[k];
  for_each(team, rows.size(), [&](std::size_t k) {
    const Quad& q = particles.position[at(grid.row[k])];
    grid.x[k] = q.x, grid.y[k] = q.y, grid.z[k] = q.z, grid.radius[k] = q.w;
  });
  return grid;
}

// Spreads the lowest 21 bits of a over every third bit.
std::uint64_t spread(std::uint64_t a) {
  a &= 0x1fffff;
  a = (a | a << 32) & 0x1f00000000ffffull;
  a = (a | a << 16) & 0x1f0000ff0000ffull;
  a = (a | a << 8) & 0x100f00f00f00f00full;
  a = (a | a << 4) & 0x10c30c30c30c30c3ull;
  return (a | a << 2) & 0x1249249249249249ull;
}

}  // namespace

std::vector<CellGrid> make_grids(const Particles& particles, const Domain& domain, double skin, ThreadTeam& team) {
  double largest = 0;
  for (Index i = 0; i < particles.owned; ++i) largest = std::max(largest, particles.radius(i));
  std::vector<std::vector<Index>> octaves;
  double last_radius = 0;
  std::size_t octave = 0;
  for (Index i = 0; i < particles.owned; ++i) {
    if (particles.radius(i) != last_radius) {
      last_radius = particles.radius(i);
      octave = static_cast<std::size_t>(std::min(30, std::max(0, std::ilogb(largest / last_radius))));
    }
    if (octaves.size() <= octave) octaves.resize(octave + 1);
    octaves[octave].push_back(i);
  }
  std::vector<CellGrid> grids;
  for (const std::vector<Index>& rows : octaves)
    if (!rows.empty()) grids.push_back(make_grid(particles, domain, rows, skin, team));
  return grids;
}

std::vector<Index> spatial_order(const Particles& particles, double cell) {
  Box box;
  for (Index i = 0; i < particles.owned; ++i) box.include(particles.position[at(i)]);
  for (int axis = 0; axis < 3; ++axis) cell = std::max(cell, (box.upper[axis] - box.lower[axis]) / 2e6);
  struct Key {
    std::uint64_t curve;
    Index id, row;
  };
  std::vector<Key> keys(at(particles.owned));
  for (Index i = 0; i < particles.owned; ++i) {
    const Quad& q = particles.position[at(i)];
    const auto cell_at = [&](double x, int axis) { return spread(static_cast<std::uint64_t>((x - box.lower[axis]) / cell)); };
    keys[at(i)] = {cell_at(q.x, 0) | cell_at(q.y, 1) << 1 | cell_at(q.z, 2) << 2, particles.id[at(i)], i};
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.curve != b.curve ? a.curve < b.curve : a.id < b.id; });
  std::vector<Index> order(keys.size());
  for (std::size_t k = 0; k < keys.size(); ++k) order[k] = keys[k].row;
  for (Index ghost = particles.owned; ghost < particles.size(); ++ghost) order.push_back(ghost);
  return order;
}

}  // namespace quern
