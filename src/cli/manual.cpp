// The manual page, the page docs/commands.md and the completion of a shell, all made from the commands themselves.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include "src/cli/commands.hpp"

namespace quern {
namespace {

using Options = std::vector<const CLI::Option*>;

std::vector<CLI::App*> commands_of(CLI::App& program) { return program.get_subcommands({}); }

Options options_of(const CLI::App& command, bool positional) {
  Options found;
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional() == positional && !option->get_group().empty()) found.push_back(option);
  return found;
}

bool takes_value(const CLI::Option& option) { return option.get_expected_max() > 0; }

std::string name_of(const CLI::Option& option) {
  if (option.get_positional()) return option.get_name(true);
  std::string name = option.get_name(false, true);  // "-h,--help"
  for (std::size_t comma = name.find(','); comma != name.npos; comma = name.find(',', comma + 2)) name.replace(comma, 1, ", ");
  if (takes_value(option)) name += " " + (option.get_type_name().empty() ? "VALUE" : option.get_type_name());
  return name;
}

std::string usage_of(const CLI::App& command) {
  std::string usage = "quern " + command.get_name();
  for (const CLI::Option* option : options_of(command, true)) usage += option->get_required() ? " " + option->get_name(true) : " [" + option->get_name(true) + "]";
  for (const CLI::Option* option : options_of(command, false))
    if (option->get_required()) usage += " " + name_of(*option);
  return usage + " [OPTIONS]";
}

std::string markdown(CLI::App& program) {
  std::string text =
      "# Commands\n\nMade by `quern manual markdown` from the program itself. With every command, `--allow-outside` lets a case name files outside its own folder.\n"
      "Exit status: 0 done; 1 the run failed; 2 the input is wrong and nothing was run; 128 + signal where it was stopped.\n";
  const auto cell = [](std::string words) {
    for (std::size_t bar = words.find('|'); bar != words.npos; bar = words.find('|', bar + 2)) words.replace(bar, 1, "\\|");
    for (std::size_t open = words.find('<'); open != words.npos; open = words.find('<', open + 2)) words.replace(open, 1, "\\<");
    return words;
  };
  for (const CLI::App* command : commands_of(program)) {
    text += fmt::format("\n## quern {}\n\n{}.\n\n`{}`\n\n| | |\n|---|---|\n", command->get_name(), cell(command->get_description()), usage_of(*command));
    for (const bool positional : {true, false})
      for (const CLI::Option* option : options_of(*command, positional))
        if (option->get_name() != "--help") text += fmt::format("| `{}` | {} |\n", cell(name_of(*option)), cell(option->get_description()));
  }
  return text;
}

std::string roff(std::string words) {
  std::string safe;
  for (const char c : words) {
    if (c == '\\') safe += "\\\\";
    else if (c == '-') safe += "\\-";
    else if (c == '\n') safe += ' ';
    else safe += c;
  }
  return safe.starts_with('.') || safe.starts_with('\'') ? "\\&" + safe : safe;
}

std::string manual_page(CLI::App& program) {
  std::string text = fmt::format(
      ".TH QUERN 1 \"\" \"quern {}\" \"User Commands\"\n.SH NAME\nquern \\- discrete\\-element simulation of grinding\n.SH SYNOPSIS\n.B quern\n.I COMMAND\n[OPTIONS]\n.SH DESCRIPTION\n"
      "Simulates the charge of tumbling, planetary and stirred mills. A case is a TOML file; \\fBquern list keys\\fR tells all that it can say.\n.SH COMMANDS\n",
      program_version);
  for (const CLI::App* command : commands_of(program)) {
    text += fmt::format(".SS {}\n{}.\n", roff(usage_of(*command)), roff(command->get_description()));
    for (const bool positional : {true, false})
      for (const CLI::Option* option : options_of(*command, positional))
        if (option->get_name() != "--help") text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(name_of(*option)), roff(option->get_description()));
  }
  return text +
         ".SH OPTIONS OF EVERY COMMAND\n.TP\n\\fB\\-\\-allow\\-outside\\fR\nA case may name files outside its own folder.\n.TP\n\\fB\\-\\-help\\fR\nWhat a command does and takes.\n"
         ".SH EXIT STATUS\n0 done; 1 the run failed; 2 the input is wrong, nothing was run; 128 + signal where it was stopped: \\fB\\-\\-resume\\fR goes on.\n";
}

std::string completion(CLI::App& program) {
  std::vector<std::string> names;
  std::string cases;
  for (const CLI::App* command : commands_of(program)) {
    names.push_back(command->get_name());
    std::string words;
    for (const CLI::Option* option : options_of(*command, false))
      for (const std::string& name : option->get_lnames()) words += " --" + name;
    if (command->get_name() == "list") words += " laws effects shapes mills keys";
    if (command->get_name() == "manual") words += " man markdown bash";
    cases += fmt::format("    {}) words='{} --allow-outside' ;;\n", command->get_name(), words);
  }
  return fmt::format(
      "# Completion of quern for bash; made by `quern manual bash`.\n"
      "_quern() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} words='{} --help --version'\n"
      "  [ \"$COMP_CWORD\" -eq 1 ] || case ${{COMP_WORDS[1]}} in\n{}    *) words= ;;\n  esac\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      "  [[ $word == -* || $COMP_CWORD -eq 1 ]] || COMPREPLY+=($(compgen -f -- \"$word\"))\n"
      "}}\n"
      "complete -o filenames -F _quern quern\n",
      fmt::join(names, " "), cases);
}

}  // namespace

void add_manual(CLI::App& program, Action& action) {
  auto form = std::make_shared<std::string>("man");
  CLI::App* command = program.add_subcommand("manual", "Writes the manual: as a manual page, as docs/commands.md, or the completion of bash");
  command->add_option("FORM", *form, "man (default), markdown or bash")->check(CLI::IsMember({"man", "markdown", "bash"}));
  command->callback([form, &program, &action] {
    action = [form, &program] {
      fmt::print("{}", *form == "markdown" ? markdown(program) : *form == "bash" ? completion(program) : manual_page(program));
      return 0;
    };
  });
}

}  // namespace quern
