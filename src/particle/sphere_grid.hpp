// Cells for finding the balls near a place, with one grid for each factor of two in size, so that small balls beside large ones cost
// no more than balls of one size.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>
#include "src/base/domain.hpp"

namespace quern {

class SphereGrid {
 public:
  // For balls with radii between `smallest` and `largest` and centres between two corners, about `count` of them. Centres
  // outside the corners are found too, more slowly. [m]
  SphereGrid(const Domain& domain, const Quad& lower, const Quad& upper, double smallest, double largest, std::size_t count)
      : largest_(largest) {
    const int levels = 1 + static_cast<int>(std::floor(std::log2(largest / smallest)));
    const double corner[2][3] = {{lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}};
    double box = 1;
    for (int k = 0; k < 3; ++k) {
      lower_[k] = domain.period[k] > 0 ? domain.lower[k] : corner[0][k];
      wraps_[k] = domain.period[k] > 0;
      extent_[k] = wraps_[k] ? domain.period[k] : std::max(corner[1][k] - corner[0][k], largest);
      box *= extent_[k];
    }
    // No more cells than a few for each ball.
    const double least = std::cbrt(box / (4.0 * static_cast<double>(count) + 64));
    for (int level = 0; level < levels; ++level) {
      Level grid;
      grid.largest = std::ldexp(largest, -level);
      std::size_t cells = 1;
      for (int k = 0; k < 3; ++k) {
        grid.cells[k] = std::max(1, static_cast<int>(extent_[k] / std::max(2 * grid.largest, least)));
        grid.per_length[k] = grid.cells[k] / extent_[k];
        cells *= static_cast<std::size_t>(grid.cells[k]);
      }
      grid.head.assign(cells, -1);
      levels_.push_back(std::move(grid));
    }
  }

  void insert(Index ball, const Quad& place) {
    Level& level = levels_[static_cast<std::size_t>(level_of(place.w))];
    const double at[3] = {place.x, place.y, place.z};
    std::size_t cell = 0;
    for (int k = 0; k < 3; ++k) {
      int c = static_cast<int>(std::floor((at[k] - lower_[k]) * level.per_length[k]));
      c = wraps_[k] ? wrapped(c, level.cells[k]) : std::clamp(c, 0, level.cells[k] - 1);
      cell = cell * static_cast<std::size_t>(level.cells[k]) + static_cast<std::size_t>(c);
    }
    if (static_cast<std::size_t>(ball) >= next_.size()) next_.resize(static_cast<std::size_t>(ball) + 1 + next_.size() / 2, -1);
    next_[static_cast<std::size_t>(ball)] = level.head[cell];
    level.head[cell] = ball;
    level.any = true;
  }

  void clear() {
    for (Level& level : levels_) std::fill(level.head.begin(), level.head.end(), -1), level.any = false;
  }

  // Calls seen(ball) once for each ball whose surface may lie within `reach` [m] of a place (and for some farther ones).
  template <class Seen>
  void near(const Quad& place, double reach, Seen&& seen) const {
    const double at[3] = {place.x, place.y, place.z};
    for (const Level& level : levels_) {
      if (!level.any) continue;
      int first[3], last[3];
      for (int k = 0; k < 3; ++k) {
        const double from = at[k] - reach - level.largest - lower_[k], to = at[k] + reach + level.largest - lower_[k];
        first[k] = static_cast<int>(std::floor(from * level.per_length[k]));
        last[k] = static_cast<int>(std::floor(to * level.per_length[k]));
        if (wraps_[k]) {
          last[k] = std::min(last[k], first[k] + level.cells[k] - 1);
        } else {
          first[k] = std::clamp(first[k], 0, level.cells[k] - 1);
          last[k] = std::clamp(last[k], 0, level.cells[k] - 1);
        }
      }
      for (int x = first[0]; x <= last[0]; ++x) {
        const int row = wrapped(x, level.cells[0]) * level.cells[1];
        for (int y = first[1]; y <= last[1]; ++y) {
          const auto column = static_cast<std::size_t>(row + wrapped(y, level.cells[1])) * static_cast<std::size_t>(level.cells[2]);
          for (int z = first[2]; z <= last[2]; ++z) {
            Index ball = level.head[column + static_cast<std::size_t>(wrapped(z, level.cells[2]))];
            for (; ball >= 0; ball = next_[static_cast<std::size_t>(ball)]) seen(ball);
          }
        }
      }
    }
  }

  double largest() const { return largest_; }

 private:
  struct Level {
    double largest;  // radius of its balls [m]
    double per_length[3];
    int cells[3];
    bool any = false;
    std::vector<Index> head;  // of the chain of balls in each cell
  };
  static int wrapped(int c, int n) { return c >= 0 && c < n ? c : (c % n + n) % n; }
  int level_of(double radius) const {
    const int level = static_cast<int>(std::floor(std::log2(largest_ / radius)));
    return std::clamp(level, 0, static_cast<int>(levels_.size()) - 1);
  }

  double largest_, lower_[3], extent_[3];
  bool wraps_[3];
  std::vector<Level> levels_;
  std::vector<Index> next_;
};

}  // namespace quern
