#include "src/diagnose/machine/machine_experiment.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>
#include "src/base/error.hpp"
#include "src/case/build.hpp"

namespace quern {
namespace {

// The only name under a table, or a sentence.
std::string only_name(const Values& base, const std::string& table, const MachineRow& row, const char* condition) {
  const std::vector<std::string> names = base.names(table);
  if (names.size() != 1)
    throw InputError(fmt::format("{}: {}: the case has {} tables {}.<name>, and it is not clear which this is of; allowed is a column with the whole key, such as {}.{}.diameter.", row.where, condition, names.size(),
                                 table, table, names.empty() ? "name" : names.front()));
  return names.front();
}

void set_condition(Values& values, const MachineRow& row, const std::string& name, double value) {
  if (name == "speed" || name == "speed_fraction") {
    values.given.erase(split_path(name == "speed" ? "mill.speed_fraction" : "mill.speed"));
    values.put("mill." + name, value, row.where);
  } else if (name == "filling") {
    if (values.has("mill.filling")) return values.put("mill.filling", value, row.where);
    values.put("insert." + only_name(values, "insert", row, "filling") + ".filling", value, row.where);
  } else if (name == "ball_diameter") {
    values.put("species." + only_name(values, "species", row, "ball_diameter") + ".diameter", value, row.where);
  } else if (name == "impact_speed") {
    values.put("insert." + only_name(values, "insert", row, "impact_speed") + ".speed", value, row.where);
  } else if (name == "campaign_time") {
    values.put("mill.campaign_time", value, row.where);
  } else {
    const Parameter given = parameter_of(values, name);
    alter(values, {{{&given, value}}, {}});
  }
}

// Edges of the bins whose middles were recorded, halfway between them on a logarithmic scale.
void find_edges(std::vector<RecordedChannel::Site>& sites) {
  std::set<double> all;
  for (const auto& site : sites) all.insert(site.energy);
  const std::vector<double> middle(all.begin(), all.end());
  for (auto& site : sites) {
    const auto at = static_cast<std::size_t>(std::lower_bound(middle.begin(), middle.end(), site.energy) - middle.begin());
    const double usual = std::pow(10.0, 0.05);  // half a bin of ten per decade
    const double below = at > 0 ? std::sqrt(middle[at - 1] / middle[at]) : at + 1 < middle.size() ? std::sqrt(middle[at] / middle[at + 1]) : 1 / usual;
    const double above = at + 1 < middle.size() ? std::sqrt(middle[at + 1] / middle[at]) : 1 / below;
    site.from = site.energy * below, site.to = site.energy * above;
  }
}

// Repeats become their mean. How far they lie apart tells the noise, their own as far as there are enough and that of the whole channel as far as there are not,
// where that is more than is claimed for it. Returns how many were joined.
int join_repeats(RecordedChannel& channel) {
  std::vector<std::vector<RecordedChannel::Site>> groups;
  for (const RecordedChannel::Site& site : channel.sites) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.front().row == site.row && group.front().energy == site.energy; });
    if (same == groups.end()) groups.push_back({site});
    else same->push_back(site);
  }
  const auto squares_of = [](const std::vector<RecordedChannel::Site>& group) {
    double sum = 0, squares = 0;
    for (const auto& site : group) sum += site.value, squares += site.value * site.value;
    return std::max(0.0, squares - sum * sum / static_cast<double>(group.size()));
  };
  double squares = 0;
  int degrees = 0;
  for (const auto& group : groups) squares += squares_of(group), degrees += static_cast<int>(group.size()) - 1;
  channel.sites.clear();
  for (const auto& group : groups) {
    const auto n = static_cast<double>(group.size());
    RecordedChannel::Site mean = group.front();
    mean.value = 0;
    double variance = 0;
    for (const auto& site : group) mean.value += site.value / n, variance += site.deviation * site.deviation / n;
    constexpr int enough = 3;       // fewer say little of a deviation
    constexpr double weight = 3;    // of the whole channel, in degrees of freedom
    if (degrees > 0 && (variance == 0 || degrees >= enough)) variance = std::max(variance, (squares_of(group) + weight * squares / degrees) / (n - 1 + weight));
    mean.deviation = std::sqrt(variance / n);
    channel.sites.push_back(mean);
  }
  return degrees;
}

}  // namespace

double RecordedChannel::scaled(double x) const { return scale == Scale::logarithm ? std::log(x) : scale == Scale::share ? std::asin(std::sqrt(std::clamp(x, 0.0, 1.0))) : x; }

double RecordedChannel::plain(double y) const { return scale == Scale::logarithm ? std::exp(y) : scale == Scale::share ? std::pow(std::sin(std::clamp(y, 0.0, 0.5 * M_PI)), 2) : y; }

double RecordedChannel::stretch(double x) const {
  constexpr double end = 0.01;  // of shares, nearer to which the scale is taken as there
  const double inside = std::clamp(x, end, 1 - end);
  return scale == Scale::logarithm ? 1 / x : scale == Scale::share ? 0.5 / std::sqrt(inside * (1 - inside)) : 1;
}

