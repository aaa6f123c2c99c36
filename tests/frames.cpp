#include "mills/frame.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "src/base/random.hpp"

using namespace quern;

namespace {

Vec3 random_vector(RandomStream& random) { return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}; }

RotatingByTable ramp() { return {Vec3(0.1, -0.2, 0), Vec3(0, 1, 2).normalized(), {0.5, 1.5, 2.0}, {1.0, 5.0, -2.0}}; }

// Five frames inside each other, one of each motion and one more.
std::vector<Frame> nest(RandomStream& random) {
  return {{"disc", -1, Rotating{random_vector(random), random_vector(random).normalized(), 3.0}},
          {"vial", 0, Rotating{random_vector(random), random_vector(random).normalized(), -7.0}},
          {"shaker", 1, Oscillating{random_vector(random), 1.3, 0.4}},
          {"ramp", 2, ramp()},
          {"slide", 3, Translating{random_vector(random)}}};
}

}  // namespace

TEST_CASE("a point carried by nested frames moves as the poses' velocities say") {
  RandomStream random(11);
  const double h = 1e-5;
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<Frame> frames = nest(random);
    Pose rest;
    rest.origin = random_vector(random);
    rest.axes = Eigen::AngleAxisd(random.uniform(0, 3), random_vector(random).normalized()).toRotationMatrix();
    const Vec3 point = random_vector(random);
    // Away from the corners of the table by more than h: there the second derivative jumps.
    const double time = 0.1 + 0.173 * trial;
    const auto before = poses_at(frames, time - h), now = poses_at(frames, time), after = poses_at(frames, time + h);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const Pose pose = carried(now[f], rest);
      const Vec3 place = pose.to_fixed(point);
      const Vec3 difference = (carried(after[f], rest).to_fixed(point) - carried(before[f], rest).to_fixed(point)) / (2 * h);
      // Central difference: error h²/6 times the third derivative (up to some 1e4 m/s³ here), and rounding 1e-16/h.
      CHECK((pose.velocity_at(place) - difference).norm() < 1e-6);
      CHECK((pose.axes.transpose() * pose.axes - Mat3::Identity()).norm() < 1e-14);
      CHECK(pose.axes.determinant() == Approx(1).epsilon(1e-14));
    }
  }
}

TEST_CASE("a planetary vial moves on the closed-form epicycle") {
  const double disc = 30, vial = -45, arm = 0.06, radius = 0.03;
  const std::vector<Frame> frames = {{"disc", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), disc}},
                                     {"vial", 0, Rotating{Vec3(arm, 0, 0), Vec3::UnitZ(), vial}}};
  for (const double t : {0.0, 0.01, 1.0, 100.0}) {
    const Pose pose = poses_at(frames, t)[1];
    const Vec3 place = pose.to_fixed({arm + radius, 0, 0});
    const double a = disc * t, b = (disc + vial) * t;
    const Vec3 expected(arm * std::cos(a) + radius * std::cos(b), arm * std::sin(a) + radius * std::sin(b), 0);
    const Vec3 velocity(-arm * disc * std::sin(a) - radius * (disc + vial) * std::sin(b),
                        arm * disc * std::cos(a) + radius * (disc + vial) * std::cos(b), 0);
    CHECK((place - expected).norm() < 1e-14);
    CHECK((pose.velocity_at(place) - velocity).norm() < 1e-11);
    CHECK((pose.angular_velocity - Vec3(0, 0, disc + vial)).norm() < 1e-12);
  }
}

TEST_CASE("the angle under a speed table is the exact integral of the broken line") {
  const auto turned = [](double time) {
    const Pose pose = poses_at({{"table", -1, RotatingByTable{Vec3::Zero(), Vec3::UnitZ(), {0.5, 1.5, 2.0}, {1.0, 5.0, -2.0}}}}, time)[0];
    return std::pair{std::atan2(pose.axes(1, 0), pose.axes(0, 0)), pose.angular_velocity.z()};
  };
  const auto check = [&](double time, double angle, double speed) {
    const auto [found, found_speed] = turned(time);
    CHECK(std::remainder(found - angle, 2 * M_PI) == Approx(0).margin(1e-14));
    CHECK(found_speed == Approx(speed).epsilon(1e-14));
  };
  check(0, 0, 1);
  check(0.25, 0.25, 1);
  check(1.0, 0.5 + 0.5 * (1 + 3) * 0.5, 3);  // halfway up the ramp
  check(1.5, 0.5 + 3, 5);
  check(1.75, 3.5 + 0.5 * (5 + 1.5) * 0.25, 1.5);       // halfway down
  check(3.0, 3.5 + 0.5 * (5 - 2) * 0.5 - 2 * 1.0, -2);  // constant after the last
}

TEST_CASE("an oscillation starts from rest position and swings by its amplitude") {
  const std::vector<Frame> frames = {{"shaker", -1, Oscillating{Vec3(0, 0, 0.01), 50, 0}}};
  CHECK(poses_at(frames, 0)[0].origin.norm() == 0);
  CHECK(poses_at(frames, 0.005)[0].origin.z() == Approx(0.01).epsilon(1e-12));
  CHECK(poses_at(frames, 0)[0].velocity.z() == Approx(0.01 * 2 * M_PI * 50).epsilon(1e-12));
  const std::vector<Frame> shifted = {{"shaker", -1, Oscillating{Vec3(0.01, 0, 0), 50, 1.2}}};
  CHECK(poses_at(shifted, 0)[0].origin.norm() == 0);
}

TEST_CASE("a million turns leave no drift") {
  const std::vector<Frame> frames = {{"drum", -1, Rotating{Vec3(1, 2, 3), Vec3::UnitX(), 2 * M_PI}}};
  const Pose pose = poses_at(frames, 1e6)[0];
  // The angle 2π·10⁶ itself is known to a rounding of 1e-9 only.
  CHECK((pose.axes - Mat3::Identity()).norm() < 2e-9);
  CHECK((pose.to_fixed({1, 2, 3}) - Vec3(1, 2, 3)).norm() < 1e-14);
}
