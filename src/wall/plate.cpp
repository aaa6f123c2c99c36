#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <algorithm>
#include <cmath>
#include "src/wall/mesh_shapes.hpp"

namespace quern {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>>;

double twice_area(const Outline& line) {
  double sum = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const auto &a = line[k], &b = line[(k + 1) % line.size()];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

// The same line with what it bounds on its left.
Outline turned(Outline line, bool hole) {
  if ((twice_area(line) > 0) == hole) std::reverse(line.begin(), line.end());
  return line;
}

// Whether a point lies inside an odd number of lines: in the plate.
bool within(const std::vector<Outline>& lines, double x, double y) {
  bool odd = false;
  for (const Outline& line : lines) {
    for (std::size_t k = 0; k < line.size(); ++k) {
      const auto &a = line[k], &b = line[(k + 1) % line.size()];
      if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) odd = !odd;
    }
  }
  return odd;
}

}  // namespace

Outline circle(double radius, const std::array<double, 2>& centre, int facets) {
  Outline line;
  for (int k = 0; k < facets; ++k) {
    const double angle = 2 * M_PI * k / facets;
    line.push_back({centre[0] + radius * std::cos(angle), centre[1] + radius * std::sin(angle)});
  }
  return line;
}

Mesh plate(const Outline& outline, const std::vector<Outline>& holes, double z_0, double z_1) {
  std::vector<Outline> lines{turned(outline, false)};
  for (const Outline& hole : holes) lines.push_back(turned(hole, true));

  std::vector<Vec3> vertices;  // two to a corner: at z_0 and at z_1
  std::vector<std::array<Index, 3>> triangles;
  Triangulation flat;
  for (const Outline& line : lines) {
    const auto first = static_cast<Index>(vertices.size());
    std::vector<Triangulation::Vertex_handle> corners;
    for (const auto& [x, y] : line) {
      corners.push_back(flat.insert({x, y}));
      corners.back()->info() = static_cast<Index>(vertices.size());
      vertices.emplace_back(x, y, z_0);
      vertices.emplace_back(x, y, z_1);
    }
    const auto size = static_cast<Index>(line.size());
    for (Index k = 0; k < size; ++k) {
      const Index low = first + 2 * k, next = first + 2 * ((k + 1) % size);
      flat.insert_constraint(corners[static_cast<std::size_t>(k)], corners[static_cast<std::size_t>((k + 1) % size)]);
      triangles.push_back({low, next, next + 1});
      triangles.push_back({low, next + 1, low + 1});
    }
  }
  for (const auto face : flat.finite_face_handles()) {
    const auto middle = CGAL::centroid(flat.triangle(face));
    if (!within(lines, middle.x(), middle.y())) continue;
    const Index a = face->vertex(0)->info(), b = face->vertex(1)->info(), c = face->vertex(2)->info();
    triangles.push_back({a, c, b});
    triangles.push_back({a + 1, b + 1, c + 1});
  }
  return make_mesh(std::move(vertices), std::move(triangles));
}

}  // namespace quern
