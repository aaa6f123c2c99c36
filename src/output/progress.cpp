#include "src/output/progress.hpp"
#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include "src/base/say.hpp"

namespace quern {

std::string spoken_duration(double seconds) {
  const auto s = static_cast<long long>(std::ceil(std::clamp(seconds, 0.0, 1e15)));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  if (s < 86400) return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
  return fmt::format("{} d {} h", s / 86400, s % 86400 / 3600);
}

Progress::Progress(double start, double end, bool quiet)
    : start_(start),
      end_(end),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      begin_(std::chrono::steady_clock::now()),
      shown_(begin_) {}

double Progress::wall_clock() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

void Progress::show(double time) {
  // Reading the clock at every step of a small case would cost more than the step.
  if (quiet_ || ++calls_ % 16 != 0) return;
  const double done = end_ > start_ ? std::clamp((time - start_) / (end_ - start_), 0.0, 1.0) : 1.0;
  const Instant now = std::chrono::steady_clock::now();
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const std::string left = done > 0 && elapsed > 0.5 ? spoken_duration(elapsed * (1 - done) / done) + " left" : "";
  if (terminal_) {
    if (std::chrono::duration<double>(now - shown_).count() < 0.2) return;
    shown_ = now;
    constexpr int width = 40;
    std::string bar;
    for (int k = 0; k < width; ++k) bar += k < static_cast<int>(done * width) ? "█" : "░";
    say(fmt::format("\r{} {:3.0f} %  t = {:.4g} s  {:<20}", bar, 100 * done, time, left));
    std::fflush(stderr);
    open_ = true;
  } else if (static_cast<int>(10 * done) > tenths_ && done < 1) {
    tenths_ = static_cast<int>(10 * done);
    say(fmt::format("{} %  t = {:.4g} s  {}\n", 10 * tenths_, time, left));
  }
}

void Progress::end() {
  if (open_) std::fputs("\r\033[K", stderr);
  open_ = false;
}

}  // namespace quern
