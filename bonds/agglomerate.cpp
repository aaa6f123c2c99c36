#include "bonds/agglomerate.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "bonds/pieces.hpp"
#include "src/base/error.hpp"
#include "src/wall/solid.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double signed_volume(const Mesh& mesh) {
  double sixfold = 0;
  for (const auto& t : mesh.triangles) sixfold += mesh.vertices[at(t[0])].dot(mesh.vertices[at(t[1])].cross(mesh.vertices[at(t[2])]));
  return sixfold / 6;
}

Region region_of(const BodyShape& shape) {
  Region region;
  if (const auto* sphere = std::get_if<SphereRegion>(&shape)) region.shape = *sphere;
  if (const auto* cylinder = std::get_if<CylinderRegion>(&shape)) region.shape = *cylinder;
  if (const auto* box = std::get_if<BoxRegion>(&shape)) region.shape = *box;
  if (const auto* quadric = std::get_if<SuperquadricRegion>(&shape)) {
    const Vec3 corner(quadric->half_axes[0], quadric->half_axes[1], quadric->half_axes[2]);
    region.shape = BoxRegion{-corner, corner};
  }
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    BoxRegion box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
    for (const Vec3& v : mesh->vertices) box.lower = box.lower.cwiseMin(v), box.upper = box.upper.cwiseMax(v);
    region.shape = box;
  }
  return region;
}

// Whether only grains whose centres are inside stay.
bool is_cut_out(const BodyShape& shape) { return std::holds_alternative<SuperquadricRegion>(shape) || std::holds_alternative<Mesh>(shape); }

// Grains of a packed box that lie in the shape.
void cut_out(const BodyShape& shape, std::vector<Grain>& grains) {
  if (const auto* quadric = std::get_if<SuperquadricRegion>(&shape)) {
    const double a = quadric->half_axes[0], b = quadric->half_axes[1], c = quadric->half_axes[2];
    const double n = quadric->exponent;
    std::erase_if(grains, [&](const Grain& g) {
      return std::pow(std::abs(g.position.x() / a), n) + std::pow(std::abs(g.position.y() / b), n) + std::pow(std::abs(g.position.z() / c), n) > 1;
    });
  }
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    std::vector<Wall> walls(1);
    walls[0].surface = *mesh;
    const Solids solid(walls);
    std::erase_if(grains, [&](const Grain& g) { return !solid.contain(g.position); });
  }
}

// A box that is packed so that a shape may be cut out of it needs room around it: grains at its own walls lie in layers.
void widen(Region& region, double by) {
  auto& box = std::get<BoxRegion>(region.shape);
  box.lower -= Vec3::Constant(by), box.upper += Vec3::Constant(by);
}

std::vector<Grain> pack_body(const BodyRequest& request, double solid_fraction) {
  double largest = 0, shares = 0;
  for (const GrainPortion& portion : request.portions) largest = std::max(largest, portion.sizes.largest()), shares += portion.share;
  if (request.portions.empty() || !(shares > 0)) throw InputError("an agglomerate needs grains; found none");
  if (!(solid_fraction > 0 && solid_fraction < 0.74))
    throw InputError(fmt::format("found a solid fraction of {:g}; allowed is more than 0 and less than 0.74", solid_fraction));
  PackingRequest packing;
  packing.region = region_of(request.shape);
  check(packing.region);
  const double room = largest_radius(packing.region, {false, false, false});
  if (0.5 * largest > room)
    throw InputError(fmt::format("found grains of {:.4g} m, larger than the body, which holds none above {:.4g} m", largest, 2 * room));
  if (is_cut_out(request.shape)) widen(packing.region, 3 * largest);
  const double solid = solid_fraction * volume(packing.region);
  for (const GrainPortion& portion : request.portions) {
    Portion one;
    one.species = portion.species;
    one.sizes = portion.sizes;
    one.count = std::llround(portion.share / shares * solid / portion.sizes.mean_volume());
    if (one.count == 0)
      throw InputError(fmt::format("found a share of {:g} of the grains, less than one grain of {:.4g} m", portion.share / shares, portion.sizes.largest()));
    packing.portions.push_back(one);
  }
  packing.seed = request.seed;
  Packing packed;
  try {
    packed = pack_dense(packing, {});
  } catch (const InputError& e) {
    throw InputError(fmt::format("found a solid fraction of {:g}, which cannot be packed; allowed is less, or none for as dense as packs easily. {}", solid_fraction, e.what()));
  }
  std::vector<Grain> grains;
  for (std::size_t k = 0; k < packed.position.size(); ++k) grains.push_back({packed.position[k], packed.diameter[k], packed.species[k]});
  cut_out(request.shape, grains);
  if (grains.empty()) throw InputError("found no grain in the body; allowed are smaller grains, or a larger body");
  return grains;
}

}  // namespace

