#include "src/base/error.hpp"
#include "src/particle/placing.hpp"

namespace quern {

// After this many places tried in vain the free volume counts as full.
constexpr int most_tries = 3000;

Packing pack_rain(const PackingRequest& request, const std::vector<Wall>& walls) {
  RandomStream random(request.seed, 1);
  Heap charge = charge_of(request, random);
  if (charge.ball.empty()) return {};
  const Site site(request, walls);
  SphereGrid grid = site.grid_for(charge);
  for (std::size_t k = 0; k < charge.present; ++k)
    grid.insert(static_cast<Index>(k), charge.ball[k] = wrapped(request.domain, charge.ball[k]));
  for (std::size_t k = charge.present; k < charge.ball.size(); ++k) {
    const double radius = charge.ball[k].w;
    bool placed = false;
    for (int tries = 0; tries < most_tries && !placed; ++tries) {
      const Vec3 place = site.random_place(radius, random);
      const Quad ball = wrapped(request.domain, {place.x(), place.y(), place.z(), radius});
      placed = deepest(grid, charge.ball, request.domain, ball) == 0 && !site.walled(vec(ball), radius);
      if (placed) grid.insert(static_cast<Index>(k), charge.ball[k] = ball);
    }
    if (!placed) {
      const Quad* first = charge.ball.data() + charge.present;
      const auto fitted = static_cast<std::int64_t>(k - charge.present),
                 asked = static_cast<std::int64_t>(charge.ball.size() - charge.present);
      throw InputError("Only " + amount(request, fitted, solid_volume(first, first + fitted)) + " of " +
                       amount(request, asked, solid_volume(first, first + asked)) +
                       " fit into the region when rained at random, largest first. Dense packing fits more.");
    }
  }
  return packing_of(request, charge);
}

}  // namespace quern
