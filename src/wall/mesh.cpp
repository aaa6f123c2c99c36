#include "src/wall/mesh.hpp"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cmath>
#include <limits>
#include <numeric>

namespace quern {
namespace {

constexpr Index leaf_size = 4;

// Which part of a triangle a closest point lies on; a wider part wins when distances cannot tell.
enum class Part { face, edge, vertex };

struct Closest {
  Vec3 point;
  Part part;
  int corner[2];  // of the edge, or the vertex, on which it lies
};

Closest on_segment(const Facet& f, int a, int b, const Vec3& p) {
  const Vec3 along = f.corner[b] - f.corner[a];
  const double t = (p - f.corner[a]).dot(along), whole = along.squaredNorm();
  if (t <= 0) return {f.corner[a], Part::vertex, {a, a}};
  if (t >= whole) return {f.corner[b], Part::vertex, {b, b}};
  return {f.corner[a] + t / whole * along, Part::edge, {a, b}};
}

// The point of a triangle closest to p (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
Closest closest_point(const Facet& f, const Vec3& p) {
  const Vec3 &a = f.corner[0], &b = f.corner[1], &c = f.corner[2];
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {a, Part::vertex, {0, 0}};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {b, Part::vertex, {1, 1}};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return on_segment(f, 0, 1, p);
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {c, Part::vertex, {2, 2}};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return on_segment(f, 0, 2, p);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return on_segment(f, 1, 2, p);
  // The foot of the perpendicular: exact in the normal, and thus the same for all triangles of a plane.
  return {p - f.normal.dot(ap) * f.normal, Part::face, {0, 0}};
}

// A triangle without area has only its sides.
Closest closest_on_sides(const Facet& f, const Vec3& p) {
  Closest best = on_segment(f, 0, 1, p);
  for (const auto& [a, b] : {std::pair{0, 2}, std::pair{1, 2}}) {
    const Closest other = on_segment(f, a, b, p);
    if ((p - other.point).squaredNorm() < (p - best.point).squaredNorm()) best = other;
  }
  return best;
}

Closest closest(const Facet& f, const Vec3& p) { return f.normal.isZero(0) ? closest_on_sides(f, p) : closest_point(f, p); }

Facet facet_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  // The sides that meet at the widest angle give the most accurate normal of a sliver.
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const Vec3 area = ab >= bc && ab >= ca ? (a - c).cross(b - c) : bc >= ca ? (b - a).cross(c - a) : (c - b).cross(a - b);
  const double size = area.norm(), longest = std::max({ab, bc, ca});
  const Vec3 middle = (a + b + c) / 3;
  const double farthest = std::sqrt(std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
  return {{a, b, c}, size > 1e-14 * longest ? Vec3(area / size) : Vec3(Vec3::Zero()), middle, (1 + 1e-9) * farthest};
}

// A square distance that no point of the triangle falls below: to the circle in its plane that holds it.
double least_distance_squared(const Facet& f, const Vec3& p) {
  const Vec3 offset = p - f.middle;
  const double height = f.normal.dot(offset), square = offset.squaredNorm();
  const double outside = std::max(0.0, std::sqrt(std::max(0.0, square - height * height)) - f.radius);
  return (1 - 1e-12) * (height * height + outside * outside);
}

void widen(BoxTree::Node& node, const Vec3& p) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const auto near = static_cast<float>(p[axis]);
    node.lower[axis] = std::min(node.lower[axis], near > p[axis] ? std::nextafter(near, -infinity) : near);
    node.upper[axis] = std::max(node.upper[axis], near < p[axis] ? std::nextafter(near, infinity) : near);
  }
}

void build(const std::vector<Facet>& facets, BoxTree& tree, std::size_t at, Index first, Index count) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  BoxTree::Node node{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, first, count};
  const auto begin = tree.order.begin() + first, end = begin + count;
  const auto middle = [&](Index t, int axis) {
    const Facet& f = facets[static_cast<std::size_t>(t)];
    return f.corner[0][axis] + f.corner[1][axis] + f.corner[2][axis];
  };
  Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  for (auto t = begin; t != end; ++t) {
    for (const Vec3& corner : facets[static_cast<std::size_t>(*t)].corner) widen(node, corner);
    const Vec3 m(middle(*t, 0), middle(*t, 1), middle(*t, 2));
    lower = lower.cwiseMin(m), upper = upper.cwiseMax(m);
  }
  if (count > leaf_size) {
    int axis = 0;
    (upper - lower).maxCoeff(&axis);
    const Index half = count / 2;
    std::nth_element(begin, begin + half, end, [&](Index s, Index t) {
      const double ms = middle(s, axis), mt = middle(t, axis);
      return ms != mt ? ms < mt : s < t;
    });
    node.first = static_cast<Index>(tree.nodes.size()), node.count = 0;
    tree.nodes.resize(tree.nodes.size() + 2);
    const auto child = static_cast<std::size_t>(node.first);
    build(facets, tree, child, first, half);
    build(facets, tree, child + 1, first + half, count - half);
  }
  tree.nodes[at] = node;
}

