// Bodies of many grains: a shape is filled with a dense packing of grains of one or several kinds, which are then bonded.
#pragma once
#include <array>
#include <optional>
#include <utility>
#include <variant>
#include <vector>
#include "bonds/bonds.hpp"
#include "src/particle/packing.hpp"

namespace quern {

// |x/a|^n + |y/b|^n + |z/c|^n ≤ 1, with half axes [m].
struct SuperquadricRegion {
  std::array<double, 3> half_axes{};
  double exponent = 2;
};

// The shape of a body about its own origin, in its own axes. A mesh is closed, its triangles looking outward.
using BodyShape = std::variant<SphereRegion, CylinderRegion, BoxRegion, SuperquadricRegion, Mesh>;

double volume(const BodyShape& shape);   // [m³]
double reach(const BodyShape& shape);    // radius of a ball about the origin that holds the shape [m]

struct GrainPortion {
  std::uint8_t species = 0;
  SizeDistribution sizes;
  double share = 1;  // of the volume of all grains, in proportion
};

struct BodyRequest {
  BodyShape shape;
  std::vector<GrainPortion> portions;
  std::optional<double> solid_fraction;  // wanted; none: as dense as packs easily, 0.54 or, in a body of few grains, less
  std::uint64_t seed = 1;
};

struct Grain {
  Vec3 position = Vec3::Zero();  // in the body's own axes [m]
  double diameter = 0;           // [m]
  std::uint8_t species = 0;
};

// Fills a shape. Spheres, cylinders and boxes are packed within their surface; superquadrics and meshes are cut out of a packed box: the
// grains whose centres lie inside. No grains overlap. Throws InputError with what fits where the fraction cannot be reached, and where a
// grain is larger than the body.
std::vector<Grain> pack_body(const BodyRequest& request);

// Pairs (i < j) of grains that are to be bonded.
using GrainPairs = std::vector<std::pair<Index, Index>>;
// All whose surfaces are nearer than `gap` [m].
GrainPairs near_pairs(const std::vector<Grain>& grains, double gap);
// Of those, the ones that share an edge of the regular triangulation of the grains, weighted by their radii squared.
GrainPairs triangulated_pairs(const std::vector<Grain>& grains, double gap);

// What a body is like.
struct BodyReport {
  std::int64_t grains = 0, bonds = 0;
  double solid_fraction = 0;  // of the shape's volume; 0 without a shape
  double coordination = 0;    // bonds at a grain, mean
  std::int64_t pieces = 0;    // that hang together by bonds
};
BodyReport describe(const std::vector<Grain>& grains, const GrainPairs& pairs, double shape_volume);

}  // namespace quern
