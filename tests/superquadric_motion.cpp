// Superquadrics in the simulation: spheres among them move as spheres, elastic ones keep their energy, a cube on a plane rests.
#include <catch2/catch.hpp>
#include <cmath>
#include "src/base/archive.hpp"
#include "src/base/random.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/particle/turning.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

Rotation random_turn(RandomStream& random) { return Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized(); }

Vec3 random_vector(RandomStream& random, double size) { return size * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); }

// Shape 0 is the unit ball; `shape` names one of those given.
Simulation with_shapes(Simulation s, const std::vector<Superquadric>& shapes) {
  s.shapes = {make_superquadric({1, 1, 1}, 2, 2)};
  s.shapes.insert(s.shapes.end(), shapes.begin(), shapes.end());
  return s;
}

std::size_t add_shape(Simulation& s, std::uint8_t shape, const Vec3& centre, const Rotation& turn, const Vec3& velocity = Vec3::Zero(), const Vec3& spin = Vec3::Zero()) {
  const Index row = s.particles.add_shape(triple(centre), s.shapes[shape], shape, 1, s.materials[0].density, 0, 0);
  const auto at = static_cast<std::size_t>(row);
  s.particles.orientation[at] = {turn.x(), turn.y(), turn.z(), turn.w()};
  set(s.particles.velocity[at], velocity);
  set_spin(s.particles, row, spin);
  return at;
}

void add_box(Simulation& s, double half) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Wall wall;
      wall.name = "side" + std::to_string(s.walls.size());
      wall.surface = Plane{};
      wall.rest.origin = side * half * Vec3::Unit(axis);
      wall.rest.axes = axes_with_z(-side * Vec3::Unit(axis));
      s.walls.push_back(wall);
    }
}

struct Momenta {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Momenta momenta(const Simulation& s) {
  Momenta m;
  for (std::size_t k = 0; k < s.particles.position.size(); ++k) {
    const Vec3 p = s.particles.velocity[k].w * vec(s.particles.velocity[k]);
    m.linear += p;
    m.angular += vec(s.particles.position[k]).cross(p) + (s.particles.shape[k] ? vec(s.particles.momentum[k]) : Vec3(s.particles.spin[k].w * vec(s.particles.spin[k])));
  }
  return m;
}

// A box of tumbling shapes and balls of which some touch.
Simulation crowd(double restitution, double friction) {
  RandomStream random(31);
  Simulation s = with_shapes(scene::free_space({"soft", 2500, 1e7, 0.25}, scene::hertz({"soft", 2500, 1e7, 0.25}, {"soft", 2500, 1e7, 0.25}, restitution, friction), 2e-6),
                             {make_superquadric({6e-3, 5e-3, 4e-3}, 2, 2), make_superquadric({4e-3, 4e-3, 4e-3}, 8, 8), make_superquadric({3e-3, 3e-3, 5e-3}, 10, 2)});
  s.gravity = {0, 0, -9.81};
  add_box(s, 30e-3);
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const Vec3 place = 14e-3 * Vec3(x, y, z);
        const int kind = (x + 3 * y + 9 * z + 13) % 4;
        if (kind == 0)
          scene::add_ball(s, triple(place), 4e-3, triple(random_vector(random, 1)));
        else
          add_shape(s, static_cast<std::uint8_t>(kind), place, random_turn(random), random_vector(random, 1), random_vector(random, 50));
      }
  return s;
}

}  // namespace

