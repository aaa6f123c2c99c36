#include "src/wall/walls.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "src/wall/mesh_shapes.hpp"
#include "tests/random_plane.hpp"

using namespace quern;

namespace {

Vec3 random_vector(RandomStream& random) { return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}; }

Mat3 random_axes(RandomStream& random) {
  return Eigen::AngleAxisd(random.uniform(0, 3), random_vector(random).normalized()).toRotationMatrix();
}

Wall wall_of(Surface surface) {
  Wall wall;
  wall.surface = std::move(surface);
  return wall;
}

// A few particles in one block, stepped by hand.
struct Bench {
  Particles particles;
  Domain domain;
  std::vector<Wall> walls;
  ContactBlock block;
  std::vector<std::uint8_t> pair_kind = {0};
  double skin = 0.005, path = 0;

  explicit Bench(std::vector<Wall> w) : walls(std::move(w)) {
    block.walls.resize(1);
    block.wall_sums.resize(walls.size());
    block.records = true;
  }
  void add(const Vec3& centre, double radius) {
    particles.add_sphere(triple(centre), radius, 1000, 0, 0);
    block.last = particles.size();
  }
  void place(Index i, const Vec3& centre) { set(particles.position[static_cast<std::size_t>(i)], centre); }
  void search() { find_wall_candidates(walls, particles, skin, block); }
  void touch() {
    StepContext step{};
    step.particles = &particles;
    step.domain = &domain;
    step.pair_kind = pair_kind.data();
    step.material_count = 1;
    const PairLaw law;
    step.pair_laws = &law;
    step.time = 0.25;
    step.path = path += 1;  // whatever was far may be near
    find_wall_touches(step, walls, block);
    // What the force kernel would do: the collision has begun.
    for (Index k = 0; k < block.walls[0].size(); ++k)
      block.record[static_cast<std::size_t>(block.walls[0].slot[static_cast<std::size_t>(k)])].start_time = 0;
  }
  Index slot(Index k) const { return block.walls[0].slot[static_cast<std::size_t>(k)]; }
};

}  // namespace

TEST_CASE("a surface of revolution is as near as the nearest of its points") {
  RandomStream random(1);
  for (int trial = 0; trial < 300; ++trial) {
    Revolved surface;
    surface.radius_0 = trial % 5 == 0 ? 0 : random.uniform(0, 1);
    surface.z_0 = random.uniform(-1, 1);
    surface.radius_1 = trial % 3 == 0 ? surface.radius_0 + 0.5 : random.uniform(0, 1);
    surface.z_1 = trial % 3 == 1 ? surface.z_0 : random.uniform(-1, 1);
    const Vec3 centre = 1.5 * random_vector(random);
    const double rho = std::hypot(centre.x(), centre.y());
    double least = 1e9;
    const int cuts = 4000;
    for (int k = 0; k <= cuts; ++k) {
      const double s = static_cast<double>(k) / cuts;
      least = std::min(least, std::hypot(rho - surface.radius_0 - s * (surface.radius_1 - surface.radius_0),
                                         centre.z() - surface.z_0 - s * (surface.z_1 - surface.z_0)));
    }
    const double spacing = std::hypot(surface.radius_1 - surface.radius_0, surface.z_1 - surface.z_0) / cuts;
    for (const auto side : {Revolved::Side::both, Revolved::Side::inside, Revolved::Side::outside}) {
      surface.side = side;
      const Touch touch = surface.touch(centre);
      CHECK(std::abs(touch.distance) <= least + 1e-13);
      CHECK(std::abs(touch.distance) >= least - 0.5 * spacing);
      CHECK(touch.normal.norm() == Approx(1).epsilon(1e-13));
      CHECK((touch.point + touch.distance * touch.normal - centre).norm() < 1e-13);
      // The point is on the surface: its own distance is none.
      CHECK(std::abs(surface.touch(touch.point).distance) < 1e-13);
    }
  }
}

