#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>
#include "src/base/error.hpp"
#include "src/convert/converted.hpp"

namespace quern {
namespace {

using Words = std::vector<std::string>;

constexpr std::uintmax_t largest_script = 4 << 20;  // [bytes]
constexpr std::size_t longest_line = 1 << 20;        // [bytes], with the values of variables
constexpr int most_types = 100;

std::optional<double> number_in(const std::string& word) {
  double value = 0;
  const char* begin = word.c_str() + (word.starts_with('+') ? 1 : 0);
  const char* end = word.c_str() + word.size();
  const auto [stop, status] = std::from_chars(begin, end, value);
  return status == std::errc() && stop == end && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// As a text of TOML.
std::string quoted(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '"' || c == '\\') safe += '\\';
    if (static_cast<unsigned char>(c) < 32 || c == 127) safe += fmt::format("\\u{:04x}", c);
    else safe += c;
  }
  return "\"" + safe + "\"";
}

// A type of atoms, as a whole number that is there; none where it is out of range.
std::optional<int> type_in(std::optional<double> told) {
  const double type = told.value_or(1);
  return type >= 1 && type <= most_types && type == std::floor(type) ? std::optional(static_cast<int>(type)) : std::nullopt;
}

std::string vector_of(const std::array<double, 3>& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

struct Template {
  int type = 1;
  double density = 0, radius = 0;
};

struct Region {
  std::string keys;  // of insert.<name>.region
};

struct WallInput {
  std::string keys;
  int type = 1;
  std::string mesh;  // "" for a primitive
};

class Script {
 public:
  explicit Script(const std::string& file) : file_(file) {}

  Converted convert() {
    read_lines();
    return {written(), meshes_, left_out_};
  }

 private:
  void read_lines() {
    std::error_code problem;
    if (!std::filesystem::is_regular_file(file_, problem)) throw InputError(file_ + ": this file cannot be read; an input script of LIGGGHTS is needed.");
    if (std::filesystem::file_size(file_, problem) > largest_script) throw InputError(fmt::format("{}: this file is larger than {} MB; an input script of LIGGGHTS is a short text.", file_, largest_script >> 20));
    std::ifstream stream(file_);
    std::string line, whole;
    int first = 0;
    for (int number = 1; std::getline(stream, line); ++number) {
      if (line.find('\0') != line.npos) throw InputError(fmt::format("{}:{}: this is a binary file; an input script of LIGGGHTS is text.", file_, number));
      line = line.substr(0, line.find('#'));
      if (first == 0) first = number;
      const auto last = line.find_last_not_of(" \t\r");
      const bool goes_on = last != line.npos && line[last] == '&';
      whole += (goes_on ? line.substr(0, last) : line) + " ";
      if (goes_on) continue;
      take(whole, first);
      whole.clear(), first = 0;
    }
    if (first != 0) take(whole, first);
    if (templates_.empty() && properties_.empty() && walls_.empty()) throw InputError(file_ + ": no material, particle template or wall is in it; an input script of LIGGGHTS is needed.");
  }

  // A name for a case, for each word one of its own.
  std::string name_of(const std::string& word) {
    const auto [known, fresh] = names_.try_emplace(word);
    if (!fresh) return known->second;
    std::string name;
    for (const char c : word.substr(0, 60)) name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    while (!taken_.insert(name).second) name += fmt::format("_{}", names_.size());
    return known->second = name;
  }

  void leave_out(const std::string& why) { left_out_.push_back(fmt::format("{}:{}: {}: {}.", file_, line_, spoken_.substr(0, 100), why)); }

  // Variables by their values, as far as those are plain.
  std::string replaced(std::string text) const {
    for (std::size_t at = 0; (at = text.find('$', at)) != text.npos;) {
      const bool braces = at + 1 < text.size() && text[at + 1] == '{';
      const std::size_t from = at + (braces ? 2 : 1), to = braces ? text.find('}', from) : from + 1;
      if (to == text.npos || from >= text.size()) break;
      const auto known = variables_.find(text.substr(from, to - from));
      if (known == variables_.end()) {
        at = to;
        continue;
      }
      text.replace(at, to - at + (braces ? 1 : 0), known->second);
      // A variable may hold others, twice and twice again.
      if (text.size() > longest_line) throw InputError(fmt::format("{}:{}: with the values of its variables this line is longer than {} MB.", file_, line_, longest_line >> 20));
      at += known->second.size();
    }
    return text;
  }

  void take(const std::string& text, int line) {
    line_ = line;
    std::istringstream stream(replaced(text));
    Words w{std::istream_iterator<std::string>(stream), {}};
    if (w.empty()) return;
    spoken_ = fmt::format("{}", fmt::join(w, " "));
    const std::string& command = w[0];
    static const Words silent = {"atom_style", "atom_modify", "communicate", "newton", "neighbor", "neigh_modify", "processors", "echo", "log", "thermo", "thermo_style", "thermo_modify", "dump",
                                 "dump_modify", "restart", "compute", "compute_modify", "shell", "print", "hard_particles", "soft_particles", "fix_modify", "undump", "modify_timing", "write_restart", "create_box"};
    if (std::find(silent.begin(), silent.end(), command) != silent.end()) return;
    if (command == "units") {
      if (w.size() < 2 || w[1] != "si") throw InputError(fmt::format("{}:{}: found {}; only `units si` has a plain meaning here.", file_, line_, spoken_));
    } else if (command == "boundary") {
      if (std::find(w.begin(), w.end(), "p") != w.end()) leave_out("periodic directions need their extent, [periodic] of a case");
    } else if (command == "variable" && w.size() >= 4 && (w[2] == "equal" || w[2] == "index" || w[2] == "string")) {
      variable(w);
    } else if (command == "timestep" && w.size() == 2 && number_in(w[1])) {
      time_step_ = *number_in(w[1]);
    } else if (command == "run" && w.size() >= 2 && number_in(w[1])) {
      if (w.size() > 2 && w[2] == "upto") steps_ = std::max(steps_, *number_in(w[1]));
      else steps_ += *number_in(w[1]);
    } else if (command == "region" && w.size() >= 3) {
      region(w);
    } else if (command == "pair_style") {
      pair_style(w);
    } else if (command == "pair_coeff") {
    } else if (command == "fix" && w.size() >= 4) {
      fix(w);
    } else if (command == "unfix" && w.size() == 2) {
      if (inserts_.count(w[1]) == 0) leave_out("what ends during the run has no counterpart");
    } else {
      leave_out("it has no plain meaning here");
    }
  }

  void variable(const Words& w) {
    if (w[2] == "equal" && !number_in(w[3])) return leave_out("its value is not a plain number");
    variables_[w[1]] = w[3];
  }

  // Numbers of consecutive words; none where one is missing or no number.
  static std::optional<std::vector<double>> numbers(const Words& w, std::size_t from, std::size_t count) {
    std::vector<double> values;
    for (std::size_t k = from; k < from + count; ++k) {
      if (k >= w.size() || !number_in(w[k])) return std::nullopt;
      values.push_back(*number_in(w[k]));
    }
    return values;
  }

  static std::size_t place(const Words& w, const std::string& word, std::size_t from = 3) {
    return static_cast<std::size_t>(std::find(w.begin() + static_cast<std::ptrdiff_t>(std::min(from, w.size())), w.end(), word) - w.begin());
  }
  static std::optional<double> after(const Words& w, const std::string& word, std::size_t from = 3) {
    const std::size_t at = place(w, word, from);
    return at + 1 < w.size() ? number_in(w[at + 1]) : std::nullopt;
  }

  void region(const Words& w) {
    Region region;
    if (w[2] == "block") {
      const auto n = numbers(w, 3, 6);
      if (!n) return leave_out("its edges are not plain numbers");
      const auto& e = *n;
      region.keys = fmt::format("region.shape = \"box\"\nregion.centre = {}\nregion.size = {}\n", vector_of({0.5 * (e[0] + e[1]), 0.5 * (e[2] + e[3]), 0.5 * (e[4] + e[5])}),
                                vector_of({e[1] - e[0], e[3] - e[2], e[5] - e[4]}));
    } else if (w[2] == "cylinder" && w.size() >= 9 && w[3].size() == 1) {
      const auto n = numbers(w, 4, 5);
      const std::size_t axis = static_cast<std::size_t>(w[3][0] - 'x');
      if (!n || axis > 2) return leave_out("its sizes are not plain numbers");
      const auto& e = *n;
      std::array<double, 3> centre{}, along{};
      centre[(axis + 1) % 3] = axis == 1 ? e[1] : e[0], centre[(axis + 2) % 3] = axis == 1 ? e[0] : e[1];  // LIGGGHTS: x and z about y
      centre[axis] = 0.5 * (e[3] + e[4]), along[axis] = 1;
      region.keys = fmt::format("region.shape = \"cylinder\"\nregion.centre = {}\nregion.axis = {}\nregion.radius = {}\nregion.length = {}\n", vector_of(centre), vector_of(along), e[2], e[4] - e[3]);
    } else if (w[2] == "sphere") {
      const auto n = numbers(w, 3, 4);
      if (!n) return leave_out("its sizes are not plain numbers");
      region.keys = fmt::format("region.shape = \"sphere\"\nregion.centre = {}\nregion.radius = {}\n", vector_of({(*n)[0], (*n)[1], (*n)[2]}), (*n)[3]);
    } else {
      return leave_out("allowed are block, cylinder and sphere");
    }
    regions_[w[1]] = region;
  }

  void pair_style(const Words& w) {
    if (place(w, "hooke", 2) < w.size() || place(w, "hooke/stiffness", 2) < w.size())
      leave_out("the stiffness of its linear contacts has no counterpart: the pairs are hertz_mindlin; `law = \"linear\"` takes a normal_stiffness");
    if (place(w, "cohesion", 2) < w.size()) leave_out("cohesion is not converted; surface_energy of a pair is JKR's");
    if (const std::size_t at = place(w, "rolling_friction", 2); at + 1 < w.size() && w[at + 1] != "off") rolling_ = w[at + 1] == "cdt" ? "constant_torque" : "elastic_plastic";
  }

  void fix(const Words& w) {
    const std::string& kind = w[3];
    if (kind == "property/global" && w.size() >= 7) return property(w);
    if (kind.starts_with("particletemplate/sphere")) return particle_template(w);
    if (kind.starts_with("particledistribution/discrete")) return distribution(w);
    if (kind.starts_with("insert/")) return insertion(w);
    if (kind.starts_with("mesh/surface")) return mesh(w);
    if (kind == "move/mesh") return motion(w);
    if (kind == "wall/gran") return wall(w);
    if (kind == "gravity") return gravity(w);
    if (kind.starts_with("nve/") || kind == "check/timestep/gran" || kind.starts_with("print") || kind.starts_with("ave/")) return;
    leave_out("it has no plain meaning here");
  }

  void property(const Words& w) {
    std::vector<double> values;
    const bool pairs = w[5] == "peratomtypepair";
    for (std::size_t k = pairs ? 7 : 6; k < w.size(); ++k) {
      if (!number_in(w[k])) return leave_out("a value is not a plain number");
      values.push_back(*number_in(w[k]));
    }
    const auto types = pairs ? static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(values.size())))) : values.size();
    static const Words known = {"youngsModulus", "poissonsRatio", "coefficientRestitution", "coefficientFriction", "coefficientRollingFriction"};
    if (std::find(known.begin(), known.end(), w[4]) == known.end()) return leave_out("this property has no counterpart");
    if (pairs != w[4].starts_with("coefficient")) return leave_out(fmt::format("it is given {}", pairs ? "for pairs of types; allowed is one value for each type, peratomtype" : "for each type; allowed is one for each pair of types, peratomtypepair"));
    if (values.empty() || types > most_types || (pairs && types * types != values.size())) return leave_out(fmt::format("found {} values; allowed are as many as types, or their square", values.size()));
    types_ = std::max(types_, static_cast<int>(types));
    properties_[w[4]] = values;
  }

  void particle_template(const Words& w) {
    Template made;
    const std::optional<int> type = type_in(after(w, "atom_type") ? after(w, "atom_type") : after(w, "type"));
    if (!type) return leave_out("its type is out of range");
    made.type = *type;
    for (const char* word : {"density", "radius"}) {
      const std::size_t at = place(w, word);
      if (at + 2 >= w.size() || w[at + 1] != "constant" || !number_in(w[at + 2])) return leave_out(fmt::format("its {} is not `constant` and a plain number", word));
      (word[0] == 'd' ? made.density : made.radius) = *number_in(w[at + 2]);
    }
    types_ = std::max(types_, made.type);
    if (templates_.insert_or_assign(w[1], made).second) order_.push_back(w[1]);
  }

  void distribution(const Words& w) {
    const auto count = after(w, w[3]) && w.size() > 5 ? number_in(w[5]) : std::nullopt;
    std::vector<std::pair<std::string, double>> parts;
    double told = 0;
    for (std::size_t k = 6; k + 1 < w.size() && number_in(w[k + 1]); k += 2, ++told) {
      const auto same = std::find_if(parts.begin(), parts.end(), [&](const auto& part) { return part.first == w[k]; });
      if (same != parts.end()) same->second += *number_in(w[k + 1]);
      else parts.emplace_back(w[k], *number_in(w[k + 1]));
    }
    if (!count || parts.empty() || told != *count) return leave_out("its templates and fractions cannot be told");
    by_number_[w[1]] = w[3].ends_with("numberbased");
    distributions_[w[1]] = parts;
  }

  void insertion(const Words& w) {
    if (w[3] != "insert/pack") leave_out("particles that come during the run are put in at its start");
    const std::size_t from = place(w, "distributiontemplate"), where = place(w, "region");
    if (from + 1 >= w.size() || distributions_.count(w[from + 1]) == 0) return leave_out("its distribution is not known");
    std::string keys;
    if (where + 1 < w.size() && regions_.count(w[where + 1]) > 0) keys = regions_[w[where + 1]].keys;
    else leave_out("its region is not known; quern's is the mill, where there is one");
    const auto number = after(w, "particles_in_region") ? after(w, "particles_in_region") : after(w, "nparticles");
    const auto mass = after(w, "mass_in_region") ? after(w, "mass_in_region") : after(w, "mass");
    const auto solids = after(w, "volumefraction_region");
    if (const std::size_t at = place(w, "vel"); at + 4 < w.size() && w[at + 1] == "constant")
      if (const auto v = numbers(w, at + 2, 3)) keys += fmt::format("velocity = {}\n", vector_of({(*v)[0], (*v)[1], (*v)[2]}));
    std::string amount;
    if (solids) amount = fmt::format("filling = {}  # a solid volume fraction of {} at quern's porosity of 0.4\n", *solids / 0.6, *solids);
    else if (mass) amount = "mass";
    else if (number) amount = "count";
    else return leave_out("how much comes is not told by a plain number");
    if (inserts_.insert_or_assign(w[1], Insert{w[from + 1], keys, amount, solids ? *solids : mass ? *mass : *number}).second) insert_order_.push_back(w[1]);
  }

  void mesh(const Words& w) {
    const std::size_t file = place(w, "file");
    if (file + 1 >= w.size()) return leave_out("its file is not told");
    if (std::filesystem::path(w[file + 1]).extension() != ".stl" && std::filesystem::path(w[file + 1]).extension() != ".STL") return leave_out("meshes are STL files");
    for (const char* word : {"move", "rotate", "temperature", "wear", "stress"})
      if (place(w, word, file + 2) < w.size()) leave_out(fmt::format("`{}` of a mesh is not converted", word));
    const std::optional<int> type = type_in(after(w, "type"));
    if (!type) return leave_out("its type is out of range");
    meshes_.push_back(w[file + 1]);
    WallInput wall;
    wall.mesh = w[1];
    wall.type = *type;
    wall.keys = fmt::format("type = \"mesh\"\nfile = {}\n", quoted(std::filesystem::path(w[file + 1]).filename().string()));
    if (const auto scale = after(w, "scale")) wall.keys += fmt::format("scale = {}\n", *scale);
    wall.keys += "open = true  # a closed one may be so too\n";
    types_ = std::max(types_, wall.type);
    put(w[1], wall);
  }

  // A later fix of one name takes the place of the one before.
  void put(const std::string& id, const WallInput& wall) {
    const auto [known, fresh] = wall_places_.emplace(id, walls_.size());
    if (fresh) walls_.emplace_back(name_of(id), wall);
    else walls_[known->second].second = wall;
  }

  void motion(const Words& w) {
    const std::size_t mesh = place(w, "mesh"), turning = place(w, "rotate"), linear = place(w, "linear"), swinging = place(w, "wiggle");
    if (mesh + 1 >= w.size()) return leave_out("its mesh is not told");
    std::string keys;
    if (turning < w.size()) {
      const auto origin = numbers(w, place(w, "origin") + 1, 3), axis = numbers(w, place(w, "axis") + 1, 3);
      const auto period = after(w, "period"), omega = after(w, "omega");
      if (!origin || !axis || (!period && !omega) || (period && *period == 0)) return leave_out("origin, axis and period or omega are not plain numbers");
      keys = fmt::format("motion = \"rotation\"\ncentre = {}\naxis = {}\nspeed = {}\n", vector_of({(*origin)[0], (*origin)[1], (*origin)[2]}), vector_of({(*axis)[0], (*axis)[1], (*axis)[2]}),
                         omega ? *omega : 2 * std::numbers::pi / *period);
    } else if (const auto v = numbers(w, linear + 1, 3); linear < w.size() && v) {
      keys = fmt::format("motion = \"translation\"\nvelocity = {}\n", vector_of({(*v)[0], (*v)[1], (*v)[2]}));
    } else if (swinging < w.size()) {
      const auto amplitude = numbers(w, place(w, "amplitude") + 1, 3);
      const auto period = after(w, "period");
      if (!amplitude || !period || *period <= 0) return leave_out("amplitude and period are not plain numbers");
      keys = fmt::format("motion = \"oscillation\"\namplitude = {}\nfrequency = {}\n", vector_of({(*amplitude)[0], (*amplitude)[1], (*amplitude)[2]}), 1 / *period);
    } else {
      return leave_out("allowed are rotate, linear and wiggle with plain numbers");
    }
    if (moved_.count(w[mesh + 1]) > 0) return leave_out("a second motion of one mesh is not converted");
    moved_[w[mesh + 1]] = keys;
  }

  void wall(const Words& w) {
    if (place(w, "mesh", 4) < w.size() && place(w, "primitive", 4) == w.size()) {
      for (std::size_t k = place(w, "meshes") + 1; k < w.size(); ++k)
        if (std::any_of(walls_.begin(), walls_.end(), [&](const auto& wall) { return wall.second.mesh == w[k]; })) used_.push_back(w[k]);
      return;
    }
    const std::size_t at = place(w, "primitive", 4);
    const auto told = after(w, "type", at);
    const std::optional<int> type = type_in(told);
    if (told && !type) return leave_out("its type is out of range");
    if (at == w.size() || !told || at + 4 > w.size()) return leave_out("allowed are mesh and primitive walls");
    const std::size_t form_at = place(w, "type", at) + 2;
    if (form_at >= w.size() || w[form_at].empty()) return leave_out("its form is not told");
    const std::string& form = w[form_at];
    const std::size_t axis = static_cast<std::size_t>(form[0] - 'x');
    WallInput wall;
    wall.type = *type;
    std::array<double, 3> along{}, point{};
    if (axis > 2) return leave_out("allowed are planes and cylinders along x, y, z");
    along[axis] = 1;
    if (form.ends_with("plane")) {
      const auto n = numbers(w, form_at + 1, 1);
      if (!n) return leave_out("its place is not a plain number");
      point[axis] = (*n)[0];
      wall.keys = fmt::format("type = \"plane\"\npoint = {}\naxis = {}  # into the free side: turn it round where particles are below\n", vector_of(point), vector_of(along));
    } else if (form.ends_with("cylinder")) {
      const auto n = numbers(w, form_at + 1, 3);
      if (!n) return leave_out("its sizes are not plain numbers");
      point[(axis + 1) % 3] = axis == 1 ? (*n)[2] : (*n)[1], point[(axis + 2) % 3] = axis == 1 ? (*n)[1] : (*n)[2];
      wall.keys = fmt::format("type = \"cylinder\"\npoint = {}\naxis = {}\nradius = {}\nlength = {}  # LIGGGHTS has it endless\nside = \"inside\"\n", vector_of(point), vector_of(along), (*n)[0], 20 * (*n)[0]);
    } else {
      return leave_out("allowed are planes and cylinders along x, y, z");
    }
    types_ = std::max(types_, wall.type);
    put(w[1], wall);
  }

  void gravity(const Words& w) {
    const auto told = numbers(w, 4, 1), n = numbers(w, place(w, "vector") + 1, 3);
    if (!told || !n) return leave_out("its size and vector are not plain numbers");
    const double size = told->front();
    const double length = std::hypot((*n)[0], (*n)[1], (*n)[2]);
    if (!(length > 0)) return leave_out("its vector has no length");
    gravity_ = std::array{size * (*n)[0] / length, size * (*n)[1] / length, size * (*n)[2] / length};
  }

  std::optional<double> of_type(const std::string& property, int type) const {
    const auto known = properties_.find(property);
    if (known == properties_.end() || static_cast<std::size_t>(type) > known->second.size()) return std::nullopt;
    return known->second[static_cast<std::size_t>(type - 1)];
  }
  std::optional<double> of_pair(const std::string& property, int a, int b) const {
    const auto known = properties_.find(property);
    if (known == properties_.end()) return std::nullopt;
    const auto types = static_cast<int>(std::lround(std::sqrt(static_cast<double>(known->second.size()))));
    if (a > types || b > types) return std::nullopt;
    return known->second[static_cast<std::size_t>((a - 1) * types + b - 1)];
  }

  std::string written() {
    std::string text = fmt::format("# Converted by `quern convert` from {}. Check it with `quern check`.\nduration = {}\n", std::filesystem::path(file_).filename().string(),
                                   time_step_ && steps_ > 0 ? *time_step_ * steps_ : 1);
    if (gravity_) text += fmt::format("gravity = {}\n", vector_of(*gravity_));
    if (time_step_) text += fmt::format("# LIGGGHTS took steps of {} s; quern chooses its own: [time_step] value\n", *time_step_);
    for (int type = 1; type <= types_; ++type) {
      double density = 7800;
      bool known = false;
      for (const std::string& name : order_)
        if (templates_.at(name).type == type) density = templates_.at(name).density, known = true;
      text += fmt::format("\n[material.type{}]\ndensity = {}{}\n", type, density, known ? "" : "  # not told: of no consequence for walls");
      if (const auto young = of_type("youngsModulus", type)) text += fmt::format("young = {}\n", *young);
      if (const auto poisson = of_type("poissonsRatio", type)) text += fmt::format("poisson = {}\n", *poisson);
    }
    for (int a = 1; a <= types_; ++a)
      for (int b = a; b <= types_; ++b) {
        text += fmt::format("\n[pair.type{}.type{}]\nlaw = \"hertz_mindlin\"\n", a, b);
        if (const auto e = of_pair("coefficientRestitution", a, b)) text += fmt::format("restitution = {}\n", *e);
        if (const auto mu = of_pair("coefficientFriction", a, b)) text += fmt::format("friction = {}\n", *mu);
        if (const auto mu = of_pair("coefficientRollingFriction", a, b); mu && !rolling_.empty()) text += fmt::format("rolling = \"{}\"\nrolling_friction = {}\n", rolling_, *mu);
      }
    for (const std::string& name : order_) {
      const Template& one = templates_.at(name);
      text += fmt::format("\n[species.{}]\nmaterial = \"type{}\"\ndensity = {}\ndiameter = {}\n", name_of(name), one.type, one.density, 2 * one.radius);
    }
    for (const auto& [mesh, keys] : moved_) text += fmt::format("\n[frame.{}]\n{}", name_of(mesh), keys);
    for (const auto& [name, wall] : walls_) {
      if (!wall.mesh.empty() && std::find(used_.begin(), used_.end(), wall.mesh) == used_.end()) {
        left_out_.push_back(fmt::format("{}: the mesh {} is no wall (fix wall/gran does not name it).", file_, wall.mesh));
        continue;
      }
      text += fmt::format("\n[wall.{}]\n{}material = \"type{}\"\n", name, wall.keys, wall.type);
      if (!wall.mesh.empty() && moved_.count(wall.mesh) > 0) text += fmt::format("frame = \"{}\"\n", name_of(wall.mesh));
    }
    for (const std::string& name : insert_order_) text += inserted(name);
    return text;
  }

  // One table for each template of a distribution, with its share.
  std::string inserted(const std::string& name) {
    const Insert& insert = inserts_.at(name);
    const auto& parts = distributions_.at(insert.distribution);
    // By mass, or by number, as the distribution says; both are told in quern's terms.
    double masses = 0, numbers = 0;
    const auto mass_of = [&](const std::string& part) { return templates_.at(part).density * std::pow(templates_.at(part).radius, 3) * 4 / 3 * std::numbers::pi; };
    for (const auto& [part, share] : parts) {
      if (templates_.count(part) == 0) {
        left_out_.push_back(fmt::format("{}: the template {} of the distribution {} is not known.", file_, part, insert.distribution));
        return "";
      }
      const bool by_number = by_number_.at(insert.distribution);
      masses += by_number ? share * mass_of(part) : share, numbers += by_number ? share : share / mass_of(part);
    }
    std::string text;
    for (const auto& [part, share] : parts) {
      const bool by_number = by_number_.at(insert.distribution);
      const double mass_share = (by_number ? share * mass_of(part) : share) / masses, number_share = (by_number ? share : share / mass_of(part)) / numbers;
      if (!(mass_share > 0 && number_share > 0)) continue;
      text += fmt::format("\n[insert.{}]\nspecies = \"{}\"\nmethod = \"rain\"\n", name_of(name + " " + part), name_of(part));
      if (insert.amount == "count") text += fmt::format("count = {}\n", std::max<std::int64_t>(1, std::llround(std::min(insert.value * number_share, 2e9))));
      else if (insert.amount == "mass") text += fmt::format("mass = {}\n", insert.value * mass_share);
      else text += fmt::format("filling = {}\n", insert.value / 0.6 * mass_share);
      text += insert.keys;
    }
    return text;
  }

  struct Insert {
    std::string distribution, keys, amount;
    double value = 0;
  };

  std::string file_, spoken_, rolling_;
  int line_ = 0, types_ = 0;
  double steps_ = 0;
  std::optional<double> time_step_;
  std::optional<std::array<double, 3>> gravity_;
  std::map<std::string, std::string> variables_, moved_, names_;
  std::set<std::string> taken_;
  std::map<std::string, std::vector<double>> properties_;
  std::map<std::string, Template> templates_;
  std::map<std::string, std::vector<std::pair<std::string, double>>> distributions_;
  std::map<std::string, bool> by_number_;
  std::map<std::string, Region> regions_;
  std::map<std::string, Insert> inserts_;
  std::vector<std::pair<std::string, WallInput>> walls_;
  std::map<std::string, std::size_t> wall_places_;
  Words order_, insert_order_, meshes_, used_, left_out_;
};

}  // namespace

Converted convert_liggghts(const std::string& file) { return Script(file).convert(); }

}  // namespace quern