TEST_CASE("superquadrics with equal axes and exponents 2 move as spheres do", "[superquadric_motion]") {
  const auto box = [](bool shaped) {
    RandomStream random(30);
    const Material material{"soft", 2500, 1e7, 0.25};
    Simulation s = scene::free_space(material, scene::hertz(material, material, 0.5, 0.4), 5e-6);
    if (shaped) s = with_shapes(s, {make_superquadric({2e-3, 2e-3, 2e-3}, 2, 2)});
    s.pair_laws[0].rolling = {RollingModel::elastic_plastic, 0.02, 0.3};
    s.gravity = {0, 0, -9.81};
    add_box(s, 11.2e-3);
    for (int k = 0; k < 100; ++k) {
      const Vec3 place = 4.3e-3 * Vec3(k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2) + random_vector(random, 1e-4), velocity = random_vector(random, 0.2), spin = random_vector(random, 20);
      if (shaped)
        add_shape(s, 1, place, random_turn(random), velocity, spin);
      else
        random_turn(random), scene::add_ball(s, triple(place), 2e-3, triple(velocity), triple(spin));
    }
    s.start(false);
    Index contacts = 0;
    for (int k = 0; k < 10000; ++k) {
      s.step();
      contacts = std::max(contacts, s.contacts.sums.pair_contacts);
    }
    CHECK(contacts > 50);
    return s;
  };
  const Simulation spheres = box(false), shapes = box(true);
  double apart = 0;
  for (Index id = 0; id < 100; ++id) {
    const std::size_t a = scene::row_of(spheres, id), b = scene::row_of(shapes, id);
    apart = std::max(apart, (vec(spheres.particles.position[a]) - vec(shapes.particles.position[b])).norm());
  }
  CHECK(apart < 1e-9 * 22.4e-3);  // of the box; collisions magnify what rounding leaves
}

TEST_CASE("elastic collisions of superquadrics keep energy and both momenta", "[superquadric_motion]") {
  // Stiff enough that overlaps stay small beside the radii of edges: deeper, the least way out changes from one side to another.
  RandomStream random(32);
  const Material material{"stiff", 2500, 1e9, 0.25};
  for (int k = 0; k < 40; ++k) {
    const auto axis = [&] { return 2e-3 * std::pow(5.0, random.uniform(-0.5, 0.5)); };
    const auto exponent = [&] { return 2 * std::pow(10.0, random.uniform()); };
    Simulation s = with_shapes(scene::free_space(material, scene::hertz(material, material, 1, 0), 2e-7),
                               {make_superquadric({axis(), axis(), axis()}, exponent(), exponent()), make_superquadric({axis(), axis(), axis()}, exponent(), exponent())});
    const Vec3 way = random_vector(random, 1).normalized();
    const double apart = s.shapes[1].bounding_radius + s.shapes[2].bounding_radius + 1e-3;  // beyond reach, beside each other or not
    add_shape(s, 1, 0.5 * apart * way, random_turn(random), -0.5 * way, random_vector(random, 30));
    if (k % 3 == 0)
      scene::add_ball(s, triple(Vec3(-0.5 * apart * way)), 2e-3, triple(Vec3(0.5 * way)));
    else
      add_shape(s, 2, -0.5 * apart * way + random_vector(random, 5e-4), random_turn(random), 0.5 * way, random_vector(random, 30));
    s.start(true);
    const double energy = scene::kinetic_energy(s);
    const Momenta before = momenta(s);
    Index touches = 0;
    for (int n = 0; n < 60000; ++n) {
      s.step();
      touches += s.contacts.sums.pair_contacts;
    }
    if (touches == 0 || s.contacts.sums.pair_contacts > 0) continue;
    const Momenta after = momenta(s);
    CAPTURE(k, touches);
    CHECK(scene::kinetic_energy(s) == Approx(energy).epsilon(1e-3));
    CHECK((after.linear - before.linear).norm() < 1e-12 * s.particles.velocity[0].w);
    CHECK((after.angular - before.angular).norm() < 1e-9 * s.particles.velocity[0].w * apart);
  }
}

