#include "shapes/superquadric.hpp"
#include <boost/math/special_functions/beta.hpp>
#include <map>
#include <numbers>

namespace quern {
namespace {

// ∫₀¹ t^k (1 − t^n)^m dt
double moment(double k, double n, double m) { return boost::math::beta((k + 1) / n, m + 1) / n; }

// The largest of u²x² + v²y² on x^n + y^n = 1 is this squared, by Hölder's inequality.
double farthest(double u, double v, double n) {
  const double large = std::max(u, v), ratio = std::min(u, v) / large;
  if (n == 2) return large;
  const double s = 2 * n / (n - 2);
  return large * std::pow(1 + std::pow(ratio, s), 1 / s);
}

}  // namespace

Superquadric make_superquadric(const Vec3& semi_axes, double n1, double n2) {
  const double a = semi_axes.x(), b = semi_axes.y(), c = semi_axes.z();
  Superquadric shape;
  shape.gauge = {semi_axes.cwiseInverse(), n1, n2};
  shape.support = {semi_axes, n1 / (n1 - 1), n2 / (n2 - 1)};
  shape.bounding_radius = farthest(farthest(a, b, n2), c, n1);
  // Slices across z are superellipses scaled by (1 − |z/c|^{n₁})^{1/n₁}.
  const double slice = 4 * a * b * moment(0, n2, 1 / n2), second = 4 * a * b * moment(2, n2, 1 / n2);
  const double along_2 = 2 * c * moment(0, n1, 2 / n1), along_4 = 2 * c * moment(0, n1, 4 / n1);
  shape.volume = slice * along_2;
  const double xx = a * a * second * along_4, yy = b * b * second * along_4, zz = slice * c * c * 2 * c * moment(2, n1, 2 / n1);
  shape.inertia = {yy + zz, zz + xx, xx + yy};
  shape.volume_radius = std::cbrt(0.75 * shape.volume / std::numbers::pi);
  return shape;
}

Curvature Superquadric::curvature(const Vec3& place) const {
  const NestedNorm::Second at = gauge.second(place);
  const double slope = at.gradient.norm();
  const Mat3 axes = Rotation::FromTwoVectors(Vec3::UnitZ(), at.gradient).toRotationMatrix();
  const Eigen::Matrix2d bend = (axes.transpose() * at.hessian * axes).topLeftCorner<2, 2>() * (at.value / slope);
  const double mean = 0.5 * bend.trace(), half = std::hypot(0.5 * (bend(0, 0) - bend(1, 1)), bend(0, 1));
  // The smaller one by the product, which does not cancel.
  const double largest = mean + half;
  return {largest, largest > 0 ? std::max(0.0, bend.determinant() / largest) : 0};
}

SurfaceMesh surface_mesh(const Superquadric& shape, int cells) {
  SurfaceMesh mesh;
  std::map<std::array<int, 3>, Index> known;  // corners by their place on the cube's lattice
  const auto corner = [&](const std::array<int, 3>& at) {
    const auto [entry, fresh] = known.try_emplace(at, static_cast<Index>(mesh.points.size()));
    if (fresh) {
      // Equal angles, not equal lengths: cells of a sphere are then nearly alike.
      const auto along = [&](int k) { return std::tan(0.25 * std::numbers::pi * (2.0 * k / cells - 1)); };
      const Vec3 towards = shape.semi_axes().cwiseProduct(Vec3(along(at[0]), along(at[1]), along(at[2])));
      mesh.points.push_back(towards / shape.gauge.value(towards));
    }
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {0, cells}) {
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> place{};
            place[axis] = side, place[(axis + 1) % 3] = u, place[(axis + 2) % 3] = v;
            return corner(place);
          };
          const Index p = at(i, j), q = at(i + 1, j), r = at(i + 1, j + 1), s = at(i, j + 1);
          if (side > 0)
            mesh.triangles.insert(mesh.triangles.end(), {{p, q, r}, {p, r, s}});
          else
            mesh.triangles.insert(mesh.triangles.end(), {{p, r, q}, {p, s, r}});
        }
      }
    }
  }
  return mesh;
}

}  // namespace quern
