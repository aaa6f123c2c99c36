#include <catch2/catch.hpp>
#include <algorithm>
#include <cmath>

#include "src/wall/mesh_shapes.hpp"
#include "src/wall/walls.hpp"
#include "tests/random_plane.hpp"

using namespace quern;

namespace {

std::vector<Touch> touches_of(const Mesh& mesh, const Vec3& centre, double radius, double skin = 0) {
  std::vector<Index> near;
  triangles_near(mesh, centre, radius + skin, near);
  Touch touches[most_touches];
  const int count = touch_triangles(mesh, near.data(), near.data() + near.size(), centre, radius, touches);
  return {touches, touches + count};
}

// One touch, where the plane z = 0 has it.
void check_like_plane(const std::vector<Touch>& touches, const Vec3& centre, double radius) {
  REQUIRE(touches.size() == 1);
  const Touch plane = Plane{}.touch(centre);
  CHECK((touches[0].point - plane.point).norm() < 1e-12 * radius);
  CHECK((touches[0].normal - plane.normal).norm() < 1e-12);
  CHECK(std::abs(touches[0].distance - plane.distance) < 1e-12 * radius);
}

const double root_half = std::sqrt(0.5);

}  // namespace

TEST_CASE("a sphere on a plane cut into 10,000 random triangles feels the plane") {
  const Mesh mesh = random_plane(1.0, 10000, 3);
  REQUIRE(mesh.triangles.size() == 10000);
  RandomStream random(4);
  const double radius = 0.05;
  SECTION("anywhere") {
    for (int trial = 0; trial < 2000; ++trial) {
      const Vec3 centre(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(0.9, 0.9999) * radius);
      check_like_plane(touches_of(mesh, centre, radius, 0.01), centre, radius);
    }
  }
  SECTION("above vertices and edges, and a hair beside them") {
    for (int trial = 0; trial < 1000; ++trial) {
      const auto& t = mesh.triangles[static_cast<std::size_t>(random.uniform() * 10000)];
      const Vec3 &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])];
      const double along = trial % 2 == 0 ? 0 : random.uniform();
      const double aside = trial % 3 == 0 ? 0 : radius * std::pow(10, random.uniform(-17, -2));
      const double angle = random.uniform(0, 2 * M_PI);
      Vec3 centre = a + along * (b - a) + aside * Vec3(std::cos(angle), std::sin(angle), 0);
      if (std::abs(centre.x()) > 0.44 || std::abs(centre.y()) > 0.44) continue;
      centre.z() = random.uniform(0.9, 0.9999) * radius;
      check_like_plane(touches_of(mesh, centre, radius), centre, radius);
    }
  }
  SECTION("deep in it and much larger than the triangles") {
    for (int trial = 0; trial < 50; ++trial) {
      const Vec3 centre(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(0.3, 0.99) * 0.2);
      check_like_plane(touches_of(mesh, centre, 0.2), centre, 0.2);
    }
  }
}

TEST_CASE("a tilted and shifted plane of random triangles is one plane to 1e-9") {
  Pose pose;
  pose.origin = Vec3(3, -2, 5);
  pose.axes = Eigen::AngleAxisd(1.1, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  const Mesh mesh = moved(random_plane(1.0, 10000, 5), pose);
  RandomStream random(6);
  const double radius = 0.02;
  double worst_distance = 0, worst_normal = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Vec3 local(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(0.9, 0.9999) * radius);
    if (trial % 4 == 0) {
      const Vec3 v = pose.to_local(mesh.vertices[static_cast<std::size_t>(random.uniform() * static_cast<double>(mesh.vertices.size()))]);
      if (std::abs(v.x()) < 0.45 && std::abs(v.y()) < 0.45) local = Vec3(v.x(), v.y(), local.z());
    }
    const auto touches = touches_of(mesh, pose.to_fixed(local), radius, 0.005);
    REQUIRE(touches.size() == 1);
    worst_distance = std::max(worst_distance, std::abs(touches[0].distance - local.z()));
    worst_normal = std::max(worst_normal, (touches[0].normal - pose.axes.col(2)).norm());
  }
  // Vertices 6 m from the origin are rounded to 1e-15 m; a sliver 1e-4 m high turns that into 1e-11 of its normal.
  CHECK(worst_distance < 1e-13);
  CHECK(worst_normal < 1e-9);
}

