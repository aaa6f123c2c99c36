#include "src/output/health.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/output/wall_facets.hpp"

namespace quern {
namespace {

bool finite(const Quad& q) { return std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z); }

// Of those that a test picks, the particle that was inserted first: the answer does not depend on the order in memory.
template <class Test>
Index first_particle(const Particles& p, Test&& test) {
  Index found = -1;
  for (Index i = 0; i < p.owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (test(k) && (found < 0 || p.id[k] < p.id[static_cast<std::size_t>(found)])) found = i;
  }
  return found;
}

}  // namespace

Health::Health(const Simulation& s) : kinetic_(s.ledger.kinetic), potential_(s.ledger.potential), elastic_(s.ledger.elastic) {
  // A plane stretches without end, so that nothing can be said to have left it.
  closed_ = std::any_of(s.walls.begin(), s.walls.end(), [](const Wall& wall) { return wall.surface.index() != 0; }) &&
            std::none_of(s.walls.begin(), s.walls.end(), [](const Wall& wall) { return wall.surface.index() == 0; });
  // Twice the set-up's size: what leaks out of a mill falls past it within a second; what a wall throws about does not.
  reach_ = 2 * surroundings(s.walls, s.particles.position).radius;
  // A press that starts softly gives less in its first steps than rounding does.
  constexpr double strain = 1e-12;
  for (const Bond& bond : s.bonds.list)
    rounding_ += 0.5 * bond.normal_stiffness * std::numbers::pi * bond.radius * bond.radius * bond.length * bond.length * strain * strain;
}

std::optional<std::string> Health::complaint(const Simulation& s) const {
  const Particles& p = s.particles;
  const auto at = [&](Index i) { return static_cast<std::size_t>(i); };
  const std::string when = fmt::format("at t = {:.6g} s (step {})", s.clock.time(), s.clock.step);

  const Index broken = first_particle(p, [&](std::size_t i) { return !finite(p.position[i]) || !finite(p.velocity[i]) || !finite(p.spin[i]); });
  if (broken >= 0) {
    return fmt::format("{} particle {} has no finite position or velocity any more; a smaller time step is the usual cure", when, p.id[at(broken)]);
  }

  if (closed_) {
    const Vec3 centre = surroundings(s.walls, {}).centre;
    const Index gone = first_particle(p, [&](std::size_t i) {
      Vec3 offset = vec(p.position[i]) - centre;
      for (int axis = 0; axis < 3; ++axis)
        if (s.domain.period[axis] > 0) offset[axis] = 0;
      return offset.norm() > reach_;
    });
    if (gone >= 0) {
      const Quad& x = p.position[at(gone)];
      return fmt::format("{} particle {} has left the walls: it is at ({:.4g}, {:.4g}, {:.4g}) m; look for a gap in the walls or take a smaller time step",
                         when, p.id[at(gone)], x.x, x.y, x.z);
    }
  }

  const double gained = -s.ledger.gap();
  const double available = std::max(s.ledger.throughput, kinetic_ + elastic_ + std::max(0.0, potential_ - s.ledger.potential));
  if (gained > 0.5 * available && gained > 0.1 * s.ledger.kinetic && gained > rounding_) {
    const Index fastest = [&] {
      Index best = -1;
      double most = -1;
      for (Index i = 0; i < p.owned; ++i) {
        const Quad& v = p.velocity[at(i)];
        if (const double energy = v.w * dot(xyz(v), xyz(v)); energy > most) most = energy, best = i;
      }
      return best;
    }();
    return fmt::format("{} the particles hold {:.4g} J more than was ever put in, most of it in particle {}; a smaller time step is the usual cure", when,
                       gained, fastest < 0 ? -1 : p.id[at(fastest)]);
  }
  return std::nullopt;
}

}  // namespace quern