TEST_CASE("a jacket pushes inwards from inside and outwards from outside, also once the centre has passed it") {
  for (const double direction : {1.0, -1.0}) {
    Revolved drum{0.5, -direction, 0.5, direction, Revolved::Side::inside};
    CHECK((drum.touch({0.49, 0, 0}).normal - Vec3(-1, 0, 0)).norm() < 1e-14);
    CHECK((drum.touch({0.51, 0, 0}).normal - Vec3(-1, 0, 0)).norm() < 1e-14);
    CHECK(drum.touch({0.51, 0, 0}).distance == Approx(-0.01).epsilon(1e-12));
    drum.side = Revolved::Side::outside;
    CHECK((drum.touch({0, 0.49, 0}).normal - Vec3(0, 1, 0)).norm() < 1e-14);
    CHECK(drum.touch({0, 0.49, 0}).distance == Approx(-0.01).epsilon(1e-12));
  }
}

TEST_CASE("a touch does not depend on where the wall stands") {
  RandomStream random(2);
  const std::vector<Surface> surfaces = {Plane{}, Revolved{0.5, -1, 0.3, 1, Revolved::Side::inside},
                                         box_mesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, FreeSide::inside)};
  for (const Surface& surface : surfaces)
    for (int trial = 0; trial < 100; ++trial) {
      Wall here = wall_of(surface), there = wall_of(surface);
      there.pose.origin = random_vector(random);
      there.pose.axes = random_axes(random);
      const Vec3 centre = 0.5 * random_vector(random);
      Touch a[most_touches], b[most_touches];
      const int count = touch_wall(here, centre, 0.2, a);
      REQUIRE(touch_wall(there, there.pose.to_fixed(centre), 0.2, b) == count);
      for (int k = 0; k < count; ++k) {
        CHECK(b[k].distance == Approx(a[k].distance).margin(1e-14));
        CHECK((b[k].point - there.pose.to_fixed(a[k].point)).norm() < 1e-13);
        CHECK((b[k].normal - there.pose.axes * a[k].normal).norm() < 1e-12);
      }
    }
}

TEST_CASE("a sphere wholly behind a sheet with one free side does not touch it; behind a plane all is solid") {
  const Wall drum = wall_of(Revolved{0.5, -1, 0.5, 1, Revolved::Side::inside});
  const Wall floor = wall_of(Plane{});
  Touch touch[most_touches];
  CHECK(touch_wall(drum, {0.52, 0, 0}, 0.05, touch) == 1);
  CHECK(touch_wall(drum, {0.56, 0, 0}, 0.05, touch) == 0);
  CHECK(touch_wall(floor, {0, 0, -3}, 0.05, touch) == 1);
  CHECK(touch_wall(floor, {0, 0, 0.05}, 0.05, touch) == 0);
}

TEST_CASE("only motion towards a point counts as closing") {
  Wall drum = wall_of(Revolved{0.5, -1, 0.5, 1, Revolved::Side::inside});
  drum.pose.axes = Eigen::AngleAxisd(0.3, Vec3::UnitY()).toRotationMatrix();
  drum.pose.angular_velocity = 5 * drum.pose.axes.col(2);
  CHECK(closing_speed(drum, 10) < 1e-14);
  drum.pose.velocity = Vec3(0, 2, 0);
  CHECK(closing_speed(drum, 10) == Approx(2).epsilon(1e-12));
  Wall floor = wall_of(Plane{});
  floor.pose.velocity = Vec3(3, 4, 0);
  floor.pose.angular_velocity = Vec3(0, 0, 7);
  CHECK(closing_speed(floor, 10) == 0);
  floor.pose.velocity.z() = -0.5;
  floor.pose.angular_velocity.x() = 2;
  CHECK(closing_speed(floor, 10) == Approx(0.5 + 20));
}

TEST_CASE("no point of a moving surface is faster along its normal than the closing speed") {
  RandomStream random(3);
  const double size = 2;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<Surface> surfaces = {Plane{}, Revolved{0.5, -1, 0.2, 0.4},
                                           box_mesh({-0.5, -0.1, -0.3}, {0.5, 0.4, 0.5}, FreeSide::inside)};
    for (const Surface& surface : surfaces) {
      Wall wall = wall_of(surface);
      wall.pose.axes = random_axes(random);
      wall.pose.velocity = random_vector(random);
      wall.pose.angular_velocity = random_vector(random);
      Touch touches[most_touches];
      const Vec3 centre = random_vector(random);
      const int count = touch_wall(wall, centre, 5.0, touches);
      for (int k = 0; k < count; ++k)
        CHECK(std::abs(wall.pose.velocity_at(touches[k].point).dot(touches[k].normal)) <= closing_speed(wall, size) * (1 + 1e-12));
    }
  }
}

