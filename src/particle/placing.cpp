#include "src/particle/placing.hpp"
#include <algorithm>
#include <cstdio>
#include <numeric>
#include "src/base/error.hpp"

namespace quern {
namespace {

constexpr double sphere_factor = 4.18879020478639;  // 4π/3

}  // namespace

std::vector<double> diameters_of(const Portion& portion, double reference, RandomStream& random) {
  const int told = (portion.count != 0) + (portion.mass != 0) + (portion.filling != 0);
  if (told != 1) throw InputError("Exactly one of count, mass and filling must be given for what is inserted.");
  if (portion.count < 0 || !(portion.mass >= 0) || !(portion.filling >= 0))
    throw InputError("The amount of what is inserted must not be negative.");
  if (portion.sizes.diameter.empty()) throw InputError("What is inserted has no diameter.");
  double count = static_cast<double>(portion.count);
  if (portion.mass > 0) {
    if (!(portion.density > 0)) throw InputError("A mass to be inserted needs a density above 0.");
    count = std::round(portion.mass / (portion.density * portion.sizes.mean_volume()));
  }
  if (portion.filling > 0) count = std::round(portion.filling * (1 - bulk_porosity) * reference / portion.sizes.mean_volume());
  if (count < 1) throw InputError("The mass or filling of what is inserted is less than half a ball.");
  if (!(count <= 1e9)) throw InputError("More than 1e9 balls would be inserted.");
  return portion.sizes.draw(static_cast<std::int64_t>(count), random);
}

double reference_volume(const PackingRequest& request) {
  return request.reference_volume > 0 ? request.reference_volume : volume(request.region);
}

double solid_volume(const Quad* first, const Quad* last) {
  return sphere_factor * std::accumulate(first, last, 0.0, [](double sum, const Quad& b) { return sum + b.w * b.w * b.w; });
}

Quad wrapped(const Domain& domain, const Quad& ball) {
  double at[3] = {ball.x, ball.y, ball.z};
  for (int k = 0; k < 3; ++k) {
    if (domain.period[k] > 0) at[k] -= domain.period[k] * std::floor((at[k] - domain.lower[k]) / domain.period[k]);
  }
  return {at[0], at[1], at[2], ball.w};
}

Vec3 separation(const Domain& domain, const Quad& from, const Quad& to) {
  return vec(domain.nearest({to.x - from.x, to.y - from.y, to.z - from.z}));
}

Heap charge_of(const PackingRequest& request, RandomStream& random) {
  check(request.region);
  Heap charge;
  charge.ball = request.present;
  charge.present = request.present.size();
  charge.species.assign(charge.present, 0);
  struct Fresh {
    double radius;
    std::uint8_t species;
  };
  std::vector<Fresh> fresh;
  for (const Portion& portion : request.portions) {
    for (double d : diameters_of(portion, reference_volume(request), random)) fresh.push_back({0.5 * d, portion.species});
  }
  std::stable_sort(fresh.begin(), fresh.end(), [](const Fresh& a, const Fresh& b) { return a.radius > b.radius; });
  const double most = largest_radius(request.region, joined_directions(request.region, request.domain));
  if (!fresh.empty() && fresh.front().radius > most) {
    char text[120];
    std::snprintf(text, sizeof text, "A ball of diameter %.4g m does not fit into its region, which holds %.4g m at most.",
                  2 * fresh.front().radius, 2 * most);
    throw InputError(text);
  }
  for (const Fresh& f : fresh) charge.ball.push_back({0, 0, 0, f.radius}), charge.species.push_back(f.species);
  return charge;
}

Packing packing_of(const PackingRequest& request, const Heap& charge) {
  Packing packing;
  for (std::size_t k = charge.present; k < charge.ball.size(); ++k) {
    packing.position.push_back(vec(charge.ball[k]));
    packing.diameter.push_back(2 * charge.ball[k].w);
    packing.species.push_back(charge.species[k]);
  }
  if (request.speed != 0) packing.velocity = request.speed * request.gravity.normalized();
  const double solid = solid_volume(charge.ball.data() + charge.present, charge.ball.data() + charge.ball.size());
  packing.filling = solid / (1 - bulk_porosity) / reference_volume(request);
  return packing;
}

Site::Site(const PackingRequest& request, const std::vector<Wall>& walls)
    : region_(request.region), domain_(request.domain), walls_(walls), joined_(joined_directions(region_, domain_)), solids_(walls) {}

SphereGrid Site::grid_for(const Heap& charge) const {
  // A box about the region: far enough in each direction for its every point.
  Vec3 lower = region_.pose.origin, upper = lower;
  const auto hold = [&](const Vec3& own) {
    const Vec3 p = region_.pose.to_fixed(own);
    lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  };
  const auto hold_box = [&](const Vec3& a, const Vec3& b) {
    for (int corner = 0; corner < 8; ++corner) hold({corner & 1 ? a.x() : b.x(), corner & 2 ? a.y() : b.y(), corner & 4 ? a.z() : b.z()});
  };
  if (const auto* c = std::get_if<CylinderRegion>(&region_.shape))
    hold_box({-c->radius, -c->radius, c->z_0}, {c->radius, c->radius, c->z_1});
  if (const auto* b = std::get_if<BoxRegion>(&region_.shape)) hold_box(b->lower, b->upper);
  if (const auto* s = std::get_if<SphereRegion>(&region_.shape)) hold_box(Vec3::Constant(-s->radius), Vec3::Constant(s->radius));
  double smallest = 1e300, largest = 0;
  for (const Quad& ball : charge.ball) smallest = std::min(smallest, ball.w), largest = std::max(largest, ball.w);
  return {domain_, {lower.x(), lower.y(), lower.z(), 0}, {upper.x(), upper.y(), upper.z(), 0}, smallest, largest, charge.ball.size()};
}

bool Site::near_wall(const Vec3& centre, double reach) const {
  Touch touches[most_touches];
  return std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) { return touch_wall(wall, centre, reach, touches) > 0; });
}

