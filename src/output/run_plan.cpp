#include "src/output/run_plan.hpp"
#include <algorithm>
#include <cmath>
#include <thread>

namespace quern {

std::int64_t last_step(double duration, double time_step) { return static_cast<std::int64_t>(std::ceil(duration / time_step * (1 - 1e-12))); }

int useful_threads(std::int64_t particles) {
  constexpr std::int64_t particles_per_thread = 2000;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return static_cast<int>(std::clamp<std::int64_t>(particles / particles_per_thread, 1, cores));
}

}  // namespace quern