TEST_CASE("a plane whose vertices were rounded to floats is still felt as one plane") {
  Pose pose;
  pose.origin = Vec3(0.3, -0.2, 0.5);
  pose.axes = Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  const Mesh exact = moved(random_plane(1.0, 1000, 15), pose);
  std::vector<Vec3> vertices;
  for (const Vec3& v : exact.vertices) vertices.push_back(v.cast<float>().cast<double>());
  const Mesh mesh = make_mesh(vertices, exact.triangles);
  RandomStream random(16);
  const double radius = 0.02;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec3 local(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(0.95, 0.999) * radius);
    const auto touches = touches_of(mesh, pose.to_fixed(local), radius);
    REQUIRE(touches.size() == 1);
    CHECK(std::abs(touches[0].distance - local.z()) < 1e-7);
  }
}

TEST_CASE("T-junctions and vertices given twice make no ghost edges") {
  // The left half is one large triangle pair, the right half many small ones that share no vertex with anything.
  std::vector<Vec3> vertices = {{-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0}};
  std::vector<std::array<Index, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
  const int strips = 7;
  for (int k = 0; k < strips; ++k) {
    const double low = -1 + 2.0 * k / strips, high = -1 + 2.0 * (k + 1) / strips;
    const auto first = static_cast<Index>(vertices.size());
    for (const Vec3& v : {Vec3(0, low, 0), Vec3(1, low, 0), Vec3(1, high, 0), Vec3(0, high, 0)}) vertices.push_back(v);
    triangles.push_back({first, first + 1, first + 2});
    triangles.push_back({first, first + 2, first + 3});
  }
  const Mesh mesh = make_mesh(vertices, triangles);
  RandomStream random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 centre(trial % 3 == 0 ? 0.0 : random.uniform(-0.3, 0.3), random.uniform(-0.6, 0.6), random.uniform(0.9, 0.999) * 0.2);
    check_like_plane(touches_of(mesh, centre, 0.2), centre, 0.2);
  }
}

TEST_CASE("a convex edge is one touch whose normal turns from one side to the other") {
  const Mesh box = box_mesh({-1, -1, -1}, {1, 1, 1}, FreeSide::outside);
  const double radius = 0.1, distance = 0.095;
  for (int k = 0; k <= 90; ++k) {
    const double angle = k * M_PI / 180;
    const Vec3 out(std::cos(angle), 0, std::sin(angle));
    const auto touches = touches_of(box, Vec3(1, 0.3, 1) + distance * out, radius);
    REQUIRE(touches.size() == 1);
    CHECK((touches[0].point - Vec3(1, 0.3, 1)).norm() < 1e-14);
    CHECK((touches[0].normal - out).norm() < 1e-13);
    CHECK(touches[0].distance == Approx(distance).epsilon(1e-13));
  }
}

TEST_CASE("the vertex of a cube is one touch") {
  const Mesh box = box_mesh({-1, -1, -1}, {1, 1, 1}, FreeSide::outside);
  RandomStream random(8);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 out = Vec3(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.01, 1)).normalized();
    const auto touches = touches_of(box, Vec3(1, 1, 1) + 0.09 * out, 0.1);
    REQUIRE(touches.size() == 1);
    CHECK((touches[0].normal - out).norm() < 1e-13);
  }
}

