// src/cli — the commands of the program, and their progress. Nothing worth testing alone.
#pragma once
#include <functional>

namespace CLI {
class App;
}

namespace quern {

inline constexpr const char* program_version = "0.1.0";

// Set by the command that the user chose; returns the exit status.
using Action = std::function<int()>;

void add_run(CLI::App& program, Action& action);
void add_check(CLI::App& program, Action& action);
void add_sweep(CLI::App& program, Action& action);
void add_report(CLI::App& program, Action& action);
void add_validate(CLI::App& program, Action& action);
void add_list(CLI::App& program, Action& action);
void add_linearize(CLI::App& program, Action& action);
void add_grinding(CLI::App& program, Action& action);
void add_breakage(CLI::App& program, Action& action);
void add_calibrate(CLI::App& program, Action& action);
void add_diagnose(CLI::App& program, Action& action);
void add_convert(CLI::App& program, Action& action);
// Last: it tells of those before it.
void add_manual(CLI::App& program, Action& action);

}  // namespace quern
