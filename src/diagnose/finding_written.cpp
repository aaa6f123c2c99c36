#include "src/diagnose/finding_written.hpp"
#include <fmt/format.h>
#include <cmath>
#include "src/base/whole_file.hpp"

namespace quern {

using nlohmann::ordered_json;

ordered_json json_number(double x) { return std::isfinite(x) ? ordered_json(x) : ordered_json(nullptr); }

ordered_json json_of(const Finding& d, const std::vector<Ranked>& ranking) {
  ordered_json j;
  j["verdict"] = name_of(d.verdict);
  j["effect"] = d.effects.size() == 1 ? ordered_json(d.effects.front()) : ordered_json(nullptr);
  if (d.effects.size() > 1) j["effects"] = d.effects;
  if (!d.form.empty()) j["form"] = d.form;
  j["indistinguishable"] = d.indistinguishable;
  j["confidence"] = json_number(d.confidence);
  if (!d.where.channel.empty()) {
    const Location& w = d.where;
    j["where"] = {{"channel", w.channel}, {"variable", w.variable}, {"from", json_number(w.from)}, {"to", json_number(w.to)}, {"unit", w.unit}, {"phase", w.phase},
                  {"run", w.run.empty() ? ordered_json(nullptr) : ordered_json(w.run)}, {"sign", w.sign}, {"p_value", json_number(w.p_value)}};
  }
  j["signature"] = d.signature;
  j["parameters"] = ordered_json::object();
  for (const Estimate& e : d.parameters) {
    ordered_json one = {{"value", json_number(e.value)}, {"unit", e.unit}, {"ci95", {json_number(e.interval()[0]), json_number(e.interval()[1])}}, {"of_effect", e.of_effect}};
    if (e.nominal) one["case"] = json_number(*e.nominal);
    // The bare name, as long as it is the only one.
    const std::string bare = e.key.substr(e.key.rfind('.') + 1);
    j["parameters"][e.of_effect && !j["parameters"].contains(bare) ? bare : e.key] = one;
    if (e.of_effect) j["parameters"][bare]["key"] = e.key;
  }
  j["fit"]["train"] = {{"before", json_number(d.train.before)}, {"after", json_number(d.train.after)}};
  j["fit"]["held_out"] = d.sealed ? ordered_json{{"before", json_number(d.sealed->before)}, {"after", json_number(d.sealed->after)}, {"excess_removed", json_number(d.excess_removed)}} : ordered_json(nullptr);
  j["fit"]["noise_floor"] = 1.0;
  j["fit"]["numerical_error"] = json_number(d.numerical_error);
  j["ranking"] = ordered_json::array();
  for (const Ranked& t : ranking)
    j["ranking"].push_back({{"effect", fmt::format("{}", fmt::join(t.effects, " + "))}, {"form", t.form}, {"held_out", json_number(t.held_out)}, {"held_out_gain", json_number(t.held_out_gain)}, {"bic", json_number(t.bic)},
                            {"probability", json_number(t.probability)}, {"rival", t.rival}});
  j["adequacy"] = {{"before", json_number(d.adequacy_p)}, {"after", json_number(d.remaining_p)}};
  j["least_detectable"] = ordered_json::object();
  for (const Detectable& one : d.detectable) j["least_detectable"][one.effect] = {{"key", one.key}, {"change", json_number(one.strength)}, {"unit", one.unit}};
  j["runs"] = {{"fit", d.fit_runs}, {"select", d.select_runs}, {"sealed", d.sealed_runs}};
  j["remarks"] = d.remarks;
  j["experiment"] = d.advice;
  j["amended_case"] = "amended.toml";
  return j;
}

void write_fits(const Finding& d, const std::string& directory) {
  std::string ledger = "fit,ln_likelihood,iterations\n";
  for (const auto& [what, likelihood, iterations] : d.ledger) ledger += fmt::format("\"{}\",{},{}\n", what, likelihood, iterations);
  write_whole_file(directory + "/fits.csv", ledger);
}

std::vector<std::string> diagnosis_words(const Finding& d) {
  std::vector<std::string> lines;
  std::string verdict = fmt::format("Verdict: {}", name_of(d.verdict));
  if (!d.effects.empty()) verdict += fmt::format(": {}", fmt::join(d.effects, " and "));
  if (d.verdict == Verdict::omitted_physics && !d.form.empty()) verdict += fmt::format(" ({})", d.form);
  lines.push_back(verdict + fmt::format(", confidence {:.2f}", d.confidence));
  if (!d.indistinguishable.empty()) lines.push_back(fmt::format("These recordings cannot tell it from: {}", fmt::join(d.indistinguishable, ", ")));
  if (!d.where.channel.empty())
    lines.push_back(fmt::format("Where: {}, {} from {:.4g} to {:.4g} {}{}{}; chance that noise does as much: {:.2g}", d.where.channel, d.where.variable, d.where.from, d.where.to, d.where.unit,
                                d.where.phase.empty() ? "" : ", " + d.where.phase, d.where.run.empty() ? "" : ", run " + d.where.run, d.where.p_value));
  for (const Estimate& e : d.parameters)
    lines.push_back(fmt::format("{} = {:.5g}{} ({:.5g} … {:.5g}){}", e.key, e.value, e.unit.empty() || e.unit == "1" ? "" : " " + e.unit, e.interval()[0], e.interval()[1],
                                e.nominal ? fmt::format(", in the case {:.5g}", *e.nominal) : ""));
  lines.push_back(fmt::format("Misfit over noise: {:.3g} → {:.3g}", d.train.before, d.train.after) +
                  (d.sealed ? fmt::format("; on sealed runs {:.3g} → {:.3g}", d.sealed->before, d.sealed->after) : "; no runs were left to seal"));
  for (const std::string& remark : d.remarks) lines.push_back(remark);
  if (!d.advice.empty()) lines.push_back(d.advice);
  return lines;
}

}  // namespace quern
