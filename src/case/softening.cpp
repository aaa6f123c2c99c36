#include "src/case/softening.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/csv.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool listed(const std::string& key, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* one) { return key == one; });
}

// Not of the run itself, nor the power once more as a check on itself.
bool is_outcome(const std::string& key) {
  return !listed(key, {"time_step", "simulated_time", "particle_count", "energy_closure", "particle_steps_per_second", "wall_clock", "steady_from", "power_agreement", "power_ledger", "power_walls"});
}

bool moves_by_nature(const std::string& key) {
  return listed(key, {"overlap_peak", "contact_force_peak", "contact_duration", "enduring_contacts", "lasting_contacts"});
}

// What has a meaning when few bodies meet a few times.
bool tells_of_few(const std::string& key) {
  return listed(key, {"collision_rate", "mean_collision_energy", "overlap_peak", "contact_force_peak", "contact_duration"});
}

bool is_angle(const SoftRow& row) { return row.unit == "deg"; }

Json summary_of(const std::string& directory) {
  const std::string file = (fs::path(directory) / "summary.json").string();
  std::ifstream stream(file);
  Json summary = Json::parse(stream, nullptr, false);
  if (!summary.is_object()) throw InputError(fmt::format("{}: no results can be read here; delete the directory and run again.", file));
  return summary;
}

std::optional<double> number_in(const Json& summary, const std::string& key) {
  if (!summary.contains(key) || !summary[key].contains("value") || !summary[key]["value"].is_number()) return std::nullopt;
  return summary[key]["value"].get<double>();
}

Estimate estimate_in(const Json& entry, bool exact) {
  Estimate e{entry["value"], std::nullopt};
  if (!exact && entry.contains("ci95") && entry["ci95"].is_array() && entry["ci95"].size() == 2 && entry["ci95"][0].is_number() && entry["ci95"][1].is_number())
    e.ci95 = {{entry["ci95"][0], entry["ci95"][1]}};
  return e;
}

// A component is held against the whole: its own value may be near zero.
double scale_of(const SoftRow& row, const Json& summary) {
  if (is_angle(row)) return 180 / std::numbers::pi;
  if (listed(row.key, {"shell_force_horizontal", "shell_force_vertical"}))
    if (const auto whole = number_in(summary, "shell_force")) return std::abs(*whole);
  return std::abs(row.as_is.value);
}

struct LastSeen {
  double speed = 0, spin = 0, displacement = 0;
};

// How each tracked particle left, by its id.
std::map<int, LastSeen> last_seen(const std::string& directory) {
  const std::string file = (fs::path(directory) / "track.csv").string();
  if (!fs::exists(file)) return {};
  const NumberTable table = read_numbers(file);
  const auto at = [&](const char* name) -> const std::vector<double>& { return *table.find(name); };
  std::map<int, std::size_t> first;
  std::map<int, LastSeen> last;
  for (std::size_t k = 0; k < at("t").size(); ++k) {
    const int id = static_cast<int>(at("particle")[k]);
    const std::size_t start = first.emplace(id, k).first->second;
    const auto moved = [&](const char* name) { return at(name)[k] - at(name)[start]; };
    last[id] = {std::hypot(at("vx")[k], at("vy")[k], at("vz")[k]), std::hypot(at("wx")[k], at("wy")[k], at("wz")[k]), std::hypot(moved("x"), moved("y"), moved("z"))};
  }
  return last;
}

void add_departures(SoftReport& report, const std::string& as_is, const std::string& softer) {
  const std::map<int, LastSeen> before = last_seen(as_is), after = last_seen(softer);
  double fastest = 0;
  for (const auto& [id, seen] : before) fastest = std::max(fastest, seen.speed);
  for (const auto& [particle, seen] : before) {
    const auto id = particle;  // lambdas take no bindings in clang 14
    if (after.count(id) == 0) continue;
    const LastSeen& other = after.at(id);
    const auto add = [&](const char* name, const char* unit, double a, double b, double nothing, const char* description) {
      if (std::max(std::abs(a), std::abs(b)) <= nothing) return;
      SoftRow row{fmt::format("{}_{}", name, id), unit, fmt::format("{} of particle {}", description, id), {a, {}}, {b, {}}, {}};
      row.scale = std::abs(a);
      report.rows.push_back(row);
    };
    constexpr double rounding = 1e-9;
    add("speed_at_end", "m/s", seen.speed, other.speed, rounding * fastest, "speed at the end");
    add("spin_at_end", "rad/s", seen.spin, other.spin, rounding * fastest / 1.0, "angular speed at the end");
  }
}