TEST_CASE("a sphere sliding over thousands of triangles keeps one contact and its memory") {
  Bench bench({wall_of(random_plane(1.0, 10000, 3))});
  bench.add({-0.4, -0.3, 0.0495}, 0.05);
  bench.search();
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 1);
  const Index slot = bench.slot(0);
  bench.block.sliding[static_cast<std::size_t>(slot)].x = 42;
  for (int step = 0; step < 4000; ++step) {
    bench.place(0, Vec3(-0.4 + 0.0002 * step, -0.3 + 0.00015 * step, 0.0495));
    if (step % 10 == 0) bench.search();
    bench.touch();
    REQUIRE(bench.block.walls[0].size() == 1);
    REQUIRE(bench.slot(0) == slot);
    REQUIRE(bench.block.wall_touches[0].normal.w == Approx(0.0005).epsilon(1e-10));
  }
  CHECK(bench.block.sliding[static_cast<std::size_t>(slot)].x == 42);
  CHECK(bench.block.collisions.empty());
}

TEST_CASE("in a valley each side keeps its own memory while the nearer one changes") {
  Bench bench({wall_of(box_mesh({0, 0, 0}, {1, 1, 1}, FreeSide::inside))});
  bench.add({0.09, 0.5, 0.095}, 0.1);
  bench.search();
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 2);
  const Index side = bench.slot(0), floor = bench.slot(1);  // nearest first
  for (int step = 0; step < 100; ++step) {
    const double swing = 0.004 * std::cos(0.3 * step);
    bench.place(0, Vec3(0.094 - swing, 0.5, 0.094 + swing));
    bench.touch();
    REQUIRE(bench.block.walls[0].size() == 2);
    for (Index k = 0; k < 2; ++k) {
      const WallTouch& touch = bench.block.wall_touches[static_cast<std::size_t>(k)];
      CHECK(bench.slot(k) == (touch.normal.x > 0.9 ? side : floor));
    }
  }
  // Leaving one side ends that contact alone.
  bench.place(0, {0.102, 0.5, 0.095});
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 1);
  CHECK(bench.slot(0) == floor);
  REQUIRE(bench.block.collisions.size() == 1);
  CHECK(bench.block.collisions[0].second_id == -1);
  CHECK(bench.block.collisions[0].end_time == 0.25);
  REQUIRE(bench.block.free_slots.size() == 1);
  CHECK(bench.block.free_slots[0] == side);
}

