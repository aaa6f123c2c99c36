#include "src/particle/packing.hpp"
#include <algorithm>
#include <tuple>
#include "src/base/error.hpp"
#include "src/particle/placing.hpp"

namespace quern {
namespace {

constexpr double start_fraction = 0.54;  // solid fraction of the part of the region where the balls start, if there is room
constexpr double densest = 0.74;         // solid fraction of the densest packing of equal balls
constexpr double usual_fraction = 0.58;  // what a random packing reaches without trouble
constexpr int start_tries = 12;          // places tried for each ball, the best taken
constexpr int most_tries = 10000;        // for a place without a wall
constexpr double margin = 0.01;          // pushed this much farther apart than touching, so that pushing comes to an end
constexpr double relaxation = 1.4;       // of a push, against the overlap (over-relaxation spreads a push through the packing sooner)
constexpr double most_pushes = 3e8;      // sweeps × balls, within which a packing that is possible comes apart

// How the region's free volume lies in height.
struct Heights {
  Vec3 down;
  double free_volume = 0;      // [m³]
  std::vector<double> height;  // of points spread evenly over the free volume, ascending [m]

  // Below this lies the given volume.
  double below(double wanted) const {
    const double rank = wanted / free_volume * static_cast<double>(height.size());
    return rank >= static_cast<double>(height.size()) ? 1e300 : height[static_cast<std::size_t>(rank)];
  }
};

Heights heights_of(const PackingRequest& request, const Site& site, RandomStream& random) {
  constexpr int points = 20000;
  Heights result;
  result.down = request.gravity.norm() > 0 ? request.gravity.normalized().eval() : Vec3(0, 0, -1);
  const double dot_size = 1e-9 * std::cbrt(volume(request.region));
  for (int k = 0; k < points; ++k) {
    const Vec3 p = site.random_place(0, random);
    if (!site.walled(p, dot_size)) result.height.push_back(-result.down.dot(p));
  }
  std::sort(result.height.begin(), result.height.end());
  result.free_volume = volume(request.region) * static_cast<double>(result.height.size()) / points;
  return result;
}

// Gives each new ball the best of some places below a height. Balls come largest first, so that the small find the gaps.
void place_below(double height, const Heights& heights, const PackingRequest& request, const Site& site, RandomStream& random,
                 Heap& charge) {
  SphereGrid grid = site.grid_for(charge);
  for (std::size_t k = 0; k < charge.present; ++k) grid.insert(static_cast<Index>(k), charge.ball[k]);
  for (std::size_t k = charge.present; k < charge.ball.size(); ++k) {
    const double radius = charge.ball[k].w;
    double least = 1e300;
    // Far more places are above the height than below when the filling is small; those cost little.
    for (int tries = 0, outside = 0; least > 0 && (tries < start_tries || least == 1e300) && tries < most_tries;) {
      const Vec3 place = site.random_place(radius, random);
      if (-heights.down.dot(place) > height && ++outside < 100000) continue;
      ++tries;
      const Quad ball = wrapped(request.domain, {place.x(), place.y(), place.z(), radius});
      const double overlap = deepest(grid, charge.ball, request.domain, ball);
      if (overlap >= least || site.walled(vec(ball), radius)) continue;
      least = overlap, charge.ball[k] = ball;
    }
    if (least == 1e300) throw InputError("No place without a wall was found for a ball in its region.");
    grid.insert(static_cast<Index>(k), charge.ball[k]);
  }
}

// New balls that are near in space become near in memory.
void sort_in_space(Heap& charge) {
  const std::size_t count = charge.ball.size() - charge.present;
  double cell = 0;
  for (std::size_t k = charge.present; k < charge.ball.size(); ++k) cell += 4 * charge.ball[k].w / static_cast<double>(count);
  struct Key {
    double x, y, z;
    std::size_t from;
  };
  std::vector<Key> keys;
  for (std::size_t k = charge.present; k < charge.ball.size(); ++k) {
    const Quad& b = charge.ball[k];
    keys.push_back({std::floor(b.x / cell), std::floor(b.y / cell), std::floor(b.z / cell), k});
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return std::tie(a.x, a.y, a.z, a.from) < std::tie(b.x, b.y, b.z, b.from); });
  Heap sorted = charge;
  for (std::size_t k = 0; k < count; ++k) {
    sorted.ball[charge.present + k] = charge.ball[keys[k].from];
    sorted.species[charge.present + k] = charge.species[keys[k].from];
  }
  charge = std::move(sorted);
}

// Overlapping balls, pushed apart pair by pair. A smaller ball yields to a larger one, all yield to walls and to balls that were there.
class Pushing {
 public:
  Pushing(const PackingRequest& request, const Site& site, Heap& charge)
      : domain_(request.domain), site_(site), charge_(charge), grid_(site.grid_for(charge)) {
    double smallest = 1e300;
    for (const Quad& ball : charge_.ball) smallest = std::min(smallest, ball.w);
    skin_ = 0.4 * smallest;
    find_neighbours();
  }

  // One push for each pair that is nearer than it should be, then the walls. Returns whether nothing overlapped any more.
  bool sweep() {
    if (moved_too_far()) find_neighbours();
    before_ = charge_.ball;
    bool clear = true;
    for (Index i = fixed(); i < size(); ++i) {
      for (std::size_t k = first_[static_cast<std::size_t>(i - fixed())]; k < first_[static_cast<std::size_t>(i - fixed()) + 1]; ++k) {
        if (push(at(i), at(neighbour_[k]), neighbour_[k] < fixed())) clear = false;
      }
    }
    for (Index i = fixed(); i < size(); ++i) {
      // A ball whose centre moves by less than its radius does not change sides of a wall.
      Quad& ball = at(i);
      const Vec3 start = vec(before_[static_cast<std::size_t>(i)]), way = vec(ball) - start;
      const double length = way.norm(), most = 0.5 * ball.w;
      set(ball, site_.nearest_place(ball.w, length > most ? Vec3(start + most / length * way) : vec(ball)));
    }
    for (Index i : at_walls_) set(at(i), site_.moved_off(vec(at(i)), at(i).w * (1 + 0.5 * margin)));
    return clear;
  }