void judge(SoftReport& report) {
  const auto judged = [](const SoftRow& row) { return row.difference.ci95 && !moves_by_nature(row.key); };
  const int together = static_cast<int>(std::count_if(report.rows.begin(), report.rows.end(), judged));
  for (SoftRow& row : report.rows) {
    if (moves_by_nature(row.key)) {
      row.verdict = SoftVerdict::by_nature;
      continue;
    }
    if (!row.difference.ci95 && !report.exact) {
      row.verdict = SoftVerdict::no_interval;
      continue;
    }
    const double tolerance = row.tolerance * row.scale;
    switch (judge(row.difference, tolerance, together)) {
      case Verdict::moves: row.verdict = SoftVerdict::moves; break;
      case Verdict::moves_little: row.verdict = SoftVerdict::moves_little; break;
      case Verdict::same: row.verdict = SoftVerdict::same; break;
      case Verdict::unknown:
        row.verdict = SoftVerdict::unknown;
        row.longer = longer_by(row.difference, tolerance);
        break;
    }
  }
}

void warn(SoftReport& report, const Json& as_is, const Json& softer) {
  const auto deep = [](const SoftRun& run) { return run.overlap.value_or(0) > greatest_sound_overlap; };
  if (deep(report.softer))
    report.warnings.push_back(fmt::format("The greatest overlap of the softer contacts is {:.2g} % of the radius{}. Above {:.2g} % a ball's neighbours feel each other through it, "
                                          "whatever the averages say.",
                                          100 * *report.softer.overlap, deep(report.as_is) ? fmt::format(", and {:.2g} % already as the case is", 100 * *report.as_is.overlap) : "",
                                          100 * greatest_sound_overlap));
  constexpr double sound_closure = 1e-3;
  for (const auto& [run, name] : {std::pair(&report.as_is, "as it is"), std::pair(&report.softer, "softer")})
    if (std::abs(run->closure) > sound_closure)
      report.warnings.push_back(fmt::format("The energy ledger of the run {} misses {:.2g} %; a shorter time step closes it.", name, 100 * run->closure));
  if (!report.exact) return;
  const double lasting = number_in(as_is, "lasting_contacts").value_or(0) + number_in(softer, "lasting_contacts").value_or(0);
  const bool met = number_in(as_is, "collision_rate").value_or(0) > 0 && number_in(softer, "collision_rate").value_or(0) > 0;
  if (lasting == 0 && met) return;
  for (SoftRow& row : report.rows)
    if (row.verdict != SoftVerdict::by_nature) row.verdict = SoftVerdict::unknown;
  const double root = std::sqrt(report.factor), time = number_in(as_is, "simulated_time").value_or(0);
  report.warnings.push_back(fmt::format("The bodies still touch when a run ends, so nothing can be told of how they part: a contact lasts up to {:.3g} times as long when it is softer. "
                                        "Try --set duration={:.2g}.",
                                        root, time * std::ceil(root)));
}

std::string number(double value) { return fmt::format("{:.4g}", value); }

// Two digits, and no powers of ten for hundreds.
std::string short_number(double value, bool with_sign = false) {
  const bool large = std::abs(value) >= 99.5 && std::abs(value) < 1e5;
  if (large) return with_sign ? fmt::format("{:+.0f}", value) : fmt::format("{:.0f}", value);
  return with_sign ? fmt::format("{:+.2g}", value) : fmt::format("{:.2g}", value);
}

double half_width(const Estimate& e) { return e.ci95 ? 0.5 * ((*e.ci95)[1] - (*e.ci95)[0]) : 0; }

std::string with_half(const Estimate& e) { return number(e.value) + (e.ci95 ? " ± " + short_number(half_width(e)) : ""); }

double in_shown_unit(const SoftRow& row, double difference) { return is_angle(row) ? difference : 100 * difference / row.scale; }

const char* shown_unit(const SoftRow& row) { return is_angle(row) ? "°" : " %"; }

std::string change_of(const SoftRow& row) {
  if (!(row.scale > 0)) return "–";  // of nothing
  const double half = in_shown_unit(row, half_width(row.difference));
  return short_number(in_shown_unit(row, row.difference.value), true) + (row.difference.ci95 ? " ± " + short_number(half) : "") + shown_unit(row);
}

// The most that a row may differ, in its shown unit.
double bound_of(const SoftRow& row) {
  const auto [low, high] = row.difference.ci95.value_or(std::array<double, 2>{row.difference.value, row.difference.value});
  return in_shown_unit(row, std::max(std::abs(low), std::abs(high)));
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t k = 0; k < words.size(); ++k) text += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return text;
}

std::vector<const SoftRow*> rows_with(const SoftReport& report, SoftVerdict verdict) {
  std::vector<const SoftRow*> rows;
  for (const SoftRow& row : report.rows)
    if (row.verdict == verdict) rows.push_back(&row);
  return rows;
}

