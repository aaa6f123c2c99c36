#include "mills/planetary.hpp"
#include <unistd.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "src/case/build.hpp"
#include "src/observe/seat.hpp"
#include "src/wall/mesh_shapes.hpp"
#include "src/wall/stl.hpp"
#include "tests/scene.hpp"
#include "tests/places.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

PlanetaryMill small_mill() {
  PlanetaryMill mill;
  mill.disc_diameter = 0.14;
  mill.vial_diameter = 0.05;
  mill.vial_length = 0.04;
  mill.vials = 2;
  mill.speed = 26;
  mill.ratio = -2;
  return mill;
}

const Material steel{"steel", 7700, 1e9, 0.3};

// One small ball in the second vial, thrown in the fixed frame.
Simulation with_ball(PlanetaryMill mill, const Vec3& velocity, const Vec3& spin, double time_step) {
  Simulation s = scene::free_space(steel, scene::hertz(steel, steel, 0.5, 0.5), time_step);
  s.gravity = Vec3(0, 0, -9.81);
  s.frames = frames_of(mill);
  s.walls = walls_of(mill, 0);
  const Vec3 place = vial_pose(mill, mill.vials - 1).to_fixed({0.004, -0.003, 0.002});
  scene::add_ball(s, triple(place), 0.002, triple(velocity), triple(spin));
  if (mill.axes == PlanetaryMill::Axes::disc) {
    const Turn disc = turn_at(disc_motion(mill), 0);
    add(s.particles.velocity[0], -disc.speed * disc.axis.cross(place - disc.centre));
    add(s.particles.spin[0], -disc.speed * disc.axis);
    s.fields = {TurningFrame{disc_motion(mill), s.gravity}};
  }
  return s;
}

}  // namespace

TEST_CASE("A single ball in an empty vial flies straight in the fixed frame until its first hit, computed in either frame") {
  RandomStream random(5);
  for (const auto axes : {PlanetaryMill::Axes::fixed, PlanetaryMill::Axes::disc}) {
    for (int trial = 0; trial < 12; ++trial) {
      PlanetaryMill mill = small_mill();
      mill.axes = axes;
      mill.vials = trial % 3 == 0 ? 1 : trial % 3 == 1 ? 2 : 4;
      mill.vial_diameter = 0.04;
      mill.speed = random.uniform(-40, 40);
      mill.ratio = random.uniform(-3, 3);
      mill.ramp = trial % 4 == 1 ? 0.02 : 0;
      mill.tilt = trial % 4 == 2 ? 0.5 * pi : 0;
      // Upright, lying, and in between: gravity turns in the axes of the disc.
      mill.axis = trial % 2 == 0 ? Vec3::UnitZ() : Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      mill.centre = Vec3(0.1, -0.2, 0.05);
      const Vec3 velocity(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)), spin(10, -20, 5);
      Simulation s = with_ball(mill, velocity, spin, 1e-6);
      const Vec3 start = vec(s.particles.position[0]);
      s.start(false);
      double worst = 0, worst_spin = 0, way = 0;
      int steps = 0;
      for (; steps < 30000; ++steps) {
        s.step();
        if (s.contacts.sums.wall_contacts > 0) break;
        const double t = s.clock.time();
        const Vec3 expected = start + velocity * t + 0.5 * t * t * s.gravity;
        const Turn disc = turn_at(disc_motion(mill), t);
        const Pose seat = axes == PlanetaryMill::Axes::disc ? poses_at({{"disc", -1, disc_motion(mill)}}, t)[0] : Pose{};
        worst = std::max(worst, (seat.to_fixed(vec(s.particles.position[0])) - expected).norm());
        const Vec3 turned = axes == PlanetaryMill::Axes::disc ? (seat.axes * vec(s.particles.spin[0]) + disc.speed * disc.axis).eval()
                                                              : vec(s.particles.spin[0]);
        // At the very corner of a ramp half of the step's turn is still to come.
        if (std::abs(t - mill.ramp) > 1e-9) worst_spin = std::max(worst_spin, (turned - spin).norm() / spin.norm());
        way = (expected - start).norm();
      }
      INFO("trial " << trial << ", " << steps << " steps");
      CHECK(steps > 500);
      CHECK(worst < 1e-6 * std::max(way, mill.vial_diameter));
      CHECK(worst_spin < 1e-6);
    }
  }
}

