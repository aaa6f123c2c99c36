#include "src/particle/region.hpp"
#include <algorithm>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr double pi = 3.141592653589793;

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

struct Interval {
  double from, to;
};
Interval room(double lower, double upper, double radius, bool joined) {
  const double margin = joined ? 0 : std::min(radius, 0.5 * (upper - lower));
  return {lower + margin, upper - margin};
}

}  // namespace

double volume(const Region& region) {
  return std::visit(Overloaded{[](const CylinderRegion& c) { return pi * c.radius * c.radius * (c.z_1 - c.z_0); },
                               [](const BoxRegion& b) { return (b.upper - b.lower).prod(); },
                               [](const SphereRegion& s) { return 4 * pi / 3 * s.radius * s.radius * s.radius; }},
                    region.shape);
}

void check(const Region& region) {
  const bool valid = std::visit(Overloaded{[](const CylinderRegion& c) { return c.radius > 0 && c.z_1 > c.z_0; },
                                           [](const BoxRegion& b) { return (b.upper.array() > b.lower.array()).all(); },
                                           [](const SphereRegion& s) { return s.radius > 0; }},
                                region.shape);
  if (!valid || !std::isfinite(volume(region))) throw InputError("A region to be filled must have a finite volume above 0.");
}

std::array<bool, 3> joined_directions(const Region& region, const Domain& domain) {
  const Vec3 extent = std::visit(
      Overloaded{[](const CylinderRegion& c) { return Vec3(0, 0, c.z_1 - c.z_0); },
                 [](const BoxRegion& b) { return Vec3(b.upper - b.lower); }, [](const SphereRegion&) { return Vec3(Vec3::Zero()); }},
      region.shape);
  std::array<bool, 3> joined{};
  for (int own = 0; own < 3; ++own) {
    for (int world = 0; world < 3; ++world) {
      const bool along = std::abs(region.pose.axes(world, own)) > 1 - 1e-9;
      const double period = domain.period[world];
      if (along && period > 0 && extent[own] > period * (1 - 1e-9)) joined[static_cast<std::size_t>(own)] = true;
    }
  }
  return joined;
}

double largest_radius(const Region& region, const std::array<bool, 3>& joined) {
  constexpr double unbounded = 1e300;
  return std::visit(Overloaded{[&](const CylinderRegion& c) { return std::min(c.radius, joined[2] ? unbounded : 0.5 * (c.z_1 - c.z_0)); },
                               [&](const BoxRegion& b) {
                                 double least = unbounded;
                                 for (int k = 0; k < 3; ++k) {
                                   if (!joined[static_cast<std::size_t>(k)]) least = std::min(least, 0.5 * (b.upper[k] - b.lower[k]));
                                 }
                                 return least;
                               },
                               [](const SphereRegion& s) { return s.radius; }},
                    region.shape);
}

Vec3 random_place(const Region& region, const std::array<bool, 3>& joined, double radius, RandomStream& random) {
  const auto in_disc = [&](double r) {
    const double rho = std::max(0.0, r) * std::sqrt(random.uniform()), angle = 2 * pi * random.uniform();
    return Vec3(rho * std::cos(angle), rho * std::sin(angle), 0);
  };
  const Vec3 own =
      std::visit(Overloaded{[&](const CylinderRegion& c) {
                              Vec3 p = in_disc(c.radius - radius);
                              const Interval z = room(c.z_0, c.z_1, radius, joined[2]);
                              p.z() = random.uniform(z.from, z.to);
                              return p;
                            },
                            [&](const BoxRegion& b) {
                              Vec3 p;
                              for (int k = 0; k < 3; ++k) {
                                const Interval side = room(b.lower[k], b.upper[k], radius, joined[static_cast<std::size_t>(k)]);
                                p[k] = random.uniform(side.from, side.to);
                              }
                              return p;
                            },
                            [&](const SphereRegion& s) {
                              const double r = std::max(0.0, s.radius - radius) * std::cbrt(random.uniform());
                              const double z = random.uniform(-1, 1), angle = 2 * pi * random.uniform(), rho = std::sqrt(1 - z * z);
                              return Vec3(r * rho * std::cos(angle), r * rho * std::sin(angle), r * z);
                            }},
                 region.shape);
  return region.pose.to_fixed(own);
}

Vec3 nearest_place(const Region& region, const std::array<bool, 3>& joined, double radius, const Vec3& centre) {
  Vec3 p = region.pose.to_local(centre);
  const auto clamp = [&](int k, double lower, double upper) {
    // A joined direction has no ends at all: the image beyond is the other end.
    if (joined[static_cast<std::size_t>(k)]) return;
    const Interval side = room(lower, upper, radius, false);
    p[k] = std::clamp(p[k], side.from, side.to);
  };
  std::visit(Overloaded{[&](const CylinderRegion& c) {
                          const double rho = std::hypot(p.x(), p.y()), most = std::max(0.0, c.radius - radius);
                          if (rho > most) p.head<2>() *= most / rho;
                          clamp(2, c.z_0, c.z_1);
                        },
                        [&](const BoxRegion& b) {
                          for (int k = 0; k < 3; ++k) clamp(k, b.lower[k], b.upper[k]);
                        },
                        [&](const SphereRegion& s) {
                          const double distance = p.norm(), most = std::max(0.0, s.radius - radius);
                          if (distance > most) p *= most / distance;
                        }},
             region.shape);
  return region.pose.to_fixed(p);
}

}  // namespace quern
