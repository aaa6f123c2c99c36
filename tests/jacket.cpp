// Superquadrics inside a cylinder's jacket: they touch it with exactly those places that are farther from the axis than all around them, and
// the energy of what bounces there stays.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include "shapes/wall_touching.hpp"
#include "src/base/random.hpp"

using namespace quern;

namespace {

constexpr double pi = std::numbers::pi;

Mat3 turned(double angle, const Vec3& about) { return Eigen::AngleAxisd(angle, about.normalized()).toRotationMatrix(); }
Vec3 random_way(RandomStream& random) { return {random.normal(), random.normal(), random.normal()}; }
double power_of_ten(RandomStream& random, double from, double to) { return std::pow(10.0, random.uniform(from, to)); }

// How far a body reaches in a direction across the axis, and its slope with the angle.
struct Look {
  double angle, value, slope;
  Vec3 place;
};
Look look(const PlacedShape& body, double angle) {
  const Vec3 n(std::cos(angle), std::sin(angle), 0), along(-n.y(), n.x(), 0);
  const Vec3 place = body.centre + body.axes * (body.size * body.shape->support.first(body.axes.transpose() * n).gradient);
  return {angle, n.dot(place), along.dot(place), place};
}
// Where between two angles the slope changes its sign.
Look halved(const PlacedShape& body, Look a, Look b) {
  for (int k = 0; k < 60; ++k) {
    const Look middle = look(body, 0.5 * (a.angle + b.angle));
    ((middle.slope < 0) == (a.slope < 0) ? a : b) = middle;
  }
  return look(body, 0.5 * (a.angle + b.angle));
}

// A place farther from the axis than those around it, found by looking in all directions in which there may be one; how much it
// stands out against the nearest place between it and the next.
struct Top {
  Look at;
  double prominence;
};
constexpr int looks = 4000;
std::vector<Top> all_tops(const PlacedShape& body, double& spacing) {
  const double off = body.centre.head<2>().norm(), bound = body.size * body.shape->bounding_radius, middle = std::atan2(body.centre.y(), body.centre.x());
  const double window = off > bound ? 1.001 * std::asin(bound / off) : pi;
  spacing = 2 * window / looks;
  std::vector<Top> tops;
  double lowest = 0;  // since the last top; 0: nothing before
  Look before = look(body, middle - window);
  for (int k = 1; k <= looks; ++k) {
    const Look here = look(body, middle - window + k * spacing);
    if (before.slope < 0 && here.slope >= 0) {
      lowest = halved(body, before, here).value;
      if (!tops.empty()) tops.back().prominence = std::min(tops.back().prominence, tops.back().at.value - lowest);
    } else if (before.slope >= 0 && here.slope < 0) {
      const Look top = halved(body, before, here);
      tops.push_back({top, lowest > 0 ? top.value - lowest : top.value});
    }
    before = here;
  }
  return tops;
}

// Turned anyhow, with a face, an edge or a corner towards the jacket, exactly, nearly or by chance; turned about that direction or not.
Mat3 axes_towards_x(RandomStream& random, int kind) {
  if (kind == 0) return turned(random.uniform(0, pi), random_way(random));
  const double tilt = kind % 2 == 0 ? 0 : power_of_ten(random, -15, -1);
  Mat3 axes = Mat3::Identity();
  if (kind == 3 || kind == 4) axes = turned(0.25 * pi, Vec3::UnitZ());
  if (kind == 5) axes = turned(std::atan(std::sqrt(0.5)), Vec3::UnitY()) * turned(0.25 * pi, Vec3::UnitZ());
  if (kind == 6 || kind == 7) axes = turned(power_of_ten(random, -6, 0), Vec3::UnitX());
  return turned(tilt, random_way(random)) * axes;
}

}  // namespace

