#include "src/particle/packing.hpp"
#include <catch2/catch.hpp>
#include <cmath>
#include "mills/tumbling.hpp"
#include "src/base/error.hpp"
#include "src/wall/solid.hpp"

using namespace quern;

namespace {

constexpr double pi = 3.141592653589793;

std::vector<Quad> balls_of(const Packing& packing) {
  std::vector<Quad> balls;
  for (std::size_t k = 0; k < packing.position.size(); ++k) {
    const Vec3& p = packing.position[k];
    balls.push_back({p.x(), p.y(), p.z(), 0.5 * packing.diameter[k]});
  }
  return balls;
}

Portion portion(SizeDistribution sizes, double filling) {
  Portion result;
  result.sizes = std::move(sizes);
  result.filling = filling;
  return result;
}

TumblingMill mill_with_lifters(TumblingMill::Ends ends) {
  TumblingMill mill;
  mill.diameter = 0.5, mill.length = 0.2, mill.ends = ends;
  mill.lifters.count = 8, mill.lifters.height = 0.03, mill.lifters.width = 0.03;
  return mill;
}

PackingRequest request_for(const TumblingMill& mill, Portion what) {
  PackingRequest request;
  request.region = inside_of(mill);
  request.domain = domain_of(mill);
  request.portions = {std::move(what)};
  return request;
}

// Brute force over all pairs and images, so that it shares no search with what it judges.
double closest_gap(const std::vector<Quad>& balls, const Domain& domain) {
  double least = 1e300;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (std::size_t j = i + 1; j < balls.size(); ++j) {
      const Triple<double> d = domain.nearest({balls[j].x - balls[i].x, balls[j].y - balls[i].y, balls[j].z - balls[i].z});
      least = std::min(least, length(d) - balls[i].w - balls[j].w);
    }
  }
  return least;
}

}  // namespace

TEST_CASE("A dense packing reaches its filling without any overlap of balls, shell, ends and lifters", "[packing]") {
  const auto ends = GENERATE(TumblingMill::Ends::walls, TumblingMill::Ends::periodic);
  const auto sizes =
      GENERATE(as<SizeDistribution>{}, SizeDistribution::mono(0.015), SizeDistribution::rosin_rammler(0.02, 1.5, 0.006, 0.04));
  const TumblingMill mill = mill_with_lifters(ends);
  const std::vector<Wall> walls = walls_of(mill, -1);
  const PackingRequest request = request_for(mill, portion(sizes, 0.35));
  const Packing packing = pack_dense(request, walls);
  const std::vector<Quad> balls = balls_of(packing);
  REQUIRE(balls.size() > 400);
  CHECK(closest_gap(balls, request.domain) >= 0);
  CHECK(largest_overlap(balls, walls, request.domain) == 0);
  CHECK(packing.largest_overlap == 0);
  // One ball of the largest size, in bulk, is what the filling may miss; drawing each 1/n of the sizes keeps within a few.
  const double ball = std::pow(sizes.largest(), 3) * 0.5235987755982988 / 0.6 / volume(mill);
  CHECK(std::abs(packing.filling - 0.35) < 2 * ball);
  double solid = 0, top = -1;
  const Pose pose = pose_of(mill);
  for (const Quad& b : balls) {
    solid += 4.18879020478639 * b.w * b.w * b.w;
    const Vec3 own = pose.to_local(vec(b));
    top = std::max(top, b.z);
    REQUIRE(own.head<2>().norm() + b.w <= 0.25 * (1 + 1e-9));
    if (ends == TumblingMill::Ends::walls) REQUIRE(std::abs(own.z()) + b.w <= 0.1 * (1 + 1e-9));
  }
  CHECK(packing.filling == Approx(solid / 0.6 / volume(mill)).epsilon(1e-12));
  // At rest 35 % of a circle end 0.119 D below its middle; a loose packing stands higher, but below the axis by far or near.
  CHECK(top < 0.05);
}

TEST_CASE("The same seed gives the same packing, another seed another", "[packing]") {
  const TumblingMill mill = mill_with_lifters(TumblingMill::Ends::walls);
  const std::vector<Wall> walls = walls_of(mill, -1);
  PackingRequest request = request_for(mill, portion(SizeDistribution::mono(0.02), 0.2));
  const Packing one = pack_dense(request, walls), two = pack_dense(request, walls);
  CHECK(one.position == two.position);
  request.seed = 2;
  CHECK(pack_dense(request, walls).position != one.position);
}

TEST_CASE("Rain falls with its speed and overlaps nothing, nor the balls that are there already", "[packing]") {
  const TumblingMill mill = mill_with_lifters(TumblingMill::Ends::periodic);
  const std::vector<Wall> walls = walls_of(mill, -1);
  PackingRequest request = request_for(mill, portion(SizeDistribution::mono(0.03), 0.1));
  const std::vector<Quad> first = balls_of(pack_rain(request, walls));
  request.present = first;
  request.seed = 9;
  request.speed = 1.5;
  request.portions = {portion(SizeDistribution::list({0.01, 0.02}, {1, 1}, Weight::mass), 0.1)};
  request.portions[0].species = 3;
  const Packing rain = pack_rain(request, walls);
  CHECK((rain.velocity - Vec3(0, 0, -1.5)).norm() < 1e-15);
  CHECK(rain.species == std::vector<std::uint8_t>(rain.position.size(), 3));
  std::vector<Quad> all = balls_of(rain);
  all.insert(all.end(), first.begin(), first.end());
  CHECK(closest_gap(all, request.domain) >= 0);
  CHECK(largest_overlap(all, walls, request.domain) == 0);

  const Packing dense = pack_dense(request, walls);
  all = balls_of(dense);
  all.insert(all.end(), first.begin(), first.end());
  CHECK(closest_gap(all, request.domain) >= 0);
  CHECK(largest_overlap(all, walls, request.domain) == 0);
}