std::string names_of(const std::vector<const SoftRow*>& rows) {
  std::vector<std::string> names;
  for (const SoftRow* row : rows) names.push_back(row->key);
  return join(names);
}

// "power and torque (by less than 1.3 %)", angles apart.
std::string names_within(const std::vector<const SoftRow*>& rows) {
  std::vector<std::string> parts;
  for (const bool angles : {false, true}) {
    std::vector<const SoftRow*> some;
    double most = 0;
    for (const SoftRow* row : rows)
      if (is_angle(*row) == angles) some.push_back(row), most = std::max(most, bound_of(*row));
    if (!some.empty()) parts.push_back(fmt::format("{} (by {} {}{})", names_of(some), some[0]->difference.ci95 ? "less than" : "at most", short_number(std::max(most, 0.01)), shown_unit(*some[0])));
  }
  return join(parts);
}

std::string names_with_changes(const std::vector<const SoftRow*>& rows) {
  std::vector<std::string> parts;
  for (const SoftRow* row : rows) parts.push_back(fmt::format("{} ({})", row->key, change_of(*row)));
  return join(parts);
}

Json json_of(const Estimate& e) {
  Json json = {{"value", e.value}};
  if (e.ci95) json["ci95"] = {(*e.ci95)[0], (*e.ci95)[1]};
  return json;
}

// Calls visit(key, value, power) for each number that falls as a power of the softening.
template <class Visit>
void each_stiffness(Case& c, Visit&& visit) {
  for (Material& m : c.materials)
    if (m.young > 0) visit("material." + m.name + ".young", m.young, 1.0);
  for (PairCase& pair : c.pairs) {
    const std::string table = pair.a == "default" ? "pair.default." : fmt::format("pair.{}.{}.", pair.a, pair.b);
    const auto each = [&](const char* key, std::optional<double>& value, double power) {
      if (value) visit(table + key, *value, power);
    };
    each("normal_stiffness", pair.normal_stiffness, 1);
    each("penetration_factor", pair.penetration_factor, 0.5);
    each("tangential_stiffness", pair.tangential_stiffness, 1);
    each("normal_damping", pair.normal_damping, 0.5);
    each("stiffness_coefficient", pair.stiffness_coefficient, 1);
    each("damping_coefficient", pair.damping_coefficient, (1 + pair.damping_exponent) / (1 + pair.stiffness_exponent));
  }
}

Json json_of(const SoftRun& run) {
  Json json = {{"time_step", run.time_step}, {"time_step_limit", run.limit}, {"steps", run.steps}, {"wall_clock", run.wall_clock}, {"energy_closure", run.closure}};
  if (run.overlap) json["overlap_peak"] = *run.overlap;
  return json;
}

}  // namespace

void soften(Case& c, double factor) {
  each_stiffness(c, [&](const std::string&, double& value, double power) { value *= std::pow(factor, -power); });
}

std::vector<std::string> softened(const Case& c, double factor) {
  std::vector<std::string> overrides;
  Case softer = c;
  soften(softer, factor);
  each_stiffness(softer, [&](const std::string& key, double& value, double) { overrides.push_back(fmt::format("{}={}", key, value)); });
  return overrides;
}

std::string words_of(SoftVerdict verdict) {
  switch (verdict) {
    case SoftVerdict::moves: return "moves";
    case SoftVerdict::moves_little: return "moves a little";
    case SoftVerdict::same: return "does not move";
    case SoftVerdict::unknown: return "cannot tell";
    case SoftVerdict::by_nature: return "moves by nature";
    case SoftVerdict::no_interval: return "no interval";
  }
  return "";
}

void compare(SoftReport& report, const std::string& as_is, const std::string& softer) {
  const Json before = summary_of(as_is), after = summary_of(softer);
  for (const auto& [run, summary] : {std::pair(&report.as_is, &before), std::pair(&report.softer, &after)}) {
    run->wall_clock = number_in(*summary, "wall_clock").value_or(0);
    run->closure = number_in(*summary, "energy_closure").value_or(0);
    run->overlap = number_in(*summary, "overlap_peak");
  }
  for (const auto& [key, entry] : before.items()) {
    if (!is_outcome(key) || (report.exact && !tells_of_few(key)) || !number_in(before, key) || !number_in(after, key)) continue;
    SoftRow row{key, entry.value("unit", "1"), entry.value("description", ""), estimate_in(entry, report.exact), estimate_in(after[key], report.exact), {}};
    // What is known before a run, such as the critical speed.
    if (!report.exact && !row.as_is.ci95 && row.as_is.value == row.softer.value) continue;
    row.scale = scale_of(row, before);
    report.rows.push_back(row);
  }
  if (report.exact) add_departures(report, as_is, softer);
  for (SoftRow& row : report.rows) {
    row.tolerance = report.exact ? exact_tolerance : soft_tolerance;
    row.difference = difference(row.as_is, row.softer);
  }
  judge(report);
  warn(report, before, after);
}