TEST_CASE("In the axes of the disc the work of centrifugal, Coriolis and Euler forces and of turning gravity closes the ledger") {
  PlanetaryMill mill = small_mill();
  mill.axes = PlanetaryMill::Axes::disc;
  mill.axis = Vec3(0.2, 1, 0.4);
  mill.ramp = 0.01;
  Simulation s = with_ball(mill, Vec3(0.2, 0.3, -0.1), Vec3(10, -20, 5), 1e-6);
  s.start(false);
  for (int k = 0; k < 100000; ++k) s.step();
  s.measure_energy();
  CHECK(s.ledger.throughput > 0);  // it has met the vial
  CHECK(std::abs(s.ledger.field_work) > 1e-6);
  CHECK(std::abs(s.ledger.gap()) < 1e-3 * (s.ledger.dissipated() + std::abs(s.ledger.field_work)));
}

TEST_CASE("The speed of the vials may be counted against the disc or against the fixed frame") {
  PlanetaryMill mill = small_mill();
  const double against_disc = poses_at(frames_of(mill), 0.3)[1].angular_velocity.z();
  CHECK(against_disc == Approx(26 - 52));
  mill.ratio_to = PlanetaryMill::RatioTo::fixed;
  CHECK(poses_at(frames_of(mill), 0.3)[1].angular_velocity.z() == Approx(-52));
  CHECK(absolute_ratio(mill) == Approx(-2));
  mill.ratio = 1;  // carried round without turning on the disc
  CHECK(turn_at(vial_motion(mill, 0), 1).speed == Approx(0).margin(1e-12));
}

TEST_CASE("At the critical ratio a ball is just held at the point of the shell that is nearest to the disc's axis") {
  const PlanetaryMill mill = small_mill();
  const double ball = 0.01, reach = 0.5 * (mill.vial_diameter - ball), spin = critical_ratio(mill, ball) * mill.speed;
  // On the epicycle r = R e^{iΩt} + l e^{iωt} the acceleration towards the shell's middle vanishes where the two arms are opposite.
  CHECK(0.5 * mill.disc_diameter * mill.speed * mill.speed - reach * spin * spin == Approx(0).margin(1e-9));
}

TEST_CASE("The vials of a planetary mill stand around the disc, upright or like spokes") {
  for (const double tilt : {0.0, 0.5 * pi}) {
    PlanetaryMill mill = small_mill();
    mill.vials = 4;
    mill.tilt = tilt;
    mill.centre = Vec3(1, 2, 3);
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      const Pose pose = vial_pose(mill, k);
      CHECK((pose.origin - mill.centre).norm() == Approx(0.07));
      CHECK((pose.axes.transpose() * pose.axes - Mat3::Identity()).norm() < 1e-14);
      CHECK(pose.axes.determinant() == Approx(1));
      CHECK(pose.axes.col(2).dot(Vec3::UnitZ()) == Approx(std::cos(tilt)).margin(1e-15));
      CHECK(pose.axes.col(2).dot((pose.origin - mill.centre).normalized()) == Approx(std::sin(tilt)).margin(1e-15));
      sum += pose.origin - mill.centre;
    }
    CHECK(sum.norm() < 1e-15);
    CHECK(walls_of(mill, 0).size() == 12);
    CHECK(walls_of(mill, 0)[11].name == "vial_4.end_1");
    CHECK(walls_of(mill, 0)[11].frame == 4);
  }
}

