// What rain and dense packing share: the balls to be placed, the places they may have, and trying one at random.
#pragma once
#include <array>
#include <string>
#include <vector>
#include "src/particle/packing.hpp"
#include "src/particle/sphere_grid.hpp"
#include "src/wall/solid.hpp"

namespace quern {

// The balls that are there already, then the new ones, largest first.
struct Heap {
  std::vector<Quad> ball;             // centre and radius [m]
  std::vector<std::uint8_t> species;  // of every ball; 0 for those already there
  std::size_t present = 0;
};

// Diameters and species of all portions; new balls have no place yet. Throws InputError on a request that cannot be.
Heap charge_of(const PackingRequest& request, RandomStream& random);

Packing packing_of(const PackingRequest& request, const Heap& charge);

double reference_volume(const PackingRequest& request);    // [m³]
double solid_volume(const Quad* first, const Quad* last);  // of balls [m³]
Quad wrapped(const Domain& domain, const Quad& ball);      // its image between the domain's ends
Vec3 separation(const Domain& domain, const Quad& from, const Quad& to);

// Where balls may be.
class Site {
 public:
  Site(const PackingRequest& request, const std::vector<Wall>& walls);

  SphereGrid grid_for(const Heap& charge) const;
  Vec3 random_place(double radius, RandomStream& random) const { return quern::random_place(region_, joined_, radius, random); }
  Vec3 nearest_place(double radius, const Vec3& centre) const { return quern::nearest_place(region_, joined_, radius, centre); }
  // Whether a ball overlaps a wall or lies within its solid.
  bool walled(const Vec3& centre, double radius) const;
  // The largest overlap of a ball with a wall [m]; 0: none.
  double wall_overlap(const Vec3& centre, double radius) const;
  // Whether a ball is within `reach` [m] of a wall.
  bool near_wall(const Vec3& centre, double reach) const;
  // Moves a ball off the walls and back into the region.
  Vec3 moved_off(Vec3 centre, double radius) const;

 private:
  const Region& region_;
  const Domain& domain_;
  const std::vector<Wall>& walls_;
  std::array<bool, 3> joined_;
  Solids solids_;
};

// The largest overlap of a ball with those in the grid, as a length [m]; 0: none.
double deepest(const SphereGrid& grid, const std::vector<Quad>& balls, const Domain& domain, const Quad& ball);

// The sentence that ends the errors of both: what fits instead.
std::string amount(const PackingRequest& request, std::int64_t count, double solid);

}  // namespace quern
