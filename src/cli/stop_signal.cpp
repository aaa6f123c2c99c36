#include "src/cli/stop_signal.hpp"
#include <csignal>

namespace quern {
namespace {

// A signal handler can reach nothing but a global.
std::atomic<int> received{0};

extern "C" void note_signal(int signal) {
  received = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<int>* watch_stop_signals() {
  static_assert(std::atomic<int>::is_always_lock_free);
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
  return &received;
}

}  // namespace quern
