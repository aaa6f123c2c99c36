#include "src/diagnose/machine/machine_written.hpp"
#include <fmt/format.h>
#include <cmath>
#include "src/base/whole_file.hpp"
#include "src/case/echo.hpp"
#include "src/diagnose/finding_written.hpp"

namespace quern {
namespace {

void write_amended_machine(const std::string& file, const MachineExperiment& experiment, const MachineDiagnosis& d) {
  Values values = experiment.base();
  Alteration altered;
  std::string beside;
  for (std::size_t k = 0; k < d.best.moved.size(); ++k) {
    const MachineParameter& p = d.best.moved[k];
    const double value = d.best.value(k);
    altered.settings.insert(altered.settings.end(), p.settings.begin(), p.settings.end());
    for (const Parameter& one : p.moves) altered.changes.push_back({&one, value});
    if (p.moves.empty()) beside += fmt::format("# The instrument, which no case has: {} = {:.6g} {}.\n", p.key, value, p.unit == "1" ? "" : p.unit);
  }
  alter(values, altered);
  const std::string words = d.effects.empty() ? "calibrated numbers" : fmt::format("{}", fmt::join(d.effects, " and "));
  write_echo(file, fmt::format("# {} with {}.\n{}", experiment.base().file, words, beside), values);
}

std::string residuals_csv(const MachineExperiment& experiment, const MachineDiagnosis& d) {
  std::string text = "condition,channel,energy [J],unit,recorded,noise,before,before_sd,after,after_sd,sealed\n";
  for (const MachineResidual& r : d.residuals) {
    const RecordedChannel& channel = experiment.channels()[r.channel];
    const RecordedChannel::Site& site = channel.sites[r.site];
    const auto shown = [&](double y) { return channel.plain(y); };
    const double size = 1 / channel.stretch(channel.plain(r.recorded));
    text += fmt::format("\"{}\",{},{},{},{:.9g},{:.4g},{:.9g},{:.4g},{:.9g},{:.4g},{}\n", experiment.recording().rows[site.row].label, channel.label(), site.energy > 0 ? fmt::format("{:.6g}", site.energy) : "",
                        machine_channel(channel.name).unit, shown(r.recorded), r.noise * size, shown(r.before), r.before_deviation * size, shown(r.after), r.after_deviation * size, r.sealed ? 1 : 0);
  }
  return text;
}

}  // namespace

void write_machine_diagnosis(const MachineExperiment& experiment, const MachineDiagnosis& d, const std::string& directory) {
  nlohmann::ordered_json json = json_of(d, d.ranking);
  json["simulations"] = d.runs;
  write_whole_file(directory + "/diagnosis.json", json.dump(2) + "\n");
  write_amended_machine(directory + "/amended.toml", experiment, d);
  write_whole_file(directory + "/residuals.csv", residuals_csv(experiment, d));
  write_fits(d, directory);
}

}  // namespace quern
