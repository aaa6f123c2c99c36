#include "src/diagnose/written.hpp"
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include "src/base/whole_file.hpp"
#include "src/diagnose/amended.hpp"

namespace quern {
namespace {

using nlohmann::ordered_json;

ordered_json number(double x) { return std::isfinite(x) ? ordered_json(x) : ordered_json(nullptr); }

ordered_json json_of(const Diagnosis& d) {
  ordered_json j;
  j["verdict"] = name_of(d.verdict);
  j["effect"] = d.effects.size() == 1 ? ordered_json(d.effects.front()) : ordered_json(nullptr);
  if (d.effects.size() > 1) j["effects"] = d.effects;
  if (!d.form.empty()) j["form"] = d.form;
  j["indistinguishable"] = d.indistinguishable;
  j["confidence"] = number(d.confidence);
  if (!d.where.channel.empty()) {
    const Location& w = d.where;
    j["where"] = {{"channel", w.channel}, {"variable", w.variable}, {"from", number(w.from)}, {"to", number(w.to)}, {"unit", w.unit}, {"phase", w.phase},
                  {"run", w.run.empty() ? ordered_json(nullptr) : ordered_json(w.run)}, {"sign", w.sign}, {"p_value", number(w.p_value)}};
  }
  j["signature"] = d.signature;
  j["parameters"] = ordered_json::object();
  for (const Estimate& e : d.parameters) {
    ordered_json one = {{"value", number(e.value)}, {"unit", e.unit}, {"ci95", {number(e.interval()[0]), number(e.interval()[1])}}, {"of_effect", e.of_effect}};
    if (e.nominal) one["case"] = number(*e.nominal);
    // The bare name, as long as it is the only one.
    const std::string bare = e.key.substr(e.key.rfind('.') + 1);
    j["parameters"][e.of_effect && !j["parameters"].contains(bare) ? bare : e.key] = one;
    if (e.of_effect) j["parameters"][bare]["key"] = e.key;
  }
  j["fit"]["train"] = {{"before", number(d.train.before)}, {"after", number(d.train.after)}};
  j["fit"]["held_out"] = d.sealed ? ordered_json{{"before", number(d.sealed->before)}, {"after", number(d.sealed->after)}, {"excess_removed", number(d.excess_removed)}} : ordered_json(nullptr);
  j["fit"]["noise_floor"] = 1.0;
  j["fit"]["numerical_error"] = number(d.numerical_error);
  j["ranking"] = ordered_json::array();
  for (const Tried& t : d.ranking)
    j["ranking"].push_back({{"effect", fmt::format("{}", fmt::join(t.effects, " + "))}, {"form", t.candidate.form}, {"held_out", number(t.held_out)}, {"held_out_gain", number(t.held_out_gain)}, {"bic", number(t.bic)},
                            {"probability", number(t.probability)}, {"rival", t.candidate.rival}});
  j["adequacy"] = {{"before", number(d.adequacy_p)}, {"after", number(d.remaining_p)}};
  j["least_detectable"] = ordered_json::object();
  for (const Detectable& one : d.detectable) j["least_detectable"][one.effect] = {{"key", one.key}, {"change", number(one.strength)}, {"unit", one.unit}};
  j["noise"] = ordered_json::object();
  for (std::size_t c = 0; c < channel_count; ++c) {
    const ChannelNoise& n = d.best.noise[c];
    if (n.deviation == 1 && n.tail == 1e9) continue;
    j["noise"][name_of(static_cast<Channel>(c))] = {{"deviation", number(n.deviation)}, {"correlation", number(n.correlation)}, {"white", number(n.white)}, {"tail", number(n.tail)}, {"jitter", number(n.jitter * n.deviation)}};
  }
  j["runs"] = {{"fit", d.fit_runs}, {"select", d.select_runs}, {"sealed", d.sealed_runs}};
  j["remarks"] = d.remarks;
  j["experiment"] = d.advice;
  j["amended_case"] = "amended.toml";
  return j;
}

// Every sample beside both predictions.
std::string residuals_csv(const Experiment& experiment, const Diagnosis& d) {
  std::string text = "run,channel,t [s],recorded,before,after,noise,sealed\n";
  const auto add = [&](const Fit& before, const Fit& after, bool sealed) {
    for (std::size_t place = 0; place < before.runs.size() && place < after.runs.size(); ++place) {
      const RecordedRun& run = experiment.recording().runs[before.runs[place]];
      Eigen::Index row = 0;
      for (const Series& series : run.series) {
        for (std::size_t k = 0; k < series.value.size(); ++k, ++row) {
          const double own = series.deviation.empty() ? 1 : series.deviation[k];
          text += fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.4g},{}\n", run.label, name_of(series.channel), series.t[k], series.value[k], series.value[k] - before.linear[place].rest[row],
                              series.value[k] - after.linear[place].rest[row], own * d.best.noise[static_cast<std::size_t>(series.channel)].deviation, sealed ? 1 : 0);
        }
      }
    }
  };
  add(d.baseline, d.best, false);
  add(d.sealed_baseline, d.sealed_best, true);
  return text;
}

}  // namespace

void write_diagnosis(const Experiment& experiment, const Diagnosis& d, const std::string& directory) {
  write_whole_file(directory + "/diagnosis.json", json_of(d).dump(2) + "\n");
  write_whole_file(directory + "/amended.toml", amended_case(experiment, d));
  write_whole_file(directory + "/residuals.csv", residuals_csv(experiment, d));
  std::string ledger = "fit,ln_likelihood,iterations\n";
  for (const auto& [what, likelihood, iterations] : d.ledger) ledger += fmt::format("\"{}\",{},{}\n", what, likelihood, iterations);
  write_whole_file(directory + "/fits.csv", ledger);
}

std::vector<std::string> diagnosis_words(const Diagnosis& d) {
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