TEST_CASE("a superquadric touches a jacket with each place farther from the axis than all around it, once, and with no other", "[jacket]") {
  RandomStream random(51);
  int touching = 0, several = 0, exactly = 0;
  for (int k = 0; k < 4000; ++k) {
    const auto axis = [&] { return 4e-3 * std::pow(3.0, random.uniform(-0.5, 0.5)); };
    const auto exponent = [&] { return 2 * std::pow(10.0, random.uniform()); };
    const Superquadric shape = k % 2 == 0 ? make_superquadric({4e-3, 4e-3, 4e-3}, 8, 8) : make_superquadric({axis(), axis(), axis()}, exponent(), exponent());
    const double length = shape.volume_radius, off = shape.bounding_radius * power_of_ten(random, 0, 1.5), around = k % 3 == 0 ? 0 : random.uniform(-pi, pi);
    const Mat3 turn = turned(around, Vec3::UnitZ());
    const PlacedShape body{&shape, 1, turn * Vec3(off, 0, 1e-3), turn * axes_towards_x(random, k / 2 % 8)};
    double spacing = 0, farthest = 0;
    const std::vector<Top> tops = all_tops(body, spacing);
    for (const Top& top : tops) farthest = std::max(farthest, top.at.value);
    const double radius = farthest - length * power_of_ten(random, -5, -1.5);
    ShapeContact contacts[most_places];
    double gap = 0;
    const int count = touch_inside_cylinder(body, radius, contacts, gap);
    // Exponents near 2 make tops that lie so close to each other that looking does not tell them apart.
    const double one_place = 2 * spacing, the_same = 1e-9 * length / radius;  // [rad]
    const auto angle_of = [](const ShapeContact& c) { return std::atan2(-c.normal.y(), -c.normal.x()); };
    const auto apart = [](double a, double b) { return std::abs(std::remainder(a - b, 2 * pi)); };
    CAPTURE(k, shape.semi_axes().transpose() * 1e3, shape.n1(), shape.n2(), radius * 1e3, count, tops.size());
    touching += count, several += count > 1;
    for (const Top& top : tops) {
      int found = 0;
      for (int c = 0; c < count; ++c) {
        if (apart(angle_of(contacts[c]), top.at.angle) > one_place) continue;
        ++found;
        CHECK(contacts[c].overlap == Approx(top.at.value - radius).margin(1e-6 * length));
        if (apart(angle_of(contacts[c]), top.at.angle) > the_same) continue;
        ++exactly;
        CHECK(contacts[c].overlap == Approx(top.at.value - radius).margin(1e-10 * length));
        // As exactly as the angle can be told: on an edge along the axis a small turn carries the place far.
        const double doubt = (look(body, top.at.angle + 4e-15).place - look(body, top.at.angle - 4e-15).place).norm();
        CHECK((contacts[c].on_first - top.at.place).norm() < 1e-6 * length + doubt);
      }
      CAPTURE(top.at.angle, (top.at.value - radius) / length, top.prominence / length);
      CHECK(found <= 1);
      if (top.at.value > radius + 1e-9 * length && top.prominence > 2e-6 * length) CHECK(found == 1);
    }
    for (int c = 0; c < count; ++c) {
      const double angle = angle_of(contacts[c]);
      CHECK(contacts[c].residual < 1e-8 * length);
      CHECK(look(body, angle - spacing).value < radius + contacts[c].overlap);
      CHECK(look(body, angle + spacing).value < radius + contacts[c].overlap);
      for (int d = 0; d < c; ++d) CHECK(apart(angle, angle_of(contacts[d])) > one_place);
    }
  }
  CHECK(touching > 4000);
  CHECK(several > 400);
  CHECK(exactly > 0.95 * touching);
}

TEST_CASE("where a superquadric does not touch a jacket, the gap that is told is there", "[jacket]") {
  RandomStream random(52);
  int told = 0;
  for (int k = 0; k < 500; ++k) {
    const Superquadric shape = make_superquadric({4e-3, 4e-3, 4e-3}, 8, 8);
    const double off = shape.bounding_radius * power_of_ten(random, 0, 1.5);
    const PlacedShape body{&shape, 1, {off, 0, 0}, axes_towards_x(random, k % 8)};
    double spacing = 0, farthest = 0;
    for (const Top& top : all_tops(body, spacing)) farthest = std::max(farthest, top.at.value);
    const double free = shape.bounding_radius * power_of_ten(random, -6, -0.5);
    ShapeContact contacts[most_places];
    double gap = -1;
    REQUIRE(touch_inside_cylinder(body, farthest + free, contacts, gap) == 0);
    CHECK(gap >= 0);
    CHECK(gap < free + 1e-12 * off);
    told += gap > 0.5 * std::min(free, 0.1 * shape.bounding_radius);
  }
  CHECK(told > 400);
}

TEST_CASE("a rod longer than a tube is wide leans against both of its sides", "[jacket]") {
  const Superquadric rod = make_superquadric({2e-3, 2e-3, 30e-3}, 8, 2);
  for (const double off : {0.0, 1e-9, 1e-4}) {
    const PlacedShape body{&rod, 1, {0, off, 0}, turned(0.5, Vec3::UnitX())};
    double spacing = 0, farthest = 0;
    for (const Top& top : all_tops(body, spacing)) farthest = std::max(farthest, top.at.value);
    ShapeContact contacts[most_places];
    double gap = 0;
    REQUIRE(touch_inside_cylinder(body, farthest - 3e-4, contacts, gap) == 2);
    CHECK(contacts[0].normal.dot(contacts[1].normal) == Approx(-1).epsilon(1e-3));
  }
}
