// Effects as a case asks for them.
#include <catch2/catch.hpp>
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/contact/restitution.hpp"

using namespace quern;

namespace {

struct File {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("quern_effects_" + std::to_string(getpid()) + ".toml");
  File() {
    std::ofstream(path) << R"(
duration = "10 ms"
gravity = [0, 0, 0]
[material.steel]
density = 7800
young = "206 GPa"
[pair.default]
restitution = 0.8
[species.ball]
material = "steel"
diameter = "10 mm"
[wall.floor]
type = "plane"
material = "steel"
[insert.one]
species = "ball"
positions = [[0, 0, "6 mm"]]
velocity = [0, 0, -1]
)";
  }
  ~File() { std::filesystem::remove(path); }
  Simulation with(const std::vector<std::string>& keys) const {
    std::vector<std::string> overrides;
    for (const std::string& key : keys) overrides.push_back("pair.default." + key);
    return build(read_case(path.string(), overrides));
  }
};

double restitution_of(Simulation s) {
  s.start(false);
  while (s.clock.time() < 2e-3) s.step();
  return s.particles.velocity[0].z;
}

}  // namespace

TEST_CASE("a case without effects has none, and each key of an effect switches its own on", "[effects][case]") {
  const File file;
  CHECK_FALSE(file.with({}).pair_laws[0].extras.any());
  for (const char* key : {"tangential_compliance=0", "torsional_friction=0.1", "restitution_exponent=0.2", "viscoelastic_time=1e-8", "hardening=100", "stiffness_power=0.1",
                          "powder_layers=1", "unloading_ratio=2", "yield_pressure=1e9", "surface_energy=0.1", "wave_admittance=1e-3", "bridge_volume=1e-12"}) {
    CAPTURE(key);
    CHECK(file.with({key}).pair_laws[0].extras.any());
  }
  const Extras film = file.with({"film_viscosity=1e-3", "film_thickness=1e-5", "film_cutoff=1e-7"}).pair_laws[0].extras;
  CHECK(film.lubrication.thickness == 1e-5);
  const Extras table = file.with({"extra_force_at=[0, 1e-6, 3e-6]", "extra_force=[0, 5, 1]", "extra_force_phase=unloading"}).pair_laws[0].extras;
  CHECK(table.table.points == 3);
  CHECK(table.table.value(2e-6) == Approx(3));
  CHECK(table.table.value(9e-6) == Approx(1));
  CHECK(table.table.phase == ForceTable::Phase::unloading);
}

// Tolerance: that of a measured restitution, at the automatic step.
TEST_CASE("a case's falling restitution is measured in the run at its automatic step", "[effects][case]") {
  const File file;
  CHECK(restitution_of(file.with({"restitution_exponent=0.2", "reference_speed=0.1"})) == Approx(1 - 0.2 * std::pow(10, 0.2)).margin(2e-3));
  CHECK(restitution_of(file.with({"restitution=1", "unloading_ratio=8"})) == Approx(0.5).margin(2e-3));
}

TEST_CASE("the limit of the time step knows what effects make stiffer", "[effects][case]") {
  const File file;
  const auto limit = [&](const std::vector<std::string>& keys) { return time_step_limit(file.with(keys), 2).limit; };
  const double plain = limit({});
  CHECK(limit({"friction=0.3", "tangential_compliance=0.001"}) < 0.5 * plain);
  CHECK(limit({"hardening=1e8"}) < 0.7 * plain);
  CHECK(limit({"film_viscosity=10", "film_thickness=1e-5", "film_cutoff=1e-9"}) < 0.5 * plain);
  CHECK(limit({"surface_energy=0.01"}) == Approx(plain).epsilon(0.1));
}