std::string softening_sentence(const SoftReport& report) {
  const double longer = report.softer.time_step / report.as_is.time_step;
  std::string text = fmt::format("With contacts {:.6g} times as soft the time step may be {:.3g} times as long.", report.factor, longer);
  const auto add = [&](SoftVerdict verdict, const std::string& before, const std::string& names, const std::string& behind) {
    if (!rows_with(report, verdict).empty()) text += " " + before + names + behind + ".";
  };
  add(SoftVerdict::same, "It does not move ", names_within(rows_with(report, SoftVerdict::same)), "");
  add(SoftVerdict::moves_little, "It moves a little ", names_with_changes(rows_with(report, SoftVerdict::moves_little)), "");
  add(SoftVerdict::moves, "It moves ", names_with_changes(rows_with(report, SoftVerdict::moves)), "");
  double most = 1;
  for (const SoftRow* row : rows_with(report, SoftVerdict::unknown)) most = std::max(most, row->longer);
  add(SoftVerdict::unknown, "Not told by these runs: ", names_of(rows_with(report, SoftVerdict::unknown)), most > 1 ? fmt::format("; runs {:.2g} times as long would tell", most) : "");
  if (report.as_is.overlap && report.softer.overlap)
    text += fmt::format(" The greatest overlap grows from {:.2g} % to {:.2g} % of the radius.", 100 * *report.as_is.overlap, 100 * *report.softer.overlap);
  return text;
}

std::string softening_table(const SoftReport& report) {
  std::string text = fmt::format("{:28} {:8} {:>20} {:>20} {:>18}\n", "output", "unit", "as it is", fmt::format("softer by {:.6g}", report.factor), "change");
  const auto padded = [](const std::string& words, std::size_t width) {  // by letters, not bytes
    const auto letters = static_cast<std::size_t>(std::count_if(words.begin(), words.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
    return std::string(letters < width ? width - letters : 0, ' ') + words;
  };
  using enum SoftVerdict;
  for (const SoftVerdict verdict : {moves, moves_little, unknown, same, no_interval, by_nature}) {
    const std::vector<const SoftRow*> rows = rows_with(report, verdict);
    if (rows.empty()) continue;
    text += words_of(verdict) + "\n";
    for (const SoftRow* row : rows)
      text += fmt::format("  {:26} {:8} {} {} {}{}\n", row->key, row->unit == "1" ? "" : row->unit, padded(with_half(row->as_is), 20), padded(with_half(row->softer), 20), padded(change_of(*row), 18),
                          verdict == unknown && row->longer > 1 ? fmt::format("   needs {:.2g} times the time", row->longer) : "");
  }
  return text;
}

std::string softening_csv(const SoftReport& report) {
  std::string text = "output,unit,as_is,as_is_from,as_is_to,softer,softer_from,softer_to,difference,difference_from,difference_to,tolerance,verdict,longer_by\n";
  const auto cells = [](const Estimate& e) { return e.ci95 ? fmt::format("{},{},{}", e.value, (*e.ci95)[0], (*e.ci95)[1]) : fmt::format("{},,", e.value); };
  for (const SoftRow& row : report.rows)
    text += fmt::format("{},{},{},{},{},{},{},{}\n", row.key, row.unit, cells(row.as_is), cells(row.softer), cells(row.difference), row.tolerance * row.scale, words_of(row.verdict),
                        row.verdict == SoftVerdict::unknown && row.longer > 1 ? fmt::format("{}", row.longer) : "");
  return text;
}

std::string softening_json(const SoftReport& report) {
  Json rows = Json::object();
  for (const SoftRow& row : report.rows) {
    rows[row.key] = {{"unit", row.unit}, {"description", row.description}, {"as_is", json_of(row.as_is)}, {"softer", json_of(row.softer)}, {"difference", json_of(row.difference)},
                     {"tolerance", row.tolerance * row.scale}, {"verdict", words_of(row.verdict)}};
    if (row.verdict == SoftVerdict::unknown && row.longer > 1) rows[row.key]["longer_by"] = row.longer;
  }
  const Json json = {{"factor", report.factor},
                     {"as_is", json_of(report.as_is)},
                     {"softer", json_of(report.softer)},
                     {"speed_up", {{"steps", report.as_is.steps / report.softer.steps}, {"wall_clock", report.softer.wall_clock > 0 ? Json(report.as_is.wall_clock / report.softer.wall_clock) : Json()}}},
                     {"outputs", rows},
                     {"warnings", report.warnings},
                     {"conclusion", softening_sentence(report)}};
  return json.dump(2) + "\n";
}

}  // namespace quern
