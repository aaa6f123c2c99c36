#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include "src/case/keys.hpp"
#include "src/case/reference.hpp"
#include "src/case/schema.hpp"
#include "src/cli/commands.hpp"
#include "src/diagnose/catalogue.hpp"
#include "src/diagnose/equations.hpp"

namespace quern {
namespace {

struct ListWords {
  std::string what;
  bool markdown = false, schema = false;
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

constexpr Entry shapes[] = {{"sphere", "species.<name>.diameter, or a size distribution", ""},
                            {"superquadric", "species.<name>.semi_axes and exponents: ellipsoids, rounded boxes and cylinders", "Barr 1981"}};

constexpr Entry mills[] = {{"tumbling", "A drum about its axis, with lifters and end walls or as a slice of an endless mill", ""},
                          {"planetary", "Vials that turn on a turning disc: any speed ratio, axes upright, lying or like spokes, cylinders or STL", ""},
                          {"stirred", "A shaft with discs (with holes) or pins, or an STL stirrer, that turns in a vessel; standing or lying", ""}};

void print_entries(std::span<const Entry> entries) {
  for (const Entry& e : entries) fmt::print("{}\n    {}{}\n", e.name, e.meaning, e.source[0] ? fmt::format(" ({})", e.source) : "");
}

// The keys that a line of the catalogue names: "pair.<a>.<b>.bridge_volume, .surface_tension", the further ones in brackets.
std::vector<const Key*> keys_named(const std::string& line) {
  std::vector<const Key*> keys;
  std::string table;
  std::size_t at = 0;
  while (at < line.size()) {
    const std::size_t from = line.find_first_not_of(" ,()", at);
    if (from == line.npos) break;
    at = std::min(line.find_first_of(" ,()", from), line.size());
    std::string path = line.substr(from, at - from);
    if (path[0] == '.') path = table + path;
    table = path.substr(0, path.rfind('.'));
    for (const Key& key : all_keys())
      if (path == key.path) keys.push_back(&key);
  }
  return keys;
}

void print_effects() {
  fmt::print("What a case can leave out and `quern diagnose` can find. Every effect is off unless a key turns it on.\n");
  for (const EffectEntry& effect : all_effects()) {
    fmt::print("\n{}\n", effect.name);
    if (const EffectEquation one = equation_of(effect.name); !one.equation.empty()) fmt::print("  equation    {}\n              {}\n", one.equation, one.where);
    fmt::print("  signature   {}\n  parted by   {}\n", effect.signature, effect.experiment);
    if (effect.source[0]) fmt::print("  source      {}\n", effect.source);
    for (const Key* key : keys_named(effect.keys)) fmt::print("{}", key_as_text(*key, key->path, 11));
  }
  fmt::print("\nWhat is in no law goes in as a table: a force on the bodies, [force.<name>], or in their contacts, extra_force.\n");
  fmt::print("{}\n{}", keys_as_text("force."), keys_as_text("pair.<a>.<b>.extra_force"));
}

int print_list(const ListWords& words) {
  if (words.what == "laws") print_entries(laws), fmt::print("\n{}", keys_as_text("pair."));
  if (words.what == "effects") print_effects();
  if (words.what == "shapes") print_entries(shapes), fmt::print("\n{}", keys_as_text("species."));
  if (words.what == "mills") print_entries(mills), fmt::print("\n{}", keys_as_text("mill."));
  if (words.what == "keys") fmt::print("{}", words.schema ? case_schema() : words.markdown ? case_reference() : keys_as_text());
  return 0;
}

}  // namespace

void add_list(CLI::App& program, Action& action) {
  auto words = std::make_shared<ListWords>();
  CLI::App* command = program.add_subcommand("list", "What there is: laws, effects, shapes, mills, or every key of a case");
  command->add_option("WHAT", words->what, "laws, effects, shapes, mills or keys")->required()->check(CLI::IsMember({"laws", "effects", "shapes", "mills", "keys"}));
  command->add_flag("--markdown", words->markdown, "keys: as the page docs/case-reference.md");
  command->add_flag("--schema", words->schema, "keys: as docs/case.schema.json, by which editors complete and check cases");
  command->callback([words, &action] { action = [words] { return print_list(*words); }; });
}

}  // namespace quern