TEST_CASE("in the corners of a box each side is felt once") {
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1}, FreeSide::inside);
  const double radius = 0.1;
  SECTION("valley: two") {
    const auto touches = touches_of(box, {0.095, 0.4, 0.09}, radius);
    REQUIRE(touches.size() == 2);
    CHECK((touches[0].normal - Vec3::UnitZ()).norm() < 1e-14);  // the nearest first
    CHECK(touches[0].distance == Approx(0.09).epsilon(1e-14));
    CHECK((touches[1].normal - Vec3::UnitX()).norm() < 1e-14);
    CHECK((touches[1].point - Vec3(0, 0.4, 0.09)).norm() < 1e-15);
  }
  SECTION("corner: three, also where diagonals of the faces end") {
    for (int corner = 0; corner < 8; ++corner) {
      const auto at = [&](int bit) { return corner & bit ? 1 - 0.095 : 0.095; };
      CHECK(touches_of(box, {at(1), at(2), at(4)}, radius).size() == 3);
    }
  }
  SECTION("in the middle of a side: one; inside: none") {
    CHECK(touches_of(box, {0.5, 0.5, 0.095}, radius).size() == 1);
    CHECK(touches_of(box, {0.5, 0.5, 0.5}, radius).empty());
  }
}

TEST_CASE("a ridge between two slopes and the valley beside it") {
  // A roof over y with slopes of 45 degrees, ridge at x = 0, z = 0; valley at x = 1, z = −1.
  const std::vector<Vec3> vertices = {{-1, -5, -1}, {-1, 5, -1}, {0, -5, 0}, {0, 5, 0}, {1, -5, -1}, {1, 5, -1}, {2, -5, 0}, {2, 5, 0}};
  const Mesh roof = make_mesh(vertices, {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}, {4, 6, 7}, {4, 7, 5}});
  SECTION("on the ridge, one touch straight up") {
    const auto touches = touches_of(roof, {0, 0.7, 0.098}, 0.1);
    REQUIRE(touches.size() == 1);
    CHECK((touches[0].normal - Vec3::UnitZ()).norm() < 1e-14);
  }
  SECTION("in the valley, two touches square to the slopes") {
    const double height = -1 + 0.095 / root_half;
    const auto touches = touches_of(roof, {1, 0.7, height}, 0.1);
    REQUIRE(touches.size() == 2);
    CHECK(touches[0].distance == Approx(0.095).epsilon(1e-13));
    CHECK(touches[1].distance == Approx(0.095).epsilon(1e-13));
    CHECK((touches[0].normal + touches[1].normal - Vec3(0, 0, 2 * root_half)).norm() < 1e-13);
  }
}