double volume(const BodyShape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return std::abs(signed_volume(*mesh));
  if (const auto* quadric = std::get_if<SuperquadricRegion>(&shape)) {
    // Jaklič et al. 2000 with both exponents n: 8abc Γ(1 + 1/n)³/Γ(1 + 3/n).
    const double n = quadric->exponent;
    return 8 * quadric->half_axes[0] * quadric->half_axes[1] * quadric->half_axes[2] * std::pow(std::tgamma(1 + 1 / n), 3) / std::tgamma(1 + 3 / n);
  }
  return volume(region_of(shape));
}

double reach(const BodyShape& shape) {
  if (const auto* sphere = std::get_if<SphereRegion>(&shape)) return sphere->radius;
  if (const auto* cylinder = std::get_if<CylinderRegion>(&shape)) return std::hypot(cylinder->radius, std::max(std::abs(cylinder->z_0), std::abs(cylinder->z_1)));
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    double farthest = 0;
    for (const Vec3& v : mesh->vertices) farthest = std::max(farthest, v.norm());
    return farthest;
  }
  const auto box = std::get<BoxRegion>(region_of(shape).shape);
  return box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
}

std::vector<Grain> pack_body(const BodyRequest& request) {
  if (request.solid_fraction) return pack_body(request, *request.solid_fraction);
  constexpr double easy = 0.54, hardly = 0.3;
  for (double fraction = easy;; fraction *= 0.97) {
    try {
      return pack_body(request, fraction);
    } catch (const InputError&) {
      if (fraction < hardly) throw;
    }
  }
}

GrainPairs near_pairs(const std::vector<Grain>& grains, double gap) {
  std::vector<Index> order(grains.size());
  double largest = 0;
  for (std::size_t k = 0; k < grains.size(); ++k) order[k] = static_cast<Index>(k), largest = std::max(largest, grains[k].diameter);
  // Swept along x.
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return grains[at(a)].position.x() < grains[at(b)].position.x(); });
  GrainPairs pairs;
  for (std::size_t m = 0; m < order.size(); ++m) {
    const Grain& a = grains[at(order[m])];
    for (std::size_t n = m + 1; n < order.size(); ++n) {
      const Grain& b = grains[at(order[n])];
      if (b.position.x() - a.position.x() > 0.5 * (a.diameter + largest) + gap) break;
      if ((b.position - a.position).norm() < 0.5 * (a.diameter + b.diameter) + gap) pairs.emplace_back(std::min(order[m], order[n]), std::max(order[m], order[n]));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

BodyReport describe(const std::vector<Grain>& grains, const GrainPairs& pairs, double shape_volume) {
  BodyReport report;
  report.grains = static_cast<std::int64_t>(grains.size());
  report.bonds = static_cast<std::int64_t>(pairs.size());
  double solid = 0;
  for (const Grain& g : grains) solid += std::numbers::pi / 6 * g.diameter * g.diameter * g.diameter;
  if (shape_volume > 0) report.solid_fraction = solid / shape_volume;
  if (!grains.empty()) report.coordination = 2.0 * static_cast<double>(report.bonds) / static_cast<double>(report.grains);
  Pieces pieces(grains.size());
  for (const auto& [i, j] : pairs) pieces.join(i, j);
  report.pieces = pieces.count();
  return report;
}

}  // namespace quern