TEST_CASE("superquadrics that fall elastically upon the edges of a hole keep their energy", "[superquadric_motion]") {
  RandomStream random(36);
  const Material material{"stiff", 2500, 1e9, 0.25};
  int fell = 0, bounced = 0;
  for (int k = 0; k < 40; ++k) {
    const auto axis = [&] { return 2e-3 * std::pow(3.0, random.uniform(-0.5, 0.5)); };
    const auto exponent = [&] { return 2 * std::pow(5.0, random.uniform()); };
    Simulation s = with_shapes(scene::free_space(material, scene::hertz(material, material, 1, 0), 2e-7), {make_superquadric({axis(), axis(), axis()}, exponent(), exponent())});
    Wall disc;
    disc.name = "disc";
    disc.surface = Revolved{4e-3, 0, 20e-3, 0, Revolved::Side::both};
    s.walls = {disc};
    const double off = 4e-3 + random.uniform(-3e-3, 1e-3), angle = random.uniform(-3, 3), height = s.shapes[1].bounding_radius + 1e-4;
    add_shape(s, 1, {off * std::cos(angle), off * std::sin(angle), height}, random_turn(random), {0, 0, -0.5}, random_vector(random, 50));
    s.start(false);
    const double energy = scene::kinetic_energy(s);
    Index touches = 0;
    for (int n = 0; n < 200000 && std::abs(s.particles.position[0].z) < height + 1e-4; ++n) {
      s.step();
      touches += s.contacts.sums.wall_contacts;
    }
    if (touches == 0 || s.contacts.sums.wall_contacts > 0) continue;
    CAPTURE(k, touches, s.shapes[1].semi_axes().transpose() * 1e3, s.shapes[1].n1(), s.shapes[1].n2());
    (s.particles.position[0].z < 0 ? fell : bounced) += 1;
    CHECK(scene::kinetic_energy(s) == Approx(energy).epsilon(0.01));  // what it may gain where a face hands it to an edge
  }
  CHECK(bounced > 5);
  CHECK(fell > 3);
}

TEST_CASE("a crowd of superquadrics and spheres keeps its energy where nothing takes any, and its ledger closes where friction does", "[superquadric_motion]") {
  for (const bool elastic : {true, false}) {
    Simulation s = elastic ? crowd(1, 0) : crowd(0.5, 0.4);
    if (elastic) s.gravity = Vec3::Zero();
    s.start(false);
    s.measure_energy();
    const double start = s.ledger.stored();
    for (int k = 0; k < 40000; ++k) s.step();
    s.measure_energy();
    CAPTURE(elastic);
    CHECK(s.ledger.closure() < 1e-3);
    if (elastic) CHECK(s.ledger.stored() == Approx(start).epsilon(1e-3));
    if (!elastic) CHECK(s.ledger.dissipated() > 0.1 * start);
    for (const Quad& x : s.particles.position) CHECK(vec(x).cwiseAbs().maxCoeff() < 30e-3);
  }
}

TEST_CASE("a cube at rest on a plane stays at rest", "[superquadric_motion]") {
  const double a = 5e-3;
  for (const double exponent : {4.0, 8.0, 20.0}) {
    for (const double angle : {0.0, 0.3}) {
      Simulation s = with_shapes(scene::free_space(scene::glass(), scene::linear(2e3, 0.5, 0.5), 5e-5), {make_superquadric({a, a, a}, exponent, exponent)});
      s.gravity = {0, 0, -9.81};
      scene::add_floor(s);
      const std::size_t row = add_shape(s, 1, {0, 0, a}, Rotation(Eigen::AngleAxisd(angle, Vec3::UnitZ())));
      s.start(false);
      double greatest = 0;
      for (int k = 0; k < 200000; ++k) {
        s.step();
        if (k > 20000 && k % 100 == 0) greatest = std::max(greatest, scene::kinetic_energy(s));
      }
      CAPTURE(exponent, angle);
      CHECK(greatest < 1e-10 * s.particles.velocity[row].w * 9.81 * a);
      CHECK(vec(s.particles.position[row]).head<2>().norm() < 1e-6 * a);
    }
  }
}

