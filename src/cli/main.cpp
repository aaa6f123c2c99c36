// quern: discrete-element simulation of grinding. Exit status: 0 done; 1 the run failed; 2 the input is wrong, nothing was run.
#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include "src/base/error.hpp"
#include "src/base/say.hpp"
#include "src/case/reading.hpp"
#include "src/cli/commands.hpp"

namespace {

// Runs the command and says what went wrong.
int outcome(const quern::Action& action) {
  try {
    return action();
  } catch (const quern::InputError& e) {
    quern::say(fmt::format("{}\n", e.what()));
    return 2;
  } catch (const quern::RunError& e) {
    quern::say(fmt::format("{}\n", e.what()));
    return 1;
  } catch (const std::bad_alloc&) {
    quern::say("The memory of this machine is not enough; fewer particles need less.\n");
    return 1;
  } catch (const std::exception& e) {
    quern::say(fmt::format("quern failed in an unforeseen way: {}\n", e.what()));
    return 1;
  }
}

// Where a stream is closed, the next file opened would take its number, and what is said would be written into that file.
void fill_closed_streams() {
  int file = 0;
  do file = open("/dev/null", O_RDWR);
  while (file >= 0 && file <= STDERR_FILENO);
  if (file >= 0) close(file);
}

}  // namespace

int main(int argc, char** argv) {
  fill_closed_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files (ulimit -f) is an error like a full disk
  CLI::App program(
      "quern simulates grinding by the discrete element method.\nA case is a TOML file; `quern list keys` tells all that it can say.",
      "quern");
  program.require_subcommand(1);
  bool allow_outside = false;
  program.add_flag("--allow-outside", allow_outside, "A case may name files outside its own folder");
  program.set_version_flag("--version", std::string("quern ") + quern::program_version);
  quern::Action action;
  quern::add_run(program, action);
  quern::add_check(program, action);
  quern::add_sweep(program, action);
  quern::add_report(program, action);
  quern::add_validate(program, action);
  quern::add_list(program, action);
  quern::add_linearize(program, action);
  quern::add_grinding(program, action);
  quern::add_breakage(program, action);
  quern::add_calibrate(program, action);
  quern::add_diagnose(program, action);
  quern::add_convert(program, action);
  quern::add_manual(program, action);
  for (CLI::App* command : program.get_subcommands({})) command->fallthrough();
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program.exit(e);
    quern::say(fmt::format("quern: {}. `quern --help` tells what is allowed.\n", e.what()));
    return 2;
  }
  if (allow_outside) setenv(quern::outside_is_allowed, "1", 1);
  const int status = outcome(action);
  // A full disk behind `>` is told; a reader that has gone away knows.
  errno = 0;
  if (std::fflush(stdout) != 0 && errno != EPIPE) {
    quern::say(fmt::format("The standard output cannot be written: {}.\n", std::strerror(errno)));
    return status == 0 ? 1 : status;
  }
  return status;
}
