#include "mills/tumbling.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include "mills/power_models.hpp"
#include "src/base/error.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

TumblingMill plain_mill() {
  TumblingMill mill;
  mill.diameter = 0.545, mill.length = 0.304, mill.speed = 4;
  return mill;
}

double enclosed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    sum += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return sum;
}

MillCharge large_charge() {
  MillCharge charge;
  charge.diameter = 5, charge.length = 7, charge.filling = 0.35, charge.speed_fraction = 0.72;
  return charge;
}

double exponent(double (*power)(const MillCharge&)) {
  MillCharge one = large_charge(), two = large_charge();
  two.diameter = 2 * one.diameter;
  return std::log2(power(two) / power(one));
}

double hogg(const MillCharge& charge) { return hogg_fuerstenau_power(charge, 0.6); }

}  // namespace

TEST_CASE("The critical speed balances weight at the top of the ball's circle", "[tumbling_mill]") {
  // 0.545 m mill, 54 mm balls: √(19.62/0.491) = √39.9593 = 6.32134 rad/s = 60.364 rpm.
  CHECK(critical_speed(0.545, 0.054) == Approx(6.32134).epsilon(1e-6));
  CHECK(critical_speed(0.545, 0.054) * 30 / pi == Approx(60.364).epsilon(1e-5));
  CHECK(speed_at_fraction(0.7, 0.545, 0.054) == Approx(0.7 * 6.32134).epsilon(1e-6));
  // ω² (D − d)/2 = g
  CHECK(std::pow(critical_speed(3, 0.1, 1.62), 2) * (3 - 0.1) / 2 == Approx(1.62).epsilon(1e-14));
  CHECK_THROWS_AS(critical_speed(0.5, 0.6), InputError);
}

TEST_CASE("Mill axes are right-handed, z along the axis, y up", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  CHECK((pose_of(mill).axes.col(0) + Vec3::UnitX()).norm() < 1e-15);
  CHECK((pose_of(mill).axes.col(1) - Vec3::UnitZ()).norm() < 1e-15);
  for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 2), Vec3(1, -2, 0.5)}) {
    mill.axis = axis;
    const Mat3 axes = pose_of(mill).axes;
    CHECK((axes.transpose() * axes - Mat3::Identity()).norm() < 1e-14);
    CHECK(axes.determinant() == Approx(1).epsilon(1e-14));
    CHECK((axes.col(2) - axis.normalized()).norm() < 1e-15);
  }
}

TEST_CASE("Shell and ends of a mill push inward", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  mill.centre = {1, 2, 3};
  const std::vector<Wall> walls = walls_of(mill, 0);
  REQUIRE(walls.size() == 3);
  const auto distance = [&](std::size_t wall, const Vec3& own) {
    Touch touches[most_touches];
    const int count = touch_wall(walls[wall], pose_of(mill).to_fixed(own), 10, touches);
    REQUIRE(count == 1);
    return touches[0].distance;
  };
  const Vec3 own(0.1, 0.05, 0.02), outside(0.3, 0, 0);
  CHECK(distance(0, own) == Approx(0.2725 - std::hypot(0.1, 0.05)).epsilon(1e-12));
  CHECK(distance(0, outside) == Approx(0.2725 - 0.3).epsilon(1e-9));
  CHECK(distance(1, own) == Approx(0.152 + 0.02).epsilon(1e-12));
  CHECK(distance(2, own) == Approx(0.152 - 0.02).epsilon(1e-12));
  CHECK(distance(2, {0, 0, 0.16}) == Approx(-0.008).epsilon(1e-9));
  for (const Wall& wall : walls) CHECK(wall.frame == 0);
}

TEST_CASE("A mill with periodic ends has no end walls and a period of its length", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  mill.ends = TumblingMill::Ends::periodic;
  mill.centre = {0, 5, 0};
  CHECK(walls_of(mill, 0).size() == 1);
  const Domain domain = domain_of(mill);
  CHECK(domain.period[1] == 0.304);
  CHECK(domain.lower[1] == Approx(5 - 0.152).epsilon(1e-14));
  CHECK(domain.period[0] + domain.period[2] == 0);
  mill.axis = {1, 1, 0};
  CHECK_THROWS_AS(domain_of(mill), InputError);
}

