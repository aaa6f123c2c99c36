// SIGINT and SIGTERM as a flag that long work polls.
#pragma once
#include <atomic>

namespace quern {

// From now on the two signals set the flag instead of ending the program; a second one ends it. Returns the flag: 0, or the
// number of the signal.
const std::atomic<int>* watch_stop_signals();

}  // namespace quern
