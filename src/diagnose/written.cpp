#include "src/diagnose/written.hpp"
#include <fmt/format.h>
#include "src/base/whole_file.hpp"
#include "src/diagnose/amended.hpp"
#include "src/diagnose/finding_written.hpp"

namespace quern {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const Diagnosis& d) {
  std::vector<Ranked> ranking;
  for (const Tried& t : d.ranking) ranking.push_back({t.effects, t.candidate.form, t.held_out, t.held_out_gain, t.bic, t.probability, t.candidate.rival});
  ordered_json j = json_of(d, ranking);
  j["noise"] = ordered_json::object();
  for (std::size_t c = 0; c < channel_count; ++c) {
    const ChannelNoise& n = d.best.noise[c];
    if (n.deviation == 1 && n.tail == 1e9) continue;
    j["noise"][name_of(static_cast<Channel>(c))] = {{"deviation", json_number(n.deviation)}, {"correlation", json_number(n.correlation)}, {"white", json_number(n.white)}, {"tail", json_number(n.tail)}, {"jitter", json_number(n.jitter * n.deviation)}};
  }
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
  write_amended_case(directory + "/amended.toml", experiment, d);
  write_whole_file(directory + "/residuals.csv", residuals_csv(experiment, d));
  write_fits(d, directory);
}

}  // namespace quern
