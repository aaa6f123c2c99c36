#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Regular_triangulation_cell_base_3.h>
#include <CGAL/Regular_triangulation_vertex_base_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <algorithm>
#include "bonds/agglomerate.hpp"

namespace quern {

GrainPairs triangulated_pairs(const std::vector<Grain>& grains, double gap) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertex = CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
  using Triangulation = CGAL::Regular_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, CGAL::Regular_triangulation_cell_base_3<Kernel>>>;
  std::vector<std::pair<Triangulation::Weighted_point, Index>> points;
  for (std::size_t k = 0; k < grains.size(); ++k) {
    const Vec3& x = grains[k].position;
    points.push_back({{{x.x(), x.y(), x.z()}, 0.25 * grains[k].diameter * grains[k].diameter}, static_cast<Index>(k)});
  }
  const Triangulation triangulation(points.begin(), points.end());
  GrainPairs pairs;
  for (auto edge = triangulation.finite_edges_begin(); edge != triangulation.finite_edges_end(); ++edge) {
    const Index i = edge->first->vertex(edge->second)->info(), j = edge->first->vertex(edge->third)->info();
    const Grain &a = grains[static_cast<std::size_t>(i)], &b = grains[static_cast<std::size_t>(j)];
    if ((b.position - a.position).norm() < 0.5 * (a.diameter + b.diameter) + gap) pairs.emplace_back(std::min(i, j), std::max(i, j));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace quern
