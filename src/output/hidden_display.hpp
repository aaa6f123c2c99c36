// An X display that nobody sees: Debian's VTK draws through X.
#pragma once
#include <sys/types.h>
#include <string>

namespace quern {

// Starts a private Xvfb on a free display and makes it this process's DISPLAY; ends it and puts DISPLAY back when destroyed.
// Also where the user has a display: pictures must neither flash over it nor depend on its driver.
class HiddenDisplay {
 public:
  HiddenDisplay();
  ~HiddenDisplay();
  HiddenDisplay(const HiddenDisplay&) = delete;
  HiddenDisplay& operator=(const HiddenDisplay&) = delete;

  bool ready() const { return problem_.empty(); }
  const std::string& problem() const { return problem_; }  // one plain sentence

 private:
  pid_t server_ = -1;
  bool had_display_ = false;
  std::string old_display_;
  std::string problem_;
};

}  // namespace quern
