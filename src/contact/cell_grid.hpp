// Particles binned into cells, one grid for each octave of radii, so that small ones never search the cells of large ones.
#pragma once
#include <vector>
#include "src/base/domain.hpp"
#include "src/base/threads.hpp"
#include "src/particle/particles.hpp"

namespace quern {

struct CellGrid {
  double largest_radius = 0;   // of the particles in it [m]
  double lower[3], inverse_cell[3];
  Index cells[3];
  bool wraps[3];
  std::vector<Index> cell_start;  // x runs fastest
  std::vector<double> x, y, z, radius;  // in the order of the cells; padded for SIMD batches
  std::vector<Index> row;               // of the particle arrays; padded

  QUERN_INLINE Index cell_of(int axis, double along) const {
    const double at = (along - lower[axis]) * inverse_cell[axis];
    const auto cell = static_cast<Index>(at < 0 ? 0 : at);
    return cell < cells[axis] ? cell : cells[axis] - 1;
  }
};

// Bins the owned particles; cells are at least as wide as the largest pair in them plus the skin [m].
std::vector<CellGrid> make_grids(const Particles& particles, const Domain& domain, double skin, ThreadTeam& team);

// Calls visit(first, last) for each run of grid.row that may hold particles within `reach` of a centre.
template <class Visit>
QUERN_INLINE void for_runs_near(const CellGrid& grid, const Quad& centre, double reach, Visit&& visit) {
  const double middle[3] = {centre.x, centre.y, centre.z};
  Index from[3], to[3];
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.wraps[axis]) {
      from[axis] = static_cast<Index>(std::floor((middle[axis] - reach - grid.lower[axis]) * grid.inverse_cell[axis]));
      to[axis] = static_cast<Index>(std::floor((middle[axis] + reach - grid.lower[axis]) * grid.inverse_cell[axis]));
      if (to[axis] - from[axis] + 1 >= grid.cells[axis]) from[axis] = 0, to[axis] = grid.cells[axis] - 1;
    } else {
      if ((middle[axis] + reach - grid.lower[axis]) < 0) return;
      from[axis] = grid.cell_of(axis, middle[axis] - reach);
      to[axis] = grid.cell_of(axis, middle[axis] + reach);
    }
  }
  const auto wrap = [&](int axis, Index c) { return c < 0 ? c + grid.cells[axis] : c >= grid.cells[axis] ? c - grid.cells[axis] : c; };
  for (Index cz = from[2]; cz <= to[2]; ++cz)
    for (Index cy = from[1]; cy <= to[1]; ++cy) {
      const Index line = (wrap(2, cz) * grid.cells[1] + wrap(1, cy)) * grid.cells[0];
      const auto run = [&](Index a, Index b) {
        visit(grid.cell_start[static_cast<std::size_t>(line + a)], grid.cell_start[static_cast<std::size_t>(line + b) + 1]);
      };
      if (from[0] < 0) {
        run(from[0] + grid.cells[0], grid.cells[0] - 1);
        run(0, to[0]);
      } else if (to[0] >= grid.cells[0]) {
        run(from[0], grid.cells[0] - 1);
        run(0, to[0] - grid.cells[0]);
      } else {
        run(from[0], to[0]);
      }
    }
}

// The order of rows that puts particles along a space-filling curve (Morton) of cells of the given width [m].
std::vector<Index> spatial_order(const Particles& particles, double cell);

}  // namespace quern
