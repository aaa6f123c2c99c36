// quern: discrete-element simulation of grinding. Exit status: 0 done; 1 the run failed; 2 the input is wrong, nothing was run.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include "src/base/error.hpp"
#include "src/cli/commands.hpp"

int main(int argc, char** argv) {
  CLI::App program("quern simulates grinding by the discrete element method.\nA case is a TOML file; `quern list keys` tells all that it can say.", "quern");
  program.require_subcommand(1);
  program.set_version_flag("--version", std::string("quern ") + quern::program_version);
  quern::Action action;
  quern::add_run(program, action);
  quern::add_check(program, action);
  quern::add_sweep(program, action);
  quern::add_validate(program, action);
  quern::add_list(program, action);
  quern::add_linearize(program, action);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return program.exit(e);
    fmt::print(stderr, "quern: {}. `quern --help` tells what is allowed.\n", e.what());
    return 2;
  }
  try {
    return action();
  } catch (const quern::InputError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const quern::RunError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "The memory of this machine is not enough; fewer particles need less.\n");
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "quern failed in an unforeseen way: {}\n", e.what());
    return 1;
  }
}
