#include "src/output/hidden_display.hpp"
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cstdlib>

namespace quern {
namespace {

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become_server(int number_out, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // no server outlives a killed run
  if (getppid() != parent) _exit(127);
  setpgid(0, 0);  // ^C in the terminal is for the run alone
  const int nothing = open("/dev/null", O_RDWR);
  if (number_out == 3) fcntl(3, F_SETFD, 0);
  else dup2(number_out, 3);
  for (int stream = 0; stream < 3; ++stream) dup2(nothing, stream);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execlp("Xvfb", "Xvfb", "-displayfd", "3", "-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
  _exit(127);
}

// The display's number, which the server writes once it listens. Empty where it ended or took longer than 20 s.
std::string read_number(int from) {
  std::string number;
  char c = 0;
  pollfd waiting{from, POLLIN, 0};
  while (poll(&waiting, 1, 20000) == 1 && read(from, &c, 1) == 1) {
    if (c == '\n') return number;
    number += c;
  }
  return "";
}

}  // namespace

HiddenDisplay::HiddenDisplay() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    problem_ = "Pictures are skipped: no pipe to Xvfb could be opened.";
    return;
  }
  const pid_t parent = getpid();
  server_ = fork();
  if (server_ == 0) become_server(ends[1], parent);
  close(ends[1]);
  const std::string number = server_ > 0 ? read_number(ends[0]) : "";
  close(ends[0]);
  if (number.empty()) {
    problem_ = "Pictures are skipped: Xvfb, which draws them, is not installed or did not start (Debian package xvfb).";
    return;
  }
  if (const char* display = std::getenv("DISPLAY")) had_display_ = true, old_display_ = display;
  setenv("DISPLAY", (":" + number).c_str(), 1);
}

HiddenDisplay::~HiddenDisplay() {
  if (server_ > 0) {
    kill(server_, SIGTERM);
    waitpid(server_, nullptr, 0);
  }
  if (!problem_.empty()) return;
  if (had_display_) setenv("DISPLAY", old_display_.c_str(), 1);
  else unsetenv("DISPLAY");
}

}  // namespace quern
