// bench — how fast the engine is, beside others, on the same work. One program; prints one `name value unit` a line.
#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include "bench/agglomerate.hpp"
#include "bench/scene.hpp"
#include "src/base/error.hpp"

namespace {

using namespace bench;

// The greatest memory that this process ever had resident [B]; 0 where the system does not tell.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::stod(line.substr(6));
  return 0;
}

// Readings taken during the run.
struct Means {
  double kinetic = 0, contacts = 0, torque = 0;
  int count = 0;
  void read(quern::Simulation& s) {
    s.measure_energy();
    kinetic += s.ledger.kinetic;
    contacts += 2.0 * s.contacts.sums.pair_contacts / s.particles.owned;
    torque -= s.walls[0].torque.z;
    ++count;
  }
};

void advance(quern::Simulation& s, std::int64_t steps) {
  for (std::int64_t k = 0; k < steps; ++k) s.step();
}

State settled_state(Options o) {
  if (o.work == "agglomerate") return agglomerate_state(o.balls);
  const std::int64_t copies = o.work == "drum" ? o.copies : 1;
  o.balls /= copies;
  const auto settle = [&o](const State& from, double time) {
    quern::Simulation s = make_scene(o, from);
    advance(s, std::llround(time / time_step));
    return state_of(s, from);
  };
  State state = settle(packed_state(o), o.settle);
  return copies > 1 ? settle(repeated(state, copies), 0.1) : state;
}

void run(const Options& o) {
  const State start = o.start.empty() ? settled_state(o) : read_state(o.start);
  if (!o.write.empty()) write_state(start, o.write);
  if (o.steps == 0) return;
  double gap = 0;
  quern::Simulation s = o.work == "agglomerate" ? make_agglomerate(o, start, gap) : make_scene(o, start);
  Means means;
  advance(s, o.warm);
  const std::int64_t searches = s.contacts.searches;
  const auto begin = std::chrono::steady_clock::now();
  for (std::int64_t k = 1; k <= o.steps; ++k) {
    s.step();
    if (o.sample > 0 && k % o.sample == 0) means.read(s);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (o.sample == 0) means.read(s);
  s.measure_energy();
  const double balls = s.particles.owned, steps = static_cast<double>(o.steps);
  fmt::print("work {} of {} balls, {} threads, {}\n", o.work, s.particles.owned, s.team->size(), s.kernels->name);
  fmt::print("speed {:.6g} particle-steps/s\n", balls * steps / seconds);
  fmt::print("step {:.4g} ms\n", 1e3 * seconds / steps);
  fmt::print("searches {:.4g} per step\n", static_cast<double>(s.contacts.searches - searches) / steps);
  fmt::print("skin {:.4g} mm\n", 1e3 * s.contacts.skin);
  fmt::print("kinetic {:.6g} J\n", means.kinetic / means.count);
  fmt::print("contacts {:.5g} per ball\n", means.contacts / means.count);
  fmt::print("torque {:.6g} Nm\n", means.torque / means.count);
  if (!s.bonds.empty()) {
    fmt::print("bonds {:.6g} per grain, {:.8g} mm of gap at most\n", static_cast<double>(s.bonds.list.size()) / balls, 1e3 * gap);
    fmt::print("damage {:.4g} of the bonds\n", s.bonds.damage());
  }
  fmt::print("closure {:.2e}\n", s.ledger.closure());
  fmt::print("memory {:.4g} bytes per ball\n", peak_memory() / balls);
}

}  // namespace

int main(int argc, char** argv) try {
  run(read_options(argc, argv));
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 2;
}
