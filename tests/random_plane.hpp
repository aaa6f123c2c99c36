// A square of the plane z = 0 cut at random into triangles that meet side to side.
#pragma once
#include "src/base/random.hpp"
#include "src/wall/mesh.hpp"

namespace quern {

// About `count` triangles on [−size/2, size/2]²: half of them a jittered grid with random diagonals, the other half from points thrown
// into random triangles, which makes slivers. All look up (+z).
inline Mesh random_plane(double size, int count, std::uint64_t seed) {
  RandomStream random(seed);
  const auto cells = static_cast<Index>(std::sqrt(count / 4.0) + 0.5);
  const double cell = size / cells;
  std::vector<Vec3> vertices;
  for (Index row = 0; row <= cells; ++row)
    for (Index column = 0; column <= cells; ++column) {
      const auto jitter = [&](Index k) { return k == 0 || k == cells ? 0.0 : random.uniform(-0.3, 0.3); };
      const double x = column + jitter(column), y = row + jitter(row);
      vertices.emplace_back(x * cell - size / 2, y * cell - size / 2, 0.0);
    }
  const auto looks_up = [&](Index a, Index b, Index c) {
    const Vec3 &p = vertices[static_cast<std::size_t>(a)], &q = vertices[static_cast<std::size_t>(b)],
               &r = vertices[static_cast<std::size_t>(c)];
    return (q - p).cross(r - p).z() > 0;
  };
  std::vector<std::array<Index, 3>> triangles;
  for (Index row = 0; row < cells; ++row)
    for (Index column = 0; column < cells; ++column) {
      const Index a = row * (cells + 1) + column, b = a + 1, d = a + cells + 1, c = d + 1;
      const bool rising = random.uniform() < 0.5;
      const bool rising_fits = looks_up(a, b, c) && looks_up(a, c, d), falling_fits = looks_up(a, b, d) && looks_up(b, c, d);
      if (rising_fits && (rising || !falling_fits)) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      } else {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      }
    }
  while (static_cast<int>(triangles.size()) + 2 <= count) {
    const auto t = static_cast<std::size_t>(random.uniform() * static_cast<double>(triangles.size()));
    const auto [a, b, c] = triangles[t];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3& origin = vertices[static_cast<std::size_t>(a)];
    const Vec3 inside =
        origin + u * (vertices[static_cast<std::size_t>(b)] - origin) + v * (vertices[static_cast<std::size_t>(c)] - origin);
    const auto middle = static_cast<Index>(vertices.size());
    vertices.push_back(inside);
    triangles[t] = {a, b, middle};
    triangles.push_back({b, c, middle});
    triangles.push_back({c, a, middle});
  }
  return make_mesh(std::move(vertices), std::move(triangles));
}

namespace testing {

// 10,000 triangles on [0, 0.2 m]².
inline Mesh random_plane_mesh() {
  const Mesh centred = random_plane(0.2, 10000, 1);
  std::vector<Vec3> vertices;
  for (const Vec3& v : centred.vertices) vertices.push_back(v + Vec3(0.1, 0.1, 0));
  return make_mesh(std::move(vertices), centred.triangles);
}

}  // namespace testing

}  // namespace quern
