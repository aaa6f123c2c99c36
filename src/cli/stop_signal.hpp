// SIGINT, SIGTERM and SIGHUP as a flag that long work polls.
#pragma once
#include <atomic>
#include <cstdint>

namespace quern {

// Until the flag is watched: these signals end the program with a sentence and the exit status 128 + signal.
void leave_on_stop_signals();

// From now on the signals set the flag instead of ending the program; another one, half a second later or more, ends it with a sentence.
// Returns the flag: 0, or the number of the signal.
const std::atomic<int>* watch_stop_signals();

}  // namespace quern
