#include "src/output/report_scripts.hpp"

#ifdef QUERN_REPORT_SCRIPTS
// The files as they are, among the constants of the program.
#define QUERN_EMBED(name, file)                                                                                                        \
  asm(".pushsection .rodata\n.global quern_" #name "\nquern_" #name ":\n.incbin \"" file "\"\n.global quern_" #name "_end\nquern_" #name \
      "_end:\n.byte 0\n.popsection\n")
QUERN_EMBED(plots, QUERN_REPORT_SCRIPTS "/plots.js");
QUERN_EMBED(charge, QUERN_REPORT_SCRIPTS "/charge.js");
extern "C" const char quern_plots[], quern_plots_end[], quern_charge[], quern_charge_end[];

namespace quern {
std::string_view plots_script() { return {quern_plots, static_cast<std::size_t>(quern_plots_end - quern_plots)}; }
std::string_view charge_script() { return {quern_charge, static_cast<std::size_t>(quern_charge_end - quern_charge)}; }
}  // namespace quern
#else
namespace quern {
std::string_view plots_script() { return {}; }
std::string_view charge_script() { return {}; }
}  // namespace quern
#endif