bool Site::walled(const Vec3& centre, double radius) const { return near_wall(centre, radius) || solids_.contain(centre); }

double Site::wall_overlap(const Vec3& centre, double radius) const {
  Touch touches[most_touches];
  double most = 0;
  for (const Wall& wall : walls_) {
    const int count = touch_wall(wall, centre, radius, touches);
    for (int k = 0; k < count; ++k) most = std::max(most, radius - touches[k].distance);
  }
  if (solids_.contain(centre)) most = std::max(most, radius);
  return most;
}

Vec3 Site::moved_off(Vec3 centre, double radius) const {
  Touch touches[most_touches];
  for (const Wall& wall : walls_) {
    const int count = touch_wall(wall, centre, radius, touches);
    const Vec3 before = centre;
    for (int k = 0; k < count; ++k) {
      // What the pushes of the other touches have already given counts.
      const double missing = radius - touches[k].distance - (centre - before).dot(touches[k].normal);
      if (missing > 0) centre += missing * touches[k].normal;
    }
  }
  return nearest_place(radius, centre);
}

double deepest(const SphereGrid& grid, const std::vector<Quad>& balls, const Domain& domain, const Quad& ball) {
  double most = 0;
  grid.near(ball, ball.w, [&](Index other) {
    const Quad& b = balls[static_cast<std::size_t>(other)];
    const double sum = b.w + ball.w, squared = separation(domain, ball, b).squaredNorm();
    if (squared < sum * sum) most = std::max(most, sum - std::sqrt(squared));
  });
  return most;
}

std::string amount(const PackingRequest& request, std::int64_t count, double solid) {
  char text[160];
  std::snprintf(text, sizeof text, "%lld balls (filling %.3g)", static_cast<long long>(count),
                solid / (1 - bulk_porosity) / reference_volume(request));
  return text;
}

double largest_overlap(const std::vector<Quad>& balls, const std::vector<Wall>& walls, const Domain& domain) {
  if (balls.empty()) return 0;
  PackingRequest request;
  request.domain = domain;
  Vec3 lower = vec(balls.front()), upper = lower;
  for (const Quad& ball : balls) lower = lower.cwiseMin(vec(ball)), upper = upper.cwiseMax(vec(ball));
  request.region.shape = BoxRegion{lower, upper};
  const Site site(request, walls);
  Heap charge;
  charge.ball = balls;
  SphereGrid grid = site.grid_for(charge);
  double most = 0;
  for (std::size_t k = 0; k < balls.size(); ++k) {
    const Quad ball = wrapped(domain, balls[k]);
    charge.ball[k] = ball;
    grid.near(ball, ball.w, [&](Index other) {
      const Quad& b = charge.ball[static_cast<std::size_t>(other)];
      const double sum = b.w + ball.w, squared = separation(domain, ball, b).squaredNorm();
      if (squared < sum * sum) most = std::max(most, (sum - std::sqrt(squared)) / std::min(b.w, ball.w));
    });
    most = std::max(most, site.wall_overlap(vec(ball), ball.w) / ball.w);
    grid.insert(static_cast<Index>(k), ball);
  }
  return most;
}

}  // namespace quern
