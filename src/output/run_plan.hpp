// When a run ends and looks after itself, and by how many threads it is done.
#pragma once
#include <cstdint>

namespace quern {

// Often enough that a failure is found near its cause, seldom enough to cost nothing.
inline constexpr std::int64_t steps_between_checks = 200;

// The step at which a run of that duration [s] ends.
std::int64_t last_step(double duration, double time_step);

// More threads than this do not pay.
int useful_threads(std::int64_t particles);

}  // namespace quern
