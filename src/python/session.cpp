#include "src/python/session.hpp"
#include <algorithm>
#include <chrono>
#include "src/base/error.hpp"
#include "src/case/mill_headlines.hpp"
#include "src/output/run_plan.hpp"

namespace quern {

Session::Session(const Case& c, int threads) : duration_(c.duration), built_(build_case(c)), observers_(built_.observe), known_before_(mill_headlines(c, built_)) {
  Simulation& s = built_.simulation;
  s.team = std::make_shared<ThreadTeam>(threads > 0 ? threads : useful_threads(s.particles.owned));
  s.start(observers_.needs_collisions());
  s.measure_energy();
  health_.emplace(s);
  observers_.see(s);
}

void Session::step(std::int64_t steps, const std::function<void()>& pause) {
  Simulation& s = built_.simulation;
  using Time = std::chrono::steady_clock;
  Time::time_point paused = Time::now();
  for (std::int64_t k = 0; k < steps; ++k) {
    s.step();
    observers_.see(s);
    if (s.clock.step % steps_between_checks == 0 || k + 1 == steps) {
      s.measure_energy();
      if (const auto complaint = health_->complaint(s)) throw RunError("The run failed " + *complaint + ".");
    }
    if (Time::now() - paused > std::chrono::milliseconds(100)) {
      pause();
      paused = Time::now();
    }
  }
}

void Session::run_until(double time, const std::function<void()>& pause) {
  const Clock& clock = built_.simulation.clock;
  step(std::max<std::int64_t>(0, last_step(time, clock.time_step) - clock.step), pause);
}

Ledger Session::ledger() const {
  Ledger now = built_.simulation.ledger;
  const auto [kinetic, potential] = built_.simulation.kinetic_and_potential();
  now.kinetic = kinetic, now.potential = potential;
  return now;
}

std::vector<Table> Session::tables() {
  observers_.finish(built_.simulation);
  return observers_.tables();
}

std::vector<Headline> Session::headlines() {
  observers_.finish(built_.simulation);
  std::vector<Headline> all = observers_.headlines();
  all.insert(all.end(), known_before_.begin(), known_before_.end());
  return all;
}

}  // namespace quern