TEST_CASE("A planetary mill that cannot be is refused") {
  const auto refused = [](auto change) {
    PlanetaryMill mill = small_mill();
    change(mill);
    CHECK_THROWS_AS(check(mill), InputError);
  };
  CHECK_NOTHROW(check(small_mill()));
  refused([](PlanetaryMill& m) { m.vial_diameter = 0.15; });              // the vials meet in the middle
  refused([](PlanetaryMill& m) { m.vials = 4, m.vial_diameter = 0.1; });  // and beside each other
  refused([](PlanetaryMill& m) { m.vials = 0; });
  refused([](PlanetaryMill& m) { m.disc_diameter = 0; });
  refused([](PlanetaryMill& m) { m.ramp = -1; });
  refused([](PlanetaryMill& m) { m.axis = Vec3::Zero(); });
  refused([](PlanetaryMill& m) { m.tilt = 0.5, m.ratio_to = PlanetaryMill::RatioTo::fixed; });
}

TEST_CASE("All vials are seen as the first one, at rest in the axes of the disc") {
  for (const auto axes : {PlanetaryMill::Axes::fixed, PlanetaryMill::Axes::disc}) {
    for (const int vials : {1, 2, 3, 4}) {
      PlanetaryMill mill = small_mill();
      mill.vials = vials;
      mill.axes = axes;
      mill.axis = Vec3(0.3, -0.2, 1);
      mill.centre = Vec3(0.1, 0.2, 0.3);
      ObserverSettings settings;
      settings.planetary = mill;
      Simulation s = with_ball(mill, Vec3::Zero(), Vec3::Zero(), 1e-3);
      s.clock.step = 37;
      const Pose disc = disc_pose(mill, s.clock.time());
      const Seat seat = *Seat::of(settings, s);
      for (int k = 0; k < vials; ++k) {
        for (const Vec3& own : {Vec3(0.024, 0, 0.01), Vec3(-0.024, 0, 0), Vec3(0, 0.024, 0), Vec3(0.01, -0.02, -0.01)}) {
          const Vec3 place = disc.to_fixed(vial_pose(mill, k).to_fixed(own));
          CHECK((seat.seen(place) - vial_pose(mill, 0).to_fixed(own)).norm() < 1e-12);
          CHECK(seat.seen_velocity(place, disc.velocity_at(place)).norm() < 1e-12);
        }
      }
      // The point nearest to the disc's axis is 12 o'clock; angles grow as the vial turns, left-handed at this ratio.
      const Vec3 nearest = vial_pose(mill, 0).to_fixed({-0.02, 0, 0});
      CHECK(std::abs(std::remainder(seat.view.angle(nearest), 360)) < 1e-9);
      const Vec3 ahead = Eigen::AngleAxisd(-0.1, vial_pose(mill, 0).axes.col(2)) * (nearest - vial_pose(mill, 0).origin);
      CHECK(seat.view.angle(vial_pose(mill, 0).origin + ahead) == Approx(0.1 / degree));
    }
  }
}

TEST_CASE("A vial read from an STL file holds its balls like the cylinder that it is") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("quern_vial_" + std::to_string(getpid()));
  fs::create_directories(folder);
  const fs::path vial = folder / "vial.stl";
  // In millimetres; the discs' normals need not look inward, reading turns them.
  write_stl(vial, joined(cylinder_jacket(25, -20, 20, 90, FreeSide::inside), joined(disc_mesh(25, -20, 90), disc_mesh(25, 20, 90))));
  const std::string file = std::string(quern::source_directory) + "/cases/planetary_250rpm/case.toml";
  const auto power = [&](const std::vector<std::string>& more) {
    std::vector<std::string> overrides = {"material.steel.young=2e7", "mill.length=0.04", "duration=1.5", "observe.charge=false"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    Simulation s = build(read_case(file, overrides));
    s.start(false);
    double start = 0;
    while (s.clock.time() < 1.5) {
      s.step();
      if (s.clock.time() < 0.5) start = s.ledger.wall_work;
    }
    double farthest = 0;
    for (const Quad& x : s.particles.position) farthest = std::max(farthest, std::hypot(x.x, x.y));
    CHECK(farthest < 0.07 + 0.025);
    return s.ledger.wall_work - start;
  };
  const double cylinder = power({}), mesh = power({"mill.vial_file=" + vial.string(), "mill.vial_scale=0.001"});
  CHECK(mesh == Approx(cylinder).epsilon(0.25));  // two courses of one chaotic motion over a second
  fs::remove_all(folder);
}
