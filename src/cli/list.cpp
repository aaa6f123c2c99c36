#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include "src/case/keys.hpp"
#include "src/case/reference.hpp"
#include "src/cli/commands.hpp"

namespace quern {
namespace {

struct ListWords {
  std::string what;
  bool markdown = false;
};

struct Entry {
  const char *name, *meaning, *source;
};

constexpr Entry laws[] = {
    {"linear", "F_n = k_n δ − c_n v_n; F_t = k_s ξ + c_s v_t up to μ F_n. Restitution as asked, at every speed", "Cundall & Strack 1979; Schwager & Pöschel 2007"},
    {"hertz_mindlin", "F_n = 4/3 E*√R* δ^3/2 with Tsuji's damping; Mindlin's shear up to μ F_n. Restitution as asked, at every speed", "Tsuji et al. 1992"},
    {"deresiewicz", "Hertz with √δ damping; simplified Mindlin–Deresiewicz shear. Restitution as asked at reference_speed, falling with speed", "Mindlin & Deresiewicz 1953"},
    {"power_law", "F_n = k δ^r − q δ^s v_n, fitted to a ball on a load cell. Restitution follows from k and q", "Mishra & Murty 2001, eq. 12"},
    {"linearized", "The linear equivalent of a power law for a typical impact. Restitution follows from k' and q'", "Mishra & Murty 2001, eqs. 23–24"},
};

constexpr Entry effects[] = {
    {"sliding_friction", "pair.<a>.<b>.friction above 0", "Coulomb"},
    {"tangential_compliance", "pair.<a>.<b>.tangential_stiffness, or the laws hertz_mindlin and deresiewicz", "Mindlin 1949"},
    {"rolling_resistance", "pair.<a>.<b>.rolling_friction above 0", "Ai et al. 2011"},
    {"nonlinear_stiffness", "the laws hertz_mindlin, deresiewicz, power_law", "Hertz 1882"},
    {"air_drag", "medium.drag_coefficient above 0; medium.drag = \"schiller_naumann\" for the curve of a smooth sphere", "Newton; Schiller & Naumann 1933"},
    {"viscous_drag", "medium.viscous_drag above 0", "Stokes 1851"},
    {"buoyancy", "medium.buoyancy above 0", "Archimedes"},
    {"added_mass", "medium.added_mass_coefficient above 0", "Lamb, Hydrodynamics, § 92"},
    {"magnus", "medium.magnus_coefficient other than 0", "Rubinow & Keller 1961"},
    {"tabulated_force", "a table [force.<name>]", ""},
    {"velocity_dependent_restitution", "the law deresiewicz", "Mindlin & Deresiewicz 1953"},
};

constexpr Entry shapes[] = {{"sphere", "species.<name>.diameter, or a size distribution", ""}};

constexpr Entry mills[] = {{"tumbling", "A drum about its axis, with lifters and end walls or as a slice of an endless mill", ""},
                          {"planetary", "Vials that turn on a turning disc: any speed ratio, axes upright, lying or like spokes, cylinders or STL", ""},
                          {"stirred", "A shaft with discs (with holes) or pins, or an STL stirrer, that turns in a vessel; standing or lying", ""}};

void print_entries(std::span<const Entry> entries) {
  for (const Entry& e : entries) fmt::print("{}\n    {}{}\n", e.name, e.meaning, e.source[0] ? fmt::format(" ({})", e.source) : "");
}

int print_list(const ListWords& words) {
  if (words.what == "laws") print_entries(laws), fmt::print("\n{}", keys_as_text("pair."));
  if (words.what == "effects") print_entries(effects);
  if (words.what == "shapes") print_entries(shapes), fmt::print("\n{}", keys_as_text("species."));
  if (words.what == "mills") print_entries(mills), fmt::print("\n{}", keys_as_text("mill."));
  if (words.what == "keys") fmt::print("{}", words.markdown ? case_reference() : keys_as_text());
  return 0;
}

}  // namespace

void add_list(CLI::App& program, Action& action) {
  auto words = std::make_shared<ListWords>();
  CLI::App* command = program.add_subcommand("list", "What there is: laws, effects, shapes, mills, or every key of a case");
  command->add_option("WHAT", words->what, "laws, effects, shapes, mills or keys")->required()->check(CLI::IsMember({"laws", "effects", "shapes", "mills", "keys"}));
  command->add_flag("--markdown", words->markdown, "keys: as the page docs/case-reference.md");
  command->callback([words, &action] { action = [words] { return print_list(*words); }; });
}

}  // namespace quern