// A ball whose boxes are asked for, in floats: larger than the one meant by more than their rounding.
struct Ball {
  float centre[3], reach_squared;
  Ball(const Vec3& p, double reach) {
    for (int axis = 0; axis < 3; ++axis) centre[axis] = static_cast<float>(p[axis]);
    const double wider = reach + 1e-6 * (p.lpNorm<1>() + reach);
    reach_squared = static_cast<float>((1 + 1e-6) * wider * wider);
  }
  bool meets(const BoxTree::Node& node) const {
    float sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float below = node.lower[axis] - centre[axis], above = centre[axis] - node.upper[axis];
      const float outside = below > above ? below : above, positive = outside > 0 ? outside : 0;
      sum += positive * positive;
    }
    return sum <= reach_squared;
  }
};

struct Candidate {
  Closest at;
  double distance;
  double order;  // distance, a shade more for edges and vertices
  Index triangle;
};

bool shares(const std::array<Index, 3>& corners, Index v) { return corners[0] == v || corners[1] == v || corners[2] == v; }

// Whether two triangles share the edge or vertex on which the first one's candidate point lies.
bool meet_there(const Mesh& mesh, const Candidate& a, const Candidate& b) {
  if (a.at.part == Part::face) return false;
  const auto& own = mesh.triangles[static_cast<std::size_t>(a.triangle)];
  const auto& corners = mesh.triangles[static_cast<std::size_t>(b.triangle)];
  return shares(corners, own[static_cast<std::size_t>(a.at.corner[0])]) && shares(corners, own[static_cast<std::size_t>(a.at.corner[1])]);
}

bool lies_on(const Facet& f, const Vec3& point, double tolerance) {
  if (std::abs(f.normal.dot(point - f.corner[0])) > tolerance) return false;
  return (closest(f, point).point - point).squaredNorm() <= tolerance * tolerance;
}

// Whether the point of candidate k lies on the triangle of one before it. Neighbours that share vertices, most often near in the
// list, need no arithmetic; the rest are T-junctions and vertices given twice.
template <class Candidates>
bool lies_on_nearer(const Mesh& mesh, const Candidates& near, std::size_t k, double tolerance) {
  for (std::size_t j = k; j-- > 0;)
    if (meet_there(mesh, near[k], near[j])) return true;
  for (std::size_t j = 0; j < k; ++j)
    if (lies_on(mesh.facets[static_cast<std::size_t>(near[j].triangle)], near[k].at.point, tolerance)) return true;
  return false;
}

Touch touch_of(const Mesh& mesh, const Candidate& c, const Vec3& centre) {
  const Vec3& normal = mesh.facets[static_cast<std::size_t>(c.triangle)].normal;
  const Vec3 offset = centre - c.at.point;
  if (c.at.part == Part::face) return {c.at.point, offset.dot(normal) < 0 ? Vec3(-normal) : normal, c.distance};
  if (c.distance > 1e-300) return {c.at.point, offset / c.distance, c.distance};
  return {c.at.point, normal.isZero(0) ? Vec3::UnitZ().eval() : normal, 0};
}

}  // namespace

Mesh make_mesh(std::vector<Vec3> vertices, std::vector<std::array<Index, 3>> triangles) {
  Mesh mesh;
  mesh.vertices = std::move(vertices);
  mesh.triangles = std::move(triangles);
  for (const Vec3& v : mesh.vertices) mesh.farthest = std::max(mesh.farthest, v.norm());
  mesh.facets.reserve(mesh.triangles.size());
  const auto vertex = [&](Index v) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(v)]; };
  for (const auto& t : mesh.triangles) mesh.facets.push_back(facet_of(vertex(t[0]), vertex(t[1]), vertex(t[2])));
  mesh.tree.order.resize(mesh.triangles.size());
  std::iota(mesh.tree.order.begin(), mesh.tree.order.end(), 0);
  if (!mesh.triangles.empty()) {
    mesh.tree.nodes.resize(1);
    build(mesh.facets, mesh.tree, 0, 0, static_cast<Index>(mesh.triangles.size()));
  }
  return mesh;
}