TEST_CASE("contacts with a wall keep their memory while the wall turns with the particle") {
  Bench bench({wall_of(box_mesh({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, FreeSide::inside))});
  Pose& pose = bench.walls[0].pose;
  const Vec3 local(0.405, 0.404, 0.1);
  bench.add(local, 0.1);
  bench.search();
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 2);
  const std::set<Index> slots = {bench.slot(0), bench.slot(1)};
  for (int step = 0; step < 500; ++step) {
    pose.axes = Eigen::AngleAxisd(0.05 * step, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    bench.place(0, pose.to_fixed(local));
    if (step % 7 == 0) bench.search();
    bench.touch();
    REQUIRE(bench.block.walls[0].size() == 2);
    CHECK(std::set<Index>{bench.slot(0), bench.slot(1)} == slots);
  }
  CHECK(bench.block.collisions.empty());
}

TEST_CASE("a new search with the particles in another order hands the memory over") {
  Bench bench({wall_of(Plane{}), wall_of(box_mesh({0, 0, -1}, {1, 1, 1}, FreeSide::inside))});
  bench.add({0.5, 0.5, 0.099}, 0.1);      // on the floor
  bench.add({0.099, 0.5, 0.5}, 0.1);      // at the box's side
  bench.add({0.5, 0.5, 0.5}, 0.1);        // free
  bench.add({0.098, 0.097, 0.099}, 0.1);  // in the corner: floor and two sides
  bench.search();
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 5);
  const auto of = [&](Index id) {
    std::set<std::pair<int, Index>> found;
    for (Index k = 0; k < bench.block.walls[0].size(); ++k) {
      const auto row = static_cast<std::size_t>(bench.block.walls[0].first[static_cast<std::size_t>(k)]);
      if (bench.particles.id[row] == id)
        found.insert({static_cast<int>(bench.block.wall_touches[static_cast<std::size_t>(k)].point.w), bench.slot(k)});
    }
    return found;
  };
  std::vector<std::set<std::pair<int, Index>>> before;
  for (Index id = 0; id < 4; ++id) before.push_back(of(id));
  const std::vector<Index> order = {3, 2, 0, 1};  // new row k was row order[k]
  bench.particles.reorder(order);
  std::vector<Index> row(4);
  for (std::size_t k = 0; k < 4; ++k) row[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  for (WallCandidate& c : bench.block.wall_candidates) c.particle = row[static_cast<std::size_t>(c.particle)];
  bench.search();
  for (std::size_t k = 1; k < bench.block.wall_candidates.size(); ++k) {
    const WallCandidate &a = bench.block.wall_candidates[k - 1], &b = bench.block.wall_candidates[k];
    CHECK(std::pair{a.particle, a.wall} < std::pair{b.particle, b.wall});
  }
  bench.touch();
  for (Index id = 0; id < 4; ++id) CHECK(of(id) == before[static_cast<std::size_t>(id)]);
  CHECK(bench.block.collisions.empty());
  CHECK(bench.block.sliding.size() == 5);
}

TEST_CASE("a contact that parted between two steps ends even when a search came between") {
  Bench bench({wall_of(Plane{})});
  bench.add({0, 0, 0.099}, 0.1);
  bench.search();
  bench.touch();
  REQUIRE(bench.block.walls[0].size() == 1);
  bench.place(0, {0, 0, 0.3});
  bench.search();
  bench.touch();
  CHECK(bench.block.walls[0].size() == 0);
  CHECK(bench.block.collisions.size() == 1);
  CHECK(bench.block.free_slots.size() == 1);
  bench.search();
  CHECK(bench.block.wall_candidates.empty());
}

TEST_CASE("a wall touch carries overlap, wall motion and lever arm") {
  Bench bench({wall_of(Plane{}), wall_of(Revolved{0.5, -1, 0.5, 1, Revolved::Side::inside})});
  Pose& pose = bench.walls[1].pose;
  pose.origin = Vec3(10, 0, 0);
  pose.velocity = Vec3(0, 0, 1);
  pose.angular_velocity = Vec3(0, 0, 3);
  bench.add({10.41, 0, 5e-2}, 0.1);
  bench.search();
  bench.touch();
  REQUIRE(bench.block.wall_touches.size() == 2);
  const WallTouch& touch = bench.block.wall_touches[1];
  CHECK(touch.normal.x == Approx(-1));
  CHECK(touch.normal.w == Approx(0.01).epsilon(1e-10));
  CHECK(touch.point.w == 1);
  CHECK((vec(touch.point) - Vec3(0.5, 0, 0.05)).norm() < 1e-13);
  CHECK((vec(touch.velocity) - Vec3(0, 1.5, 1)).norm() < 1e-13);
  CHECK((vec(touch.spin) - Vec3(0, 0, 3)).norm() == 0);
}

TEST_CASE("steps between searches allocate nothing once the lists have their size") {
  Bench bench({wall_of(random_plane(1.0, 2000, 5)), wall_of(Plane{})});
  for (int k = 0; k < 50; ++k) bench.add({-0.4 + 0.016 * k, 0.1, 0.0101}, 0.01);
  bench.search();
  const auto bounce = [&](int step) {
    for (Index i = 0; i < 50; ++i) bench.particles.position[static_cast<std::size_t>(i)].z = 0.01 + 0.0005 * std::sin(0.3 * step + i);
    bench.block.collisions.clear();
    bench.touch();
  };
  const auto capacities = [&] {
    const ContactBlock& b = bench.block;
    return std::vector<std::size_t>{b.wall_touches.capacity(), b.wall_slots.capacity(), b.wall_normals.capacity(),
                                    b.sliding.capacity(),       b.free_slots.capacity(), b.walls[0].first.capacity()};
  };
  for (int step = 0; step < 50; ++step) bounce(step);
  const auto before = capacities();
  const WallTouch* place = bench.block.wall_touches.data();
  for (int step = 50; step < 200; ++step) bounce(step);
  CHECK(capacities() == before);
  CHECK(bench.block.wall_touches.data() == place);
}