TEST_CASE("Lifters are closed prisms of the told section, facing outward", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  Lifters& lifters = mill.lifters;
  lifters.count = 6, lifters.height = 0.02, lifters.width = 0.03;
  double section = 0;
  SECTION("rectangular") { section = 0.03 * 0.022; }
  SECTION("trapezoid") {
    lifters.shape = Lifters::Shape::trapezoid, lifters.face_angle = pi / 3;
    section = 0.03 * 0.002 + 0.02 * (0.03 - 0.02 / std::tan(pi / 3));
  }
  SECTION("bar") {
    lifters.shape = Lifters::Shape::bar;
    // The half round is drawn with 12 facets: 12 triangles of r²/2 sin 15°.
    section = 0.03 * (0.002 + 0.02 - 0.015) + 12 * 0.5 * 0.015 * 0.015 * std::sin(pi / 12);
  }
  const Mesh mesh = lifter_mesh(mill);
  CHECK(enclosed_volume(mesh) == Approx(6 * section * 0.304 * 1.04).epsilon(1e-12));
  double innermost = 1, longest = 0;
  for (const Vec3& v : mesh.vertices) innermost = std::min(innermost, v.head<2>().norm()), longest = std::max(longest, v.z());
  // The top of a flat lifter is nearest to the axis in its middle, where there is no vertex.
  CHECK(innermost >= 0.2725 - 0.02);
  CHECK(innermost <= std::hypot(0.2725 - 0.02, 0.015));
  CHECK(longest > 0.152);
}

TEST_CASE("A ball rests on a lifter's top at the told height", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  mill.lifters.count = 8, mill.lifters.height = 0.02, mill.lifters.width = 0.03;
  const std::vector<Wall> walls = walls_of(mill, 0);
  REQUIRE(walls.back().name == "mill.lifters");
  Touch touches[most_touches];
  REQUIRE(touch_wall(walls.back(), pose_of(mill).to_fixed({0.24, 0, 0.03}), 0.02, touches) == 1);
  CHECK(touches[0].distance == Approx(0.2525 - 0.24).epsilon(1e-12));
  CHECK((touches[0].normal - pose_of(mill).axes * Vec3(-1, 0, 0)).norm() < 1e-12);
}

TEST_CASE("A mill turns at its speed about its axis, after a ramp if told", "[tumbling_mill]") {
  TumblingMill mill = plain_mill();
  mill.axis = {0, 3, 0};
  const auto steady = std::get<Rotating>(frame_of(mill).motion);
  CHECK(steady.speed == 4);
  CHECK((steady.axis - Vec3::UnitY()).norm() < 1e-15);
  mill.ramp = 2;
  const auto ramp = std::get<RotatingByTable>(frame_of(mill).motion);
  CHECK(ramp.time == std::vector<double>{0, 2});
  CHECK(ramp.speed == std::vector<double>{0, 4});
}

TEST_CASE("The number of balls for a filling counts their bulk volume", "[tumbling_mill]") {
  const TumblingMill mill = plain_mill();
  CHECK(volume(mill) == Approx(pi / 4 * 0.545 * 0.545 * 0.304).epsilon(1e-14));
  // 0.4 · 0.6 · 0.0709178 m³ = 0.01702027 m³; a 20 mm ball has 4.18879e-6 m³: 4063.3 balls.
  CHECK(balls_for_filling(mill, 0.4, SizeDistribution::mono(0.02)) == 4063);
  CHECK(balls_for_filling(mill, 0, SizeDistribution::mono(0.02)) == 0);
  CHECK_THROWS_AS(balls_for_filling(mill, 1.1, SizeDistribution::mono(0.02)), InputError);
}

TEST_CASE("A mill that cannot be is refused", "[tumbling_mill]") {
  const auto refused = [](auto&& change) {
    TumblingMill mill = plain_mill();
    mill.lifters.count = 8, mill.lifters.height = 0.02, mill.lifters.width = 0.03;
    change(mill);
    CHECK_THROWS_AS(check(mill), InputError);
  };
  refused([](TumblingMill& m) { m.diameter = 0; });
  refused([](TumblingMill& m) { m.length = -1; });
  refused([](TumblingMill& m) { m.speed = std::nan(""); });
  refused([](TumblingMill& m) { m.axis = Vec3::Zero(); });
  refused([](TumblingMill& m) { m.lifters.count = 60; });
  refused([](TumblingMill& m) { m.lifters.height = 0.3; });
  refused([](TumblingMill& m) { m.lifters.shape = Lifters::Shape::trapezoid, m.lifters.face_angle = 0.5; });
  refused([](TumblingMill& m) { m.lifters.shape = Lifters::Shape::bar, m.lifters.height = 0.01; });
}

TEST_CASE("Hogg and Fuerstenau's power is the torque of a leaning segment", "[tumbling_mill][power_models]") {
  // A half-full mill: the segment is a half circle, its first moment (2/3) R³. D 1 m, L 1 m, 7800 · 0.6 = 4680 kg/m³,
  // sin α = 0.5: torque 4680 · 9.81 · (2/3)/8 · 0.5 = 1912.95 N m; half of the critical speed √19.62 = 4.429447: 2.2147234 rad/s.
  MillCharge charge;
  charge.diameter = 1, charge.length = 1, charge.filling = 0.5, charge.speed_fraction = 0.5;
  CHECK(hogg_fuerstenau_power(charge, pi / 6) == Approx(1912.95 * 2.2147234).epsilon(1e-6));
  charge.filling = 0;
  CHECK(hogg_fuerstenau_power(charge, pi / 6) < 1e-9);
  charge.filling = 1;
  CHECK(std::abs(hogg_fuerstenau_power(charge, pi / 6)) < 1e-9);
  MillCharge twice = large_charge();
  twice.speed_fraction *= 2;
  CHECK(hogg(twice) == Approx(2 * hogg(large_charge())).epsilon(1e-14));
  CHECK(exponent(hogg) == Approx(2.5).epsilon(1e-12));
}