MachineExperiment::MachineExperiment(Values base, const MachineRecording& recording) : base_(std::move(base)), recording_(&recording) {
  std::map<std::string, std::set<double>> taken;
  for (std::size_t r = 0; r < recording.rows.size(); ++r) {
    const MachineRow& row = recording.rows[r];
    for (const auto& [name, value] : row.conditions) taken[name].insert(value);
    for (const Reading& one : row.readings) {
      auto channel = std::find_if(channels_.begin(), channels_.end(), [&](const RecordedChannel& c) { return c.name == one.channel && c.pair == one.pair; });
      if (channel == channels_.end()) {
        channel = channels_.insert(channels_.end(), RecordedChannel{});
        channel->name = one.channel, channel->pair = one.pair, channel->scale = one.channel == "rate" ? Scale::logarithm : machine_channel(one.channel).share ? Scale::share : Scale::linear;
      }
      RecordedChannel::Site site{r};
      site.energy = one.energy, site.value = one.value, site.deviation = one.deviation;
      if (channel->scale == Scale::logarithm && !(one.value > 0)) continue;  // an empty bin: how empty, nobody says
      site.deviation *= channel->stretch(one.value), site.value = channel->scaled(one.value);
      channel->sites.push_back(site);
    }
  }
  std::erase_if(channels_, [](const RecordedChannel& c) { return c.sites.empty(); });
  int joined = 0;
  for (RecordedChannel& channel : channels_) joined += join_repeats(channel);
  if (joined > 0) remarks_.push_back(fmt::format("{} repeats were joined to means; their scatter tells the noise.", joined));
  std::size_t most = 1;
  for (const auto& [name, values] : taken)
    if (values.size() > most) most = values.size(), leading_ = name;
  for (RecordedChannel& channel : channels_) {
    if (channel.name == "rate") find_edges(channel.sites);
    std::vector<std::string> varied;
    for (const auto& [name, values] : taken)
      if (values.size() > 1) varied.push_back(name);
    const bool energies = channel.name == "rate";
    channel.coordinates = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(channel.sites.size()), static_cast<Eigen::Index>(varied.size() + energies));
    for (std::size_t k = 0; k < channel.sites.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      for (std::size_t v = 0; v < varied.size(); ++v) {
        const std::set<double>& values = taken[varied[v]];
        const double least = *values.begin(), most_of = *values.rbegin(), here = recording.rows[channel.sites[k].row].conditions.at(varied[v]);
        constexpr double wide = 3;  // what spans more counts by its logarithm
        const double place = least > 0 && most_of > wide * least ? std::log(here / least) / std::log(most_of / least) : (here - least) / (most_of - least);
        channel.coordinates(row, static_cast<Eigen::Index>(v)) = place;
      }
      constexpr double decades = 3;  // over which a spectrum changes as much as over all conditions
      if (energies) channel.coordinates(row, static_cast<Eigen::Index>(varied.size())) = std::log10(channel.sites[k].energy) / decades;
    }
  }
  const bool mill = base_.has_table("mill");
  for (const RecordedChannel& channel : channels_)
    if (!mill && (channel.name == "power" || channel.name == "torque" || channel.name == "shoulder" || channel.name == "toe"))
      throw InputError(fmt::format("{}: the recording {} shows {}, and the case has no [mill]; allowed is a case of the machine that was recorded.", base_.file, recording.files.front(), channel.name));
  for (std::size_t r = 0; r < recording.rows.size(); ++r) case_of(values_of(r, {}));  // every condition is checked before any is run
}

Values MachineExperiment::values_of(std::size_t row, const Alteration& altered) const {
  Values values = base_;
  for (const auto& [name, value] : recording_->rows[row].conditions) set_condition(values, recording_->rows[row], name, value);
  alter(values, altered);
  return values;
}

Values MachineExperiment::compared(std::size_t row, const Alteration& altered) const {
  Values values = values_of(row, altered);
  std::erase_if(values.given, [](const auto& one) { return one.first.front() == "diagnose"; });  // no run depends on what is asked of it
  for (const char* key : {"output.pictures", "output.paraview", "output.trajectory", "observe.shell_force"}) values.put(key, false, "comparison");
  bool angles = false, spectrum = false;
  for (const RecordedChannel& channel : channels_) {
    angles |= channel.name == "shoulder" || channel.name == "toe";
    spectrum |= channel.name == "rate";
  }
  if (!angles) values.put("observe.charge", false, "comparison");
  if (!spectrum) values.put("observe.spectrum", false, "comparison");
  // A step that the case asks for may be too long for what is added.
  if (values.has("time_step.value") && !(altered.changes.empty() && altered.settings.empty())) {
    try {
      build_case(case_of(values));
    } catch (const InputError&) {
      values.given.erase(split_path("time_step.value"));
    }
  }
  return values;
}

int MachineExperiment::packings() const {
  constexpr int several = 4;
  return std::any_of(channels_.begin(), channels_.end(), [](const RecordedChannel& c) { return c.name == "damage_ratio" || c.name == "largest_fragment_fraction"; }) ? several : 1;
}

bool MachineExperiment::shown(const Outcome& outcome, const RecordedChannel& channel, const RecordedChannel::Site& site, double& value, double& deviation) const {
  if (!outcome.sound) return false;
  if (channel.scale != Scale::logarithm) {
    const auto found = outcome.numbers.find(machine_channel(channel.name).headline);
    if (found == outcome.numbers.end()) return false;
    const Outcome::Number& number = found->second;
    if (!std::isfinite(number.value)) return false;
    value = channel.scaled(number.value), deviation = number.deviation * channel.stretch(number.value);
    return true;
  }
  // What the simulated bins have between the edges of the recorded one, spread evenly over the logarithm.
  double rate = 0, variance = 0;
  for (const Outcome::Bin& bin : outcome.bins) {
    if (!channel.pair.empty() && bin.pair != channel.pair) continue;
    const double width = std::log(bin.to / bin.from), shared = std::log(std::min(bin.to, site.to) / std::max(bin.from, site.from));
    if (!(shared > 0)) continue;
    const double part = shared / width;
    rate += part * bin.rate, variance += part * bin.deviation * bin.deviation;
  }
  if (!(rate > 0)) return false;
  value = std::log(rate), deviation = std::sqrt(variance) / rate;
  return true;
}

}  // namespace quern
