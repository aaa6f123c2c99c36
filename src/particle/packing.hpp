// Filling a region with balls that touch neither each other nor a wall.
#pragma once
#include <cstdint>
#include <vector>
#include "src/base/domain.hpp"
#include "src/particle/region.hpp"
#include "src/particle/size_distribution.hpp"
#include "src/wall/walls.hpp"

namespace quern {

// Bulk porosity by which a filling is defined: bulk volume of a charge = volume of its balls / (1 − 0.4).
inline constexpr double bulk_porosity = 0.4;

// How much of a species; exactly one of the three is told, the others stay 0.
struct Portion {
  std::uint8_t species = 0;
  double density = 0;  // [kg/m³]; needed for a mass only
  SizeDistribution sizes;
  std::int64_t count = 0;
  double mass = 0;     // [kg]; the count is the nearest for the mean ball
  double filling = 0;  // bulk volume of the portion / reference volume
};

struct PackingRequest {
  Region region;
  std::vector<Portion> portions;
  double reference_volume = 0;  // of which a filling is a fraction [m³]; 0: the region's
  Vec3 gravity{0, 0, -9.81};    // dense packing starts where gravity points; rain falls along it [m/s²]
  double speed = 0;             // at the start, along gravity [m/s]
  Domain domain;                // its periodic directions
  std::vector<Quad> present;    // balls that are there already: centre and radius [m]
  std::uint64_t seed = 1;
};

struct Packing {
  std::vector<Vec3> position;    // centres [m]
  std::vector<double> diameter;  // [m]
  std::vector<std::uint8_t> species;
  Vec3 velocity = Vec3::Zero();  // of all of them [m/s]
  double filling = 0;            // bulk volume of all these balls / reference volume
  double largest_overlap = 0;    // of two balls or of a ball and a wall, in radii of the (smaller) ball; 0: none
};

// The diameters of a portion; the number is the nearest to its amount. Throws InputError if no amount or several are told.
std::vector<double> diameters_of(const Portion& portion, double reference_volume, RandomStream& random);

// Places balls one after another, largest first, at random in the region's free volume (random sequential addition). For
// charges that fall into place; up to about a third of the free volume fits. Throws InputError that says how much fits.
Packing pack_rain(const PackingRequest& request, const std::vector<Wall>& walls);

// Places balls in the lower part of the region, then pushes overlapping ones apart (overdamped) until none overlap. Throws
// InputError that says how much fits.
Packing pack_dense(const PackingRequest& request, const std::vector<Wall>& walls);

// The largest overlap among balls, and of balls with walls, in radii of the (smaller) ball; 0 if nothing overlaps. A ball whose
// centre lies within a closed mesh overlaps by one radius at least.
double largest_overlap(const std::vector<Quad>& balls, const std::vector<Wall>& walls, const Domain& domain);

}  // namespace quern
