#include "src/diagnose/location.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::VectorXd;

constexpr double held = 0.9;      // of the change, by the interval
constexpr double of_one = 0.75;   // of the change, by a phase or a run that is named

struct Sample {
  double t, change, toward;  // change²: of the prediction in standard deviations; toward: residual along it
};

// The shortest interval that holds a share of the weights.
std::pair<double, double> shortest(std::vector<Sample> samples, double share) {
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.t < b.t; });
  double total = 0;
  for (const Sample& s : samples) total += s.change;
  std::pair<double, double> best = {samples.front().t, samples.back().t};
  double sum = 0;
  std::size_t from = 0;
  for (std::size_t to = 0; to < samples.size(); ++to) {
    sum += samples[to].change;
    while (sum - samples[from].change >= share * total) sum -= samples[from++].change;
    if (sum >= share * total && samples[to].t - samples[from].t < best.second - best.first) best = {samples[from].t, samples[to].t};
  }
  return best;
}

}  // namespace

Location locate(const Comparison& comparison, const Fit& baseline, const Fit& better) {
  const Recording& recording = comparison.experiment().recording();
  std::map<Channel, std::vector<Sample>> by_channel;
  std::map<Channel, double> total, signed_total;
  std::map<std::string, double> by_run, by_phase;
  double all = 0;
  const Alteration altered = comparison.alteration_of(baseline);
  for (std::size_t place = 0; place < baseline.runs.size(); ++place) {
    const std::size_t run = baseline.runs[place];
    const RecordedRun& recorded = recording.runs[run];
    const std::vector<Experiment::Point> path = comparison.experiment().path(run, altered, baseline.unknowns[run]);
    Row row = 0;
    for (const Series& series : recorded.series) {
      const ChannelNoise& noise = better.noise[static_cast<std::size_t>(series.channel)];
      std::size_t at = 0;
      for (std::size_t k = 0; k < series.value.size(); ++k, ++row) {
        const double sd = noise.deviation * (series.deviation.empty() ? 1 : series.deviation[k]);
        const double difference = (baseline.linear[place].rest[row] - better.linear[place].rest[row]) / sd;
        const double weight = difference * difference;
        by_channel[series.channel].push_back({series.t[k], weight, baseline.linear[place].rest[row] / sd});
        total[series.channel] += weight;
        signed_total[series.channel] += difference * std::abs(difference);
        by_run[recorded.label] += weight;
        all += weight;
        const double now = series.channel == Channel::impact ? series.value[k] : series.t[k];
        while (at + 1 < path.size() && path[at + 1].time <= now) ++at;
        if (!path.empty()) {
          const Experiment::Point& p = path[at];
          const bool touching = p.overlap > 0;
          by_phase[!touching ? (comparison.experiment().has_wall() && p.impacts > 0 ? "after contact" : "flight") : p.overlap_rate > 0 ? "loading" : "unloading"] += weight;
        }
      }
    }
  }
  Location where;
  if (!(all > 0)) return where;
  const auto strongest = std::max_element(total.begin(), total.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
  where.channel = name_of(strongest);
  where.variable = strongest == Channel::impact ? "impact" : "t";
  where.unit = strongest == Channel::impact ? "1" : "s";
  std::tie(where.from, where.to) = shortest(by_channel[strongest], held);
  where.sign = signed_total[strongest] > 0 ? "above" : "below";
  for (const auto& [phase, weight] : by_phase)
    if (weight > of_one * all) where.phase = phase;
  for (const auto& [run, weight] : by_run)
    if (weight > of_one * all) where.run = run;
  return where;
}

}  // namespace quern