TEST_CASE("A count is kept exactly and a mass to the ball", "[packing]") {
  Portion what;
  what.sizes = SizeDistribution::mono(0.01);
  what.density = 7800;
  RandomStream random(1);
  what.count = 321;
  CHECK(diameters_of(what, 1, random).size() == 321);
  what.count = 0, what.mass = 5;
  // One ball: 7800 · π/6 · 1e-6 = 4.0841e-3 kg, so 1224.3 balls.
  CHECK(diameters_of(what, 1, random).size() == 1224);
  what.count = 1;
  CHECK_THROWS_AS(diameters_of(what, 1, random), InputError);
}

TEST_CASE("Boxes and spheres are filled in axes of their own", "[packing]") {
  PackingRequest request;
  request.region.pose.origin = {1, 2, 3};
  request.region.pose.axes = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  request.portions = {portion(SizeDistribution::mono(0.05), 0.8)};
  SECTION("box") { request.region.shape = BoxRegion{{0, 0, 0}, {1, 0.5, 0.4}}; }
  SECTION("sphere") { request.region.shape = SphereRegion{0.4}; }
  const std::vector<Quad> balls = balls_of(pack_dense(request, {}));
  CHECK(closest_gap(balls, {}) >= 0);
  for (const Quad& b : balls) {
    const Vec3 p = request.region.pose.to_local(vec(b));
    if (const auto* box = std::get_if<BoxRegion>(&request.region.shape)) {
      REQUIRE(((p - box->lower).array() >= b.w - 1e-9).all());
      REQUIRE(((box->upper - p).array() >= b.w - 1e-9).all());
    } else {
      REQUIRE(p.norm() + b.w <= 0.4 + 1e-9);
    }
  }
}

TEST_CASE("What does not fit is refused with what does", "[packing]") {
  PackingRequest request;
  request.region.shape = BoxRegion{{0, 0, 0}, {1, 1, 1}};
  request.portions = {portion(SizeDistribution::mono(0.1), 1.5)};
  CHECK_THROWS_WITH(pack_dense(request, {}), Catch::Contains("fit") && Catch::Contains("filling 0.9"));
  CHECK_THROWS_WITH(pack_rain(request, {}), Catch::Contains("Dense packing fits more"));
  request.portions = {portion(SizeDistribution::mono(1.2), 0.9)};
  CHECK_THROWS_WITH(pack_dense(request, {}), Catch::Contains("does not fit"));
  request.portions = {portion(SizeDistribution::mono(0.5), 0.01)};
  CHECK_THROWS_WITH(pack_dense(request, {}), Catch::Contains("half a ball"));
  request.region.shape = BoxRegion{{0, 0, 0}, {1, -1, 1}};
  CHECK_THROWS_AS(pack_dense(request, {}), InputError);
}

TEST_CASE("Overlaps are found among balls, across periodic ends, with walls and within lifters", "[packing]") {
  Domain domain;
  domain.period[0] = 1;
  CHECK(largest_overlap({{0.05, 0.5, 0.5, 0.1}, {0.9, 0.5, 0.5, 0.1}}, {}, domain) == Approx(0.5).epsilon(1e-12));
  CHECK(largest_overlap({{0.05, 0.5, 0.5, 0.1}, {0.9, 0.5, 0.5, 0.1}}, {}, {}) == 0);
  CHECK(largest_overlap({{0, 0, 0, 0.1}, {0, 0, 0, 0.01}}, {}, {}) == Approx(11).epsilon(1e-12));
  const TumblingMill mill = mill_with_lifters(TumblingMill::Ends::walls);
  const std::vector<Wall> walls = walls_of(mill, -1);
  const Pose pose = pose_of(mill);
  const auto at = [&](const Vec3& own, double radius) {
    const Vec3 p = pose.to_fixed(own);
    return largest_overlap({{p.x(), p.y(), p.z(), radius}}, walls, {});
  };
  // Half way between two lifters.
  CHECK(at({0.245 * std::cos(pi / 8), 0.245 * std::sin(pi / 8), 0}, 0.01) == Approx(0.5).epsilon(1e-9));
  CHECK(at({0, 0, 0.095}, 0.01) == Approx(0.5).epsilon(1e-9));
  CHECK(at({0.215, 0, 0}, 0.01) == Approx(0.5).epsilon(1e-9));
  // The middle of a lifter, for a ball too small to touch its faces.
  CHECK(at({0.235, 0, 0}, 0.001) >= 1);
  CHECK(at({0.2, 0.1, 0}, 0.01) == 0);
}