  // The largest overlap now, in radii of the smaller ball.
  double overlap() {
    find_neighbours();
    double most = 0;
    for (Index i = fixed(); i < size(); ++i) {
      for (std::size_t k = first_[static_cast<std::size_t>(i - fixed())]; k < first_[static_cast<std::size_t>(i - fixed()) + 1]; ++k) {
        const Quad &a = at(i), &b = at(neighbour_[k]);
        most = std::max(most, (a.w + b.w - separation(domain_, a, b).norm()) / std::min(a.w, b.w));
      }
    }
    for (Index i : at_walls_) most = std::max(most, site_.wall_overlap(vec(at(i)), at(i).w) / at(i).w);
    return most;
  }

 private:
  Index fixed() const { return static_cast<Index>(charge_.present); }
  Index size() const { return static_cast<Index>(charge_.ball.size()); }
  Quad& at(Index i) { return charge_.ball[static_cast<std::size_t>(i)]; }

  bool moved_too_far() {
    double most = 0;
    for (std::size_t k = charge_.present; k < charge_.ball.size(); ++k)
      most = std::max(most, (vec(charge_.ball[k]) - vec(listed_[k])).squaredNorm());
    return most > 0.25 * skin_ * skin_;
  }

  void find_neighbours() {
    grid_.clear();
    for (Index i = 0; i < size(); ++i) {
      at(i) = wrapped(domain_, at(i));
      grid_.insert(i, at(i));
    }
    listed_ = charge_.ball;
    first_.assign(1, 0);
    neighbour_.clear();
    at_walls_.clear();
    for (Index i = fixed(); i < size(); ++i) {
      const Quad ball = at(i);
      const double reach = ball.w * (1 + margin) + skin_;
      grid_.near(ball, reach, [&](Index other) {
        const Quad& b = at(other);
        const double sum = reach + b.w * (1 + margin);
        if ((other < fixed() || other > i) && separation(domain_, ball, b).squaredNorm() < sum * sum) neighbour_.push_back(other);
      });
      first_.push_back(neighbour_.size());
      if (site_.near_wall(vec(ball), reach)) at_walls_.push_back(i);
    }
  }

  // Returns whether the two balls truly overlapped.
  bool push(Quad& a, Quad& b, bool b_fixed) {
    const Vec3 apart = separation(domain_, a, b);
    const double sum = a.w + b.w, wanted = sum * (1 + margin), squared = apart.squaredNorm();
    if (squared >= wanted * wanted) return false;
    const double distance = std::sqrt(squared), push = relaxation * (wanted - distance);
    const Vec3 normal = distance > 1e-12 * sum ? (apart / distance).eval() : Vec3::UnitZ().eval();
    const double share_a = b_fixed ? 1 : b.w / (a.w + b.w);
    add(a, -share_a * push * normal);
    if (!b_fixed) add(b, (1 - share_a) * push * normal);
    return distance < sum;
  }

  const Domain& domain_;
  const Site& site_;
  Heap& charge_;
  SphereGrid grid_;
  double skin_ = 0;
  std::vector<Quad> listed_, before_;  // where the balls were when the neighbours were found, and before a sweep
  std::vector<std::size_t> first_;     // of each new ball's neighbours
  std::vector<Index> neighbour_, at_walls_;
};

// Whether the balls of the charge come apart.
bool pack(const PackingRequest& request, const Site& site, const Heights& heights, RandomStream& random, Heap& charge) {
  const double solid = solid_volume(charge.ball.data(), charge.ball.data() + charge.ball.size());
  place_below(heights.below(solid / start_fraction), heights, request, site, random, charge);
  sort_in_space(charge);
  Pushing pushing(request, site, charge);
  const double sweeps = std::clamp(most_pushes / static_cast<double>(charge.ball.size()), 300.0, 3000.0);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (pushing.sweep() && pushing.overlap() <= 0) return true;
  }
  return false;
}

}  // namespace

Packing pack_dense(const PackingRequest& request, const std::vector<Wall>& walls) {
  RandomStream random(request.seed, 2);
  Heap charge = charge_of(request, random);
  if (charge.ball.size() == charge.present) return {};
  for (std::size_t k = 0; k < charge.present; ++k) charge.ball[k] = wrapped(request.domain, charge.ball[k]);
  const Site site(request, walls);
  const Heights heights = heights_of(request, site, random);
  const Quad *all = charge.ball.data(), *fresh = all + charge.present, *end = all + charge.ball.size();
  const double solid = solid_volume(fresh, end), present = solid_volume(all, fresh);
  const auto asked = static_cast<std::int64_t>(end - fresh);
  const bool one_size = charge.ball[charge.present].w < 1.2 * charge.ball.back().w;
  if (solid + present <= (one_size ? densest : 0.9) * heights.free_volume && pack(request, site, heights, random, charge))
    return packing_of(request, charge);
  const double usual = std::max(0.0, usual_fraction * heights.free_volume - present), part = std::min(0.95, usual / solid);
  throw InputError("The region does not hold " + amount(request, asked, solid) + "; about " +
                   amount(request, static_cast<std::int64_t>(part * static_cast<double>(asked)), part * solid) + " fit.");
}

}  // namespace quern
