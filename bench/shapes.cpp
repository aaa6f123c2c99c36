// How much slower superquadrics are than spheres of their volume: ellipsoids (axes 6, 5, 4 mm) and cubes (exponents 8) settle in a box that
// is periodic sideways, or turn in a drum; then their steps are timed, by the processor's clock. Words: bed or drum, number of grains, steps, seconds of settling.
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <string>
#include "src/base/random.hpp"
#include "src/contact/restitution.hpp"
#include "src/engine/simulation.hpp"

namespace {

using namespace quern;

constexpr double time_step = 2.4e-5, spacing = 12.6e-3;  // [s], [m]

Simulation scene(bool drum, int grains, const Superquadric* shape) {
  Simulation s;
  const Material steel{"grain", 7800, 1e8, 0.3};
  s.materials = {steel};
  s.species = {{"grain", 0}};
  s.pair_laws = {{HertzMindlin{effective_young(steel, steel), effective_shear(steel, steel), hertz_damping_ratio(0.6), 0.5}, {}, {}}};
  s.pair_kind = {0};
  s.clock.time_step = time_step;
  RandomStream random(1);
  const auto place = [&](const Vec3& centre) {
    const Vec3 velocity(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    const Rotation turn = Rotation(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    const Index row = shape ? s.particles.add_shape(triple(centre), *shape, 1, 1, steel.density, 0, 0) : s.particles.add_sphere(triple(centre), 4.93242414866e-3, steel.density, 0, 0);
    const auto at = static_cast<std::size_t>(row);
    if (shape) s.particles.orientation[at] = {turn.x(), turn.y(), turn.z(), turn.w()};
    set(s.particles.velocity[at], velocity);
  };
  if (shape) s.shapes = {make_superquadric({1, 1, 1}, 2, 2), *shape};
  if (drum) {
    // As long as the grains fill 40 % of it, whatever they are.
    constexpr double radius = 0.125;
    const double length = grains * 4.0 / 3.0 * std::numbers::pi * std::pow(4.932e-3, 3) / 0.6 / (0.4 * std::numbers::pi * radius * radius);
    s.domain.period[2] = std::max(spacing * 3, spacing * std::ceil(length / spacing));
    s.gravity = {0, -9.81, 0};
    s.frames = {{"turning", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), 6}}};
    Wall wall;
    wall.name = "drum";
    wall.surface = Revolved{radius, -1, radius, s.domain.period[2] + 1, Revolved::Side::inside};
    wall.frame = 0;
    s.walls = {wall};
    const int across = static_cast<int>(2 * radius / spacing);
    for (int y = 0; y < across; ++y)
      for (int x = 0; x < across; ++x)
        for (int z = 0; spacing * (z + 0.999) <= s.domain.period[2]; ++z) {
          const Vec3 centre(spacing * (x + 0.5) - radius, spacing * (y + 0.5) - radius, spacing * (z + 0.5));
          if (s.particles.size() < grains && std::hypot(centre.x(), centre.y()) < radius - 6.5e-3) place(centre);
        }
  } else {
    const int across = std::max(4, static_cast<int>(std::cbrt(grains / 1.5)));
    s.domain.period[0] = s.domain.period[1] = spacing * across;
    Wall floor;
    floor.name = "floor";
    floor.surface = Plane{};
    s.walls = {floor};
    for (int k = 0; k < grains; ++k) place(spacing * Vec3(k % across + 0.5, k / across % across + 0.5, k / across / across + 0.5));
  }
  s.start(false);
  return s;
}

double measured(const char* name, bool drum, int grains, int steps, double settling, const Superquadric* shape, double spheres) {
  Simulation s = scene(drum, grains, shape);
  const auto timed = [&](std::int64_t count) {
    const std::clock_t begin = std::clock();
    for (std::int64_t k = 0; k < count; ++k) s.step();
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  };
  const auto told = std::max<std::int64_t>(1, std::llround(settling / time_step / 5));
  for (int part = 1; part <= 5; ++part) {
    const double seconds = timed(told);
    fmt::print("{:10} settled {:.3g} s, {:.3g} million particle-steps/s\n", name, static_cast<double>(part * told) * time_step, 1e-6 * s.particles.owned * static_cast<double>(told) / seconds);
    std::fflush(stdout);
  }
  const double seconds = timed(steps);
  const double speed = s.particles.owned * static_cast<double>(steps) / seconds;
  fmt::print("{:10} {:.4g} million particle-steps/s, {:.3g} contacts per grain{}\n", name, 1e-6 * speed, 2.0 * s.contacts.sums.pair_contacts / s.particles.owned,
             spheres > 0 ? fmt::format(", {:.3g} times slower than spheres", spheres / speed) : "");
  std::fflush(stdout);
  return speed;
}

}  // namespace

int main(int argc, char** argv) {
  const bool drum = argc > 1 && std::string(argv[1]) == "drum";
  const int grains = argc > 2 ? std::stoi(argv[2]) : 2000, steps = argc > 3 ? std::stoi(argv[3]) : 1000;
  const double settling = argc > 4 ? std::stod(argv[4]) : 0.3;
  const Superquadric ellipsoid = make_superquadric({6e-3, 5e-3, 4e-3}, 2, 2);
  const double half = 4.058954711919763e-3;
  const Superquadric cube = make_superquadric({half, half, half}, 8, 8);
  fmt::print("{} of {} grains, one thread\n", drum ? "drum" : "bed", grains);
  const double spheres = measured("spheres", drum, grains, steps, settling, nullptr, 0);
  measured("ellipsoids", drum, grains, steps, settling, &ellipsoid, spheres);
  measured("cubes", drum, grains, steps, settling, &cube, spheres);
}
