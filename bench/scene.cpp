#include "bench/scene.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/contact/restitution.hpp"
#include "src/particle/packing.hpp"
#include "src/wall/mesh.hpp"

namespace bench {
namespace {

using namespace quern;

constexpr double gravity = 9.81;  // [m/s²]
constexpr double drum_radius = drum_diameter / 2;
constexpr double solid_fraction = 1 - bulk_porosity;

double ball_volume() { return std::numbers::pi / 6 * std::pow(ball_diameter, 3); }

// The drum's jacket from z_0 to z_1, cut both ways so that its triangles are about right-angled and isosceles.
Mesh jacket(std::int64_t triangles, double z_0, double z_1) {
  const double around = 2 * std::numbers::pi * drum_radius;
  const double edge = std::sqrt(around * (z_1 - z_0) / (0.5 * static_cast<double>(triangles)));
  const auto columns = static_cast<Index>(std::max(3.0, std::round(around / edge)));
  const auto rows = static_cast<Index>(std::max(1.0, std::round((z_1 - z_0) / edge)));
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> corners;
  for (Index row = 0; row <= rows; ++row)
    for (Index column = 0; column < columns; ++column) {
      const double angle = 2 * std::numbers::pi * column / columns;
      vertices.emplace_back(drum_radius * std::cos(angle), drum_radius * std::sin(angle), z_0 + (z_1 - z_0) * row / rows);
    }
  for (Index row = 0; row < rows; ++row)
    for (Index column = 0; column < columns; ++column) {
      const Index next = (column + 1) % columns;
      const Index a = row * columns + column, b = row * columns + next, c = a + columns, d = b + columns;
      corners.push_back({a, c, b});
      corners.push_back({b, c, d});
    }
  return make_mesh(std::move(vertices), std::move(corners));
}

// Balls leave a periodic box by a little between two searches, so the jacket is longer than the box.
Wall drum_wall(const Options& options, double length) {
  Wall wall;
  wall.name = "drum";
  const double z_0 = -ball_diameter, z_1 = length + ball_diameter;
  if (options.mesh > 0)
    wall.surface = jacket(options.mesh, z_0, z_1);
  else
    wall.surface = Revolved{drum_radius, z_0, drum_radius, z_1, Revolved::Side::inside};
  return wall;
}

Wall floor_wall() {
  Wall wall;
  wall.name = "floor";
  wall.surface = Plane{};
  return wall;
}

bool is_drum(const Options& options) { return options.work == "drum"; }

Domain domain_of(const Options& options, const State& state) {
  Domain domain;
  for (int axis = 0; axis < 3; ++axis)
    if (is_drum(options) == (axis == 2)) domain.lower[axis] = state.lower[axis], domain.period[axis] = state.upper[axis] - state.lower[axis];
  return domain;
}

Vec3 gravity_of(const Options& options) { return is_drum(options) ? Vec3(0, -gravity, 0) : Vec3(0, 0, -gravity); }

}  // namespace

double drum_length(std::int64_t balls) {
  const double bulk = static_cast<double>(balls) * ball_volume() / solid_fraction;
  return bulk / (drum_filling * std::numbers::pi * drum_radius * drum_radius);
}

double drum_speed() { return speed_fraction * std::sqrt(2 * gravity / (drum_diameter - ball_diameter)); }

State packed_state(const Options& options) {
  State state;
  state.diameter = ball_diameter;
  state.density = density;
  PackingRequest request;
  if (is_drum(options)) {
    const double length = drum_length(options.balls), half = drum_radius + ball_diameter;
    state.lower = {-half, -half, 0};
    state.upper = {half, half, length};
    request.region.shape = CylinderRegion{drum_radius, 0, length};
  } else {
    const double height = static_cast<double>(options.balls) * ball_volume() / (bed_width * bed_width * 0.5) + 2 * ball_diameter;
    state.lower = {0, 0, -ball_diameter};
    state.upper = {bed_width, bed_width, height + ball_diameter};
    request.region.shape = BoxRegion{{0, 0, 0}, {bed_width, bed_width, height}};
  }
  Portion portion;
  portion.sizes = SizeDistribution::mono(ball_diameter);
  portion.count = options.balls;
  request.portions = {portion};
  request.gravity = gravity_of(options);
  request.domain = domain_of(options, state);
  const Packing packing = pack_dense(request, {is_drum(options) ? drum_wall(options, state.upper.z()) : floor_wall()});
  for (const Vec3& x : packing.position) state.balls.push_back({x, Vec3::Zero(), Vec3::Zero()});
  return state;
}

State repeated(const State& state, std::int64_t copies) {
  State result = state;
  result.balls.clear();
  const double length = state.upper.z() - state.lower.z();
  result.upper.z() = state.lower.z() + static_cast<double>(copies) * length;
  RandomStream random(1);
  for (std::int64_t copy = 0; copy < copies; ++copy)
    for (Ball ball : state.balls) {
      ball.position.z() += static_cast<double>(copy) * length;
      for (int axis = 0; axis < 3; ++axis) ball.position[axis] += 1e-9 * random.uniform();
      result.balls.push_back(ball);
    }
  return result;
}

void use_machine(const Options& options, Simulation& s) {
  s.team = std::make_shared<ThreadTeam>(options.threads);
  if (options.isa.empty()) return;
  s.kernels = find_kernels(options.isa.c_str());
  if (!s.kernels) throw InputError(fmt::format("this processor has no '{}'", options.isa));
}

Simulation make_scene(const Options& options, const State& state) {
  Simulation s;
  const Material steel{"ball", state.density, young, poisson};
  s.materials = {steel};
  s.species = {{"ball", 0}};
  s.pair_laws = {{HertzMindlin{effective_young(steel, steel), effective_shear(steel, steel), hertz_damping_ratio(restitution), friction}, {}, {}}};
  s.pair_kind = {0};
  s.domain = domain_of(options, state);
  s.gravity = gravity_of(options);
  s.clock.time_step = time_step;
  use_machine(options, s);
  if (is_drum(options)) {
    s.frames = {{"turning", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), drum_speed()}}};
    s.walls = {drum_wall(options, state.upper.z())};
    s.walls[0].frame = 0;
  } else {
    s.walls = {floor_wall()};
  }
  for (const Ball& ball : state.balls) {
    const auto row = static_cast<std::size_t>(s.particles.add_sphere(triple(ball.position), 0.5 * state.diameter, state.density, 0, 0));
    Quad &v = s.particles.velocity[row], &w = s.particles.spin[row];
    v = {ball.velocity.x(), ball.velocity.y(), ball.velocity.z(), v.w};
    w = {ball.spin.x(), ball.spin.y(), ball.spin.z(), w.w};
  }
  s.particles.owned = s.particles.size();
  s.start(false);
  return s;
}

State state_of(const Simulation& simulation, const State& like) {
  State state = like;
  const Particles& p = simulation.particles;
  for (std::size_t row = 0; row < p.position.size(); ++row) {
    Ball& ball = state.balls[static_cast<std::size_t>(p.id[row])];
    ball = {vec(xyz(p.position[row])), vec(xyz(p.velocity[row])), vec(xyz(p.spin[row]))};
    for (int axis = 0; axis < 3; ++axis) {
      const double period = simulation.domain.period[axis];
      if (period > 0) ball.position[axis] -= period * std::floor((ball.position[axis] - like.lower[axis]) / period);
    }
  }
  return state;
}

}  // namespace bench
