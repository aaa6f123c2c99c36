// Errors that a user reads: one or two plain sentences.
#pragma once
#include <stdexcept>
#include <string>

namespace quern {

// The input is wrong; nothing was run (exit status 2). The message names file, line and key, what was found, what is allowed.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The run failed (exit status 1). The message says at what time, on which particle, and what was saved.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The run failed because something cannot be written: the disk is full, read-only, gone. A sentence that names the file and the cause.
struct WriteError : RunError {
  using RunError::RunError;
};

}  // namespace quern
