// Contacts of shapes followed from one step to the next are those that a search for each finds, and the same bits in every instruction set.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>
#include "shapes/touching.hpp"
#include "src/base/random.hpp"
#include "src/contact/kernels.hpp"
#include "src/contact/shape_meeting.hpp"

using namespace quern;

namespace {

Vec3 random_direction(RandomStream& random) { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); }

PosedShape posed(const PlacedShape& body) {
  PosedShape pose;
  for (int k = 0; k < 3; ++k) pose.axis[k] = row(body.axes.col(k), 1 / (body.size * body.shape->semi_axes()[k]));
  pose.centre = row(body.centre, body.size * body.shape->volume_radius);
  pose.exponents = {body.shape->n1(), body.shape->n2(), 0, 0};
  return pose;
}

}  // namespace

TEST_CASE("contacts of shapes followed through a small move are those that a search finds", "[shape_meeting]") {
  RandomStream random(51);
  const auto axis = [&] { return 1e-3 * std::pow(5.0, random.uniform()); };
  std::vector<Superquadric> shapes;
  std::vector<PlacedShape> bodies;
  std::vector<Quad> shaped(shaped_rows);
  std::vector<KeptPair> pairs;
  const double exponents[][2] = {{2, 2}, {8, 8}, {5.5, 5.5}, {8, 2}, {20, 20}, {3, 7.3}};
  for (int k = 0; k < 6000; ++k) {
    const double* e = exponents[k / 1000];
    shapes.push_back(make_superquadric({axis(), axis(), axis()}, e[0], e[1]));
  }
  for (int k = 0; k + 1 < 6000; k += 2) {
    const auto axes = [&] { return Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix(); };
    const Superquadric &s = shapes[static_cast<std::size_t>(k)], &t = shapes[static_cast<std::size_t>(k) + 1];
    PlacedShape first{&s, 1, Vec3::Zero(), axes()}, second{&t, 1, Vec3::Zero(), axes()};
    const Vec3 n = random_direction(random);
    const auto reach = [&](const PlacedShape& body) { return Vec3(body.axes * body.shape->support.first(body.axes.transpose() * n).gradient); };
    const double size = std::min(s.volume_radius, t.volume_radius);
    first.centre = reach(first) + reach(second) - 2e-3 * size * n;
    const ShapeContact c = touch_from(first, second, n);
    if (!c.touching) continue;
    shaped.push_back(row(c.normal));
    shaped.push_back(row(first.axes.transpose() * (c.on_first - first.centre)));
    shaped.push_back(row(second.axes.transpose() * (c.on_second - second.centre)));
    first.centre += 1e-4 * size * random_direction(random);
    first.axes = Eigen::AngleAxisd(1e-4, random_direction(random)).toRotationMatrix() * first.axes;
    const auto slot = static_cast<Index>(pairs.size() + 1), at = static_cast<Index>(bodies.size());
    bodies.push_back(first), bodies.push_back(second);
    pairs.push_back({at, at + 1, slot});
  }
  std::vector<PosedShape> poses;
  for (const PlacedShape& body : bodies) poses.push_back(posed(body));
  const auto met = [&](const char* kernels) {
    std::vector<Quad> memory = shaped;
    std::vector<Meeting> meetings(pairs.size());
    if (const Kernels* found = find_kernels(kernels)) shape_meetings(*found).meet(poses.data(), pairs.data(), static_cast<Index>(pairs.size()), memory.data(), meetings.data());
    return meetings;
  };
  const std::vector<Meeting> meetings = met("portable");
  std::size_t answered = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Meeting& m = meetings[k];
    if (m.arm.w == 0) continue;
    ++answered;
    const PlacedShape &first = bodies[2 * k], &second = bodies[2 * k + 1];
    const double size = std::min(first.shape->volume_radius, second.shape->volume_radius);
    const ShapeContact c = touch_from(first, second, vec(shaped[static_cast<std::size_t>(shaped_rows) * (k + 1)]));
    CAPTURE(k, first.shape->n1(), first.shape->n2());
    REQUIRE(c.touching == (m.normal.w >= 0));
    CHECK(std::abs(m.normal.w - c.overlap) < 1e-8 * size);
    if (c.touching) CHECK((vec(m.arm) + first.centre - 0.5 * (c.on_first + c.on_second)).norm() < 1e-5 * size);
  }
  CHECK(10 * answered > 9 * pairs.size());
  for (const char* kernels : {"avx2", "avx512"})
    if (find_kernels(kernels)) {
      const std::vector<Meeting> other = met(kernels);
      CHECK(std::memcmp(other.data(), meetings.data(), meetings.size() * sizeof(Meeting)) == 0);
    }
}