TEST_CASE("at the foot of a lifter a ball feels shell and lifter, at its corner one edge, on both sides of a thin one") {
  // A floor and a lifter standing on it as a sheet without thickness, its foot a T-junction in the middle of the floor.
  const std::vector<Vec3> vertices = {{-1, -1, 0},  {1, -1, 0},  {1, 1, 0},     {-1, 1, 0},
                                      {0, -0.8, 0}, {0, 0.8, 0}, {0, 0.8, 0.3}, {0, -0.8, 0.3}};
  const Mesh mesh = make_mesh(vertices, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
  const double radius = 0.1;
  for (const double side : {-1.0, 1.0}) {
    const auto foot = touches_of(mesh, {side * 0.097, 0.1, 0.095}, radius);
    REQUIRE(foot.size() == 2);
    CHECK((foot[0].normal - Vec3::UnitZ()).norm() < 1e-14);
    CHECK((foot[1].normal - side * Vec3::UnitX()).norm() < 1e-14);
    const auto edge = touches_of(mesh, {side * 0.06, 0.1, 0.3 + 0.07}, radius);
    REQUIRE(edge.size() == 1);
    CHECK((edge[0].point - Vec3(0, 0.1, 0.3)).norm() < 1e-15);
  }
}

TEST_CASE("a drum of 720 facets is felt once, at most a facet's sagitta from the cylinder") {
  const double radius = 0.5, ball = 0.02;
  const Mesh drum = cylinder_jacket(radius, -0.5, 0.5, 720, FreeSide::inside);
  const double sagitta = radius * (1 - std::cos(M_PI / 720));
  RandomStream random(9);
  for (int trial = 0; trial < 1000; ++trial) {
    // Every other one exactly over an edge.
    const double angle = trial % 2 == 0 ? random.uniform(0, 2 * M_PI) : 2 * M_PI * (trial / 2) / 720;
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    const auto touches = touches_of(drum, (radius - 0.985 * ball) * out + random.uniform(-0.4, 0.4) * Vec3::UnitZ(), ball);
    REQUIRE(touches.size() == 1);
    CHECK(touches[0].distance <= 0.985 * ball + 1e-12);
    CHECK(touches[0].distance >= 0.985 * ball - 1.001 * sagitta);
    CHECK((touches[0].normal + out).norm() < 1.001 * M_PI / 720);
  }
}

TEST_CASE("the box tree lists every triangle within reach and none whose circle is beyond it") {
  const Mesh mesh = joined(random_plane(1.0, 500, 21), cylinder_jacket(0.3, -0.2, 0.4, 40, FreeSide::outside));
  RandomStream random(22);
  // One triangle at a time, a list of one has no neighbours to be confused with.
  const auto distance_to = [&](Index t, const Vec3& p) {
    Touch touches[most_touches];
    return touch_triangles(mesh, &t, &t + 1, p, 10.0, touches) == 1 ? touches[0].distance : 10.0;
  };
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 p(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), random.uniform(-0.3, 0.5));
    const double reach = random.uniform(0, 0.2);
    std::vector<Index> found = {-5}, by_steps = {-5};
    triangles_near(mesh, p, reach, found);
    REQUIRE(std::is_sorted(found.begin(), found.end()));
    triangles_near(mesh, nodes_near(mesh, {0}, p + Vec3(0.05, 0, 0), reach + 0.05001), p, reach, by_steps);
    CHECK(found == by_steps);
    std::vector<Index> within, watched = found;
    for (Index t = 0; t < static_cast<Index>(mesh.triangles.size()); ++t)
      if (distance_to(t, p) <= reach) within.push_back(t);
    CHECK(std::includes(found.begin(), found.end(), within.begin(), within.end()));
    for (std::size_t k = 1; k < found.size(); ++k) {
      const Facet& f = mesh.facets[static_cast<std::size_t>(found[k])];
      CHECK((f.middle - p).norm() <= reach + f.radius + 1e-9);
    }
    // The same bound by itself: those left out are farther than it says.
    double nearest = 0;
    const Index count = watch_triangles(mesh, watched.data() + 1, watched.data() + watched.size(), p, 0.5 * reach, nearest);
    double least = 10.0;
    for (std::size_t k = 1; k < watched.size(); ++k) {
      const double distance = distance_to(watched[k], p);
      least = std::min(least, distance);
      if (k > static_cast<std::size_t>(count)) CHECK(distance >= 0.5 * reach);
    }
    if (watched.size() > 1) CHECK(nearest <= least);
  }
}

TEST_CASE("the distance to a triangle is the least over its points") {
  RandomStream random(23);
  const auto point = [&] { return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); };
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 a = point(), b = point(), c = trial % 10 == 0 ? Vec3(a + 0.3 * (b - a)) : point(), p = point();  // every tenth has no area
    const Mesh mesh = make_mesh({a, b, c}, {{0, 1, 2}});
    const auto touches = touches_of(mesh, p, 10);
    REQUIRE(touches.size() == 1);
    double least = 1e9;
    const int cuts = 60;
    for (int i = 0; i <= cuts; ++i)
      for (int j = 0; i + j <= cuts; ++j) least = std::min(least, (a + (b - a) * i / cuts + (c - a) * j / cuts - p).norm());
    // The net of points is never nearer than the closest one, and at most one mesh width farther.
    CHECK(touches[0].distance <= least + 1e-12);
    CHECK(touches[0].distance >= least - 4.0 / cuts);
    CHECK((touches[0].point - p).norm() == Approx(touches[0].distance).epsilon(1e-12));
    CHECK((touches[0].point + touches[0].distance * touches[0].normal - p).norm() < 1e-12);
  }
}