std::vector<Index> nodes_near(const Mesh& mesh, std::vector<Index> nodes, const Vec3& point, double reach) {
  constexpr std::size_t enough = 8;
  std::vector<Index> leaves;
  const Ball ball(point, reach);
  if (mesh.tree.nodes.empty()) nodes.clear();
  // Level by level, until they are many enough or cannot be divided.
  for (;;) {
    nodes.erase(std::remove_if(nodes.begin(), nodes.end(),
                               [&](Index n) { return !ball.meets(mesh.tree.nodes[static_cast<std::size_t>(n)]); }),
                nodes.end());
    if (nodes.empty() || nodes.size() + leaves.size() >= enough) break;
    std::vector<Index> next;
    for (Index n : nodes) {
      const BoxTree::Node& node = mesh.tree.nodes[static_cast<std::size_t>(n)];
      if (node.count > 0) {
        leaves.push_back(n);
      } else {
        next.push_back(node.first);
        next.push_back(node.first + 1);
      }
    }
    nodes = std::move(next);
  }
  nodes.insert(nodes.end(), leaves.begin(), leaves.end());
  return nodes;
}

void triangles_near(const Mesh& mesh, const std::vector<Index>& nodes, const Vec3& point, double reach, std::vector<Index>& found) {
  const std::size_t before = found.size();
  const double reach_squared = reach * reach;
  const Ball ball(point, reach);
  boost::container::small_vector<Index, 128> open(nodes.begin(), nodes.end());
  while (!open.empty()) {
    const BoxTree::Node& node = mesh.tree.nodes[static_cast<std::size_t>(open.back())];
    open.pop_back();
    if (!ball.meets(node)) continue;
    if (node.count == 0) {
      open.push_back(node.first);
      open.push_back(node.first + 1);
      continue;
    }
    for (Index k = node.first; k < node.first + node.count; ++k) {
      const Index t = mesh.tree.order[static_cast<std::size_t>(k)];
      if (least_distance_squared(mesh.facets[static_cast<std::size_t>(t)], point) <= reach_squared) found.push_back(t);
    }
  }
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end());
}

void triangles_near(const Mesh& mesh, const Vec3& point, double reach, std::vector<Index>& found) {
  if (!mesh.tree.nodes.empty()) triangles_near(mesh, {0}, point, reach, found);
}

Index watch_triangles(const Mesh& mesh, Index* first, Index* last, const Vec3& point, double reach, double& nearest) {
  double least = std::numeric_limits<double>::infinity();
  Index* front = first;
  for (Index* t = first; t != last; ++t) {
    const double square = least_distance_squared(mesh.facets[static_cast<std::size_t>(*t)], point);
    least = std::min(least, square);
    if (square < reach * reach) std::swap(*t, *front++);
  }
  nearest = std::sqrt(least);
  return static_cast<Index>(front - first);
}

int touch_triangles(const Mesh& mesh, const Index* first, const Index* last, const Vec3& centre, double radius, Touch* touches, double* gap) {
  // Closest points of neighbours that differ by rounding alone are told apart by their part of the triangle.
  const double shade = 1e-12 * radius + 1e-15 * centre.lpNorm<1>();
  boost::container::small_vector<Candidate, 32> near;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Index* t = first; t != last; ++t) {
    const Facet& f = mesh.facets[static_cast<std::size_t>(*t)];
    if (const double least = least_distance_squared(f, centre); least >= radius * radius) {
      nearest = std::min(nearest, std::sqrt(least));
      continue;
    }
    const double from_plane = std::abs(f.normal.dot(centre - f.corner[0]));
    const Closest at = closest(f, centre);
    const double distance = at.part == Part::face ? from_plane : (centre - at.point).norm();
    nearest = std::min(nearest, distance);
    if (distance < radius) near.push_back({at, distance, distance + shade * static_cast<int>(at.part), *t});
  }
  if (gap) *gap = nearest - radius;
  if (near.size() > 1)
    std::sort(near.begin(), near.end(),
              [](const Candidate& a, const Candidate& b) { return a.order != b.order ? a.order < b.order : a.triangle < b.triangle; });

  // A triangle is convex: if another one holds this point and has a closer one, the distance falls from here to there.
  constexpr double one_degree = 1 - 1.5230484360873042e-4;
  const double tolerance = 1e-6 * radius;
  int count = 0;
  for (std::size_t k = 0; k < near.size() && count < most_touches; ++k) {
    if (lies_on_nearer(mesh, near, k, tolerance)) continue;
    const Touch touch = touch_of(mesh, near[k], centre);
    bool minimum = true;
    for (int j = 0; j < count && minimum; ++j) minimum = touch.normal.dot(touches[j].normal) < one_degree;
    if (minimum) touches[count++] = touch;
  }
  return count;
}

bool lies_on(const Mesh& mesh, Index triangle, const Vec3& place, double tolerance) {
  return lies_on(mesh.facets[static_cast<std::size_t>(triangle)], place, tolerance);
}

}  // namespace quern
