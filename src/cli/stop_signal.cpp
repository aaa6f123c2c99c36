#include "src/cli/stop_signal.hpp"
#include <unistd.h>
#include <csignal>
#include <cstring>
#include <ctime>

namespace quern {
namespace {

// A signal handler can reach nothing but globals.
std::atomic<int> received{0};
std::atomic<bool> polled{false};
std::atomic<std::int64_t> received_at{0};  // [ms]

std::int64_t now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * std::int64_t{1000} + t.tv_nsec / 1000000;
}

[[noreturn]] void leave(const char* words, int signal) {
  if (write(STDERR_FILENO, words, std::strlen(words)) < 0) {
  }  // nobody listens: leave all the same
  _exit(128 + signal);
}

extern "C" void note_signal(int signal) {
  if (!polled) leave("Stopped before the run began; nothing was written.\n", signal);
  if (received == 0) {
    received_at = now();
    received = signal;
    return;
  }
  // `timeout` and terminals tell a process and its group: the same wish, twice.
  constexpr std::int64_t same_wish = 500;
  if (now() - received_at > same_wish) leave("Stopped at once; the last checkpoint stands.\n", signal);
}

void listen() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
  // A terminal that closes; but whoever started the run with nohup wants it to go on.
  struct sigaction old {};
  if (sigaction(SIGHUP, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

}  // namespace

void leave_on_stop_signals() { listen(); }

const std::atomic<int>* watch_stop_signals() {
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);
  polled = true;
  listen();
  return &received;
}

}  // namespace quern