TEST_CASE("superquadrics in a turning drum stay in it and its power closes", "[superquadric_motion]") {
  const Material material{"soft", 2500, 1e7, 0.25};
  Simulation s = with_shapes(scene::free_space(material, scene::hertz(material, material, 0.4, 0.5), 1e-5),
                             {make_superquadric({9e-3, 7e-3, 6e-3}, 2, 2), make_superquadric({7e-3, 7e-3, 7e-3}, 8, 8)});
  RandomStream random(33);
  scene::add_drum(s, 6);
  s.domain.lower[1] = -0.03;
  for (int x = -2; x <= 2; ++x)
    for (int z = -2; z <= 1; ++z)
      add_shape(s, static_cast<std::uint8_t>(1 + (x + z + 4) % 2), {26e-3 * x, 0.01, 26e-3 * z}, random_turn(random));
  s.start(false);
  for (int k = 0; k < 60000; ++k) s.step();
  s.measure_energy();
  CHECK(s.ledger.closure() < 1e-3);
  CHECK(s.ledger.wall_work > 0);
  for (const Quad& x : s.particles.position) CHECK(std::hypot(x.x, x.z) < 0.1);
}

TEST_CASE("elastic cubes that rock in a turning vial without friction keep their energy", "[superquadric_motion]") {
  // They lie down nearly flat, so that edges and corners of a face take turns in touching the jacket. The turning itself does no work. Where one place
  // farthest from the axis merges with another, a contact ends before its overlap is zero, and what it holds is lost; that is less than a cube has to
  // move with, which it got by falling until a face would touch. A contact that is missed for one step leaves a cube deep in the jacket, and makes more.
  constexpr double radius = 25e-3, half = 6.1719e-3, start = 17e-3;
  const Material material{"soft", 7700, 1e8, 0.3};
  for (int k = 0; k < 12; ++k) {
    RandomStream random(60, static_cast<std::uint64_t>(k));
    Simulation s = with_shapes(scene::free_space(material, scene::hertz(material, material, 1, 0), 5e-6), {make_superquadric({half, half, half}, 8, 8)});
    s.gravity = {0, -9.81, 0};
    s.domain.period[2] = 0.05;
    s.frames = {{"turning", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), 10}}};
    Wall vial;
    vial.name = "vial";
    vial.surface = Revolved{radius, -1, radius, 1, Revolved::Side::inside};
    vial.frame = 0;
    s.walls = {vial};
    const Vec3 about = random_vector(random, 1).normalized();
    const double tilt = std::pow(10.0, random.uniform(-6, -1)), aside = random.uniform(-5e-3, 5e-3);
    const std::size_t row = add_shape(s, 1, {aside, -start, 0.02}, Rotation(Eigen::AngleAxisd(tilt, about)));
    s.start(false);
    const double fall = s.particles.velocity[row].w * 9.81 * (radius - half - start);
    double largest = 0;
    Index touches = 0;
    for (int n = 0; n < 60000; ++n) {
      s.step();
      s.measure_energy();
      largest = std::max(largest, std::abs(s.ledger.gap()));
      touches += s.contacts.sums.wall_contacts;
    }
    CAPTURE(k, tilt, aside);
    CHECK(touches > 2000);
    CHECK(largest < fall);
  }
}

TEST_CASE("superquadrics: the same bits for any threads, instruction set and across a checkpoint", "[superquadric_motion]") {
  const auto run = [](const char* kernels, int threads, bool breaks_off) {
    Simulation s = crowd(0.5, 0.4);
    if (const Kernels* found = find_kernels(kernels)) s.kernels = found;
    s.team = std::make_shared<ThreadTeam>(threads);
    s.start(true);
    for (int k = 0; k < 8000; ++k) {
      s.step();
      if (!breaks_off || k != 5000) continue;
      const std::string bytes = ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
      s = crowd(0.5, 0.4);
      if (const Kernels* found = find_kernels(kernels)) s.kernels = found;
      s.start(true);
      ArchiveReader reader(bytes);
      archive_state(reader, s);
    }
    return s;
  };
  const Simulation one = run("portable", 1, false);
  for (const Simulation& other : {run("avx2", 2, false), run("avx512", 1, false), run("portable", 1, true)}) {
    bool same = true;
    for (std::size_t k = 0; k < one.particles.position.size(); ++k) {
      const auto equal = [](const Quad& a, const Quad& b) { return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w; };
      same = same && equal(one.particles.position[k], other.particles.position[k]) && equal(one.particles.orientation[k], other.particles.orientation[k]) &&
             equal(one.particles.momentum[k], other.particles.momentum[k]);
    }
    CHECK(same);
  }
}