TEST_CASE("Bond's power follows its equation", "[tumbling_mill][power_models]") {
  // D 5 m, L 7 m, J 0.35, φ 0.72: balls 4680 · 0.35 · π/4 · 25 · 7 = 225133 kg; 5^0.3 = 1.620657; 3.2 − 1.05 = 2.15;
  // 2^(9 − 7.2) = 3.482202, 1 − 0.1/3.482202 = 0.971283; 4.879 · 1.620657 · 2.15 · 0.72 · 0.971283 = 11.88874 kW/t;
  // times 1.08 and 225.133 t: 2890.68 kW.
  CHECK(bond_power(large_charge()) == Approx(2.89068e6).epsilon(2e-4));
  MillCharge empty = large_charge();
  empty.filling = 0;
  CHECK(bond_power(empty) == 0);
  CHECK(exponent(bond_power) == Approx(2.3).epsilon(1e-12));
  MillCharge slow = large_charge(), slower = large_charge();
  slow.speed_fraction = 2e-3, slower.speed_fraction = 1e-3;
  CHECK(bond_power(slow) / bond_power(slower) == Approx(2).epsilon(1e-5));
}

TEST_CASE("Morrell's charge lies where its equations say", "[tumbling_mill][power_models]") {
  // J 0.35, φ 0.72: limit 0.35 · 2.9864 = 1.04524; exp(−19.42 · 0.32524) = 0.0018069; toe 2.5307 · 0.9296 · 0.9981931 + π/2 = 3.919085;
  // shoulder π/2 − 2.348289 · (0.413552 + (1.54 − 1.848456) · 0.35) = π/2 − 2.348289 · 0.3055924 = 0.853177.
  const MorrellShape shape = morrell_shape(large_charge());
  CHECK(shape.toe == Approx(3.919085).epsilon(1e-6));
  CHECK(shape.shoulder == Approx(0.853177).epsilon(1e-5));
  CHECK(shape.active_fraction > 0.5);
  CHECK(shape.active_fraction < 1);
  CHECK(shape.inner_radius > 0);
  CHECK(shape.inner_radius < 2.5);
}

TEST_CASE("Morrell's power is the energy that its layers gain", "[tumbling_mill][power_models]") {
  const MillCharge charge = large_charge();
  const MorrellShape shape = morrell_shape(charge);
  const double z = std::pow(1 - charge.filling, 0.4532), r_m = 2.5, turns = 0.72 * std::sqrt(2 * 9.81 / 5) / (2 * pi);
  const double lift = std::sin(shape.shoulder) - std::sin(shape.toe);
  // Layer by layer: mass flow ρ L v dr, each gains g r (sin shoulder − sin toe) and v²/2.
  double sum = 0;
  constexpr int layers = 100000;
  const double thickness = (r_m - shape.inner_radius) / layers;
  for (int k = 0; k < layers; ++k) {
    const double r = shape.inner_radius + (k + 0.5) * thickness;
    const double v = 2 * pi * turns * r_m * (r - z * shape.inner_radius) / (r_m - z * shape.inner_radius);
    sum += 4680 * charge.length * v * thickness * (9.81 * r * lift + 0.5 * v * v);
  }
  CHECK(morrell_c_power(charge) == Approx(sum).epsilon(1e-8));
  CHECK(exponent(morrell_c_power) == Approx(2.5).epsilon(1e-12));
  MillCharge empty = charge, still = charge;
  empty.filling = 0, still.speed_fraction = 0;
  CHECK(std::abs(morrell_c_power(empty)) < 1e-6 * morrell_c_power(charge));
  CHECK(morrell_c_power(still) == 0);
}

TEST_CASE("The power models agree on an industrial mill within a quarter", "[tumbling_mill][power_models]") {
  const MillCharge charge = large_charge();
  const double bond = bond_power(charge);
  CHECK(morrell_c_power(charge) == Approx(bond).epsilon(0.25));
  // A repose of 35 to 45 degrees is what moving ball charges show.
  CHECK(hogg_fuerstenau_power(charge, 40 * pi / 180) == Approx(bond).epsilon(0.25));
}

TEST_CASE("Power models refuse what they cannot judge", "[tumbling_mill][power_models]") {
  MillCharge charge = large_charge();
  charge.speed_fraction = 1.2;
  CHECK_THROWS_AS(morrell_c_power(charge), InputError);
  CHECK_THROWS_AS(bond_power(charge), InputError);
  charge = large_charge();
  charge.filling = -0.1;
  CHECK_THROWS_AS(hogg(charge), InputError);
}
