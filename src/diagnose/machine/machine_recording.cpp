#include "src/diagnose/machine/machine_recording.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/case/csv.hpp"
#include "src/case/keys.hpp"

namespace quern {
namespace {

bool is_channel(const std::string& name) {
  return std::any_of(machine_channels.begin(), machine_channels.end(), [&](const MachineChannel& c) { return name == c.name; });
}

struct Column {
  int index = -1;
  double factor = 1;
};

class Reader {
 public:
  explicit Reader(const std::string& file) : table_(read_cells(file)) { find_columns(); }

  void read(MachineRecording& recording) const {
    for (std::size_t row = 0; row < table_.rows.size(); ++row) {
      MachineRow read = conditions_of(row);
      auto same = std::find_if(recording.rows.begin(), recording.rows.end(), [&](const MachineRow& one) { return alike(one.conditions, read.conditions); });
      constexpr std::size_t most_conditions = 2000;
      if (same == recording.rows.end() && recording.rows.size() >= most_conditions)
        throw InputError(fmt::format("{}:{}: found more than {} conditions; each takes simulations of its own.", table_.file, table_.lines[row], most_conditions));
      if (same == recording.rows.end()) same = recording.rows.insert(recording.rows.end(), read);
      if (read.held_out) {
        if (same->held_out && *same->held_out != *read.held_out)
          table_.refuse(row, held_out_, fmt::format("found 0 and 1 under the conditions of {}; allowed is one of them: a condition is held out whole or not at all", same->where));
        same->held_out = read.held_out;
      }
      for (Reading& one : readings_of(row)) same->readings.push_back(std::move(one));
    }
    recording.files.push_back(table_.file);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(fmt::format("{}:{}: {}.", table_.file, table_.header_line, what)); }
  const std::string& cell(std::size_t row, int column) const { return table_.rows[row][static_cast<std::size_t>(column)]; }

  double factor_of(int column, const std::string& si) const {
    if (table_.units[static_cast<std::size_t>(column)].empty()) return 1;  // in SI, angles in degrees
    if (si != "deg") return unit_of(table_, column, {si}).factor;
    return unit_of(table_, column, {"rad"}).factor * 180 / M_PI;
  }

  void find_columns() {
    for (int k = 0; k < static_cast<int>(table_.names.size()); ++k) {
      const std::string& name = table_.names[static_cast<std::size_t>(k)];
      if (std::count(table_.names.begin(), table_.names.end(), name) > 1) fail(fmt::format("found two columns {}; allowed is one", name));
      if (name == "run") continue;  // a label of people's own: conditions tell what belongs together
      else if (name == "held_out") held_out_ = k;
      else if (name == "pair") pair_ = k;
      else if (name == "energy") energy_ = {k, factor_of(k, "J")};
      else if (!take_channel(name, k) && !take_condition(name, k)) refuse_column(name);
    }
    if (channels_.empty()) fail("found no column of a mill curve, spectrum or breakage curve; needed is one of power, torque, shoulder, toe, rate, damage_ratio, largest_fragment_fraction");
    if (channels_.count("rate") > 0 && energy_.index < 0) fail("found the column rate without energy [J]; needed is the energy at the middle of each bin");
    if (energy_.index >= 0 && (channels_.size() > 1 || channels_.count("rate") == 0)) fail("found the column energy beside others than rate [1/s]; allowed is a spectrum in a file of its own");
  }

  bool take_channel(const std::string& name, int k) {
    for (const MachineChannel& one : machine_channels) {
      if (name == one.name) channels_[name] = {k, factor_of(k, one.unit)};
      else if (name == std::string(one.name) + "_sd") deviations_[one.name] = {k, factor_of(k, one.unit)};
      else continue;
      return true;
    }
    return false;
  }

  bool take_condition(const std::string& name, int k) {
    for (const MachineConditionName& one : machine_condition_names)
      if (name == one.name) return conditions_[name] = {k, factor_of(k, one.unit)}, true;
    const Key* key = find_key(split_path(name));
    if (key == nullptr || (key->kind != KeyKind::number && key->kind != KeyKind::whole)) return false;
    conditions_[name] = {k, std::string_view(key->unit) == "1" ? 1.0 : factor_of(k, key->unit)};
    return true;
  }

  [[noreturn]] void refuse_column(const std::string& name) const {
    std::vector<std::string> words = {"run", "held_out", "pair", "energy"};
    for (const MachineChannel& one : machine_channels) words.emplace_back(one.name), words.push_back(std::string(one.name) + "_sd");
    for (const MachineConditionName& one : machine_condition_names) words.emplace_back(one.name);
    const std::string nearest = nearest_word(name, words);
    fail(fmt::format("found the column {}; allowed are run, held_out, power, torque, shoulder, toe, damage_ratio, largest_fragment_fraction (each with _sd), energy with rate and pair, the "
                     "conditions speed, speed_fraction, filling, ball_diameter, impact_speed, campaign_time, and any key of the case that is a number{}",
                     name, nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }

  std::optional<double> number(std::size_t row, const Column& column) const {
    const std::string& text = cell(row, column.index);
    if (text.empty() || text == "nan" || text == "NaN" || text == "NA") return std::nullopt;
    return number_in(table_, row, column.index) * column.factor;
  }

  MachineRow conditions_of(std::size_t row) const {
    MachineRow read;
    read.where = fmt::format("{}:{}", table_.file, table_.lines[row]);
    if (held_out_ >= 0 && !cell(row, held_out_).empty()) {
      const double flag = number_in(table_, row, held_out_);
      if (flag != 0 && flag != 1) table_.refuse(row, held_out_, fmt::format("found {}; allowed are 0 and 1", flag));
      read.held_out = flag == 1;
    }
    for (const auto& [name, column] : conditions_) {
      const std::optional<double> value = number(row, column);
      if (!value) table_.refuse(row, column.index, "found nothing; allowed is the condition under which the row was recorded");
      read.conditions[name] = *value;
      const std::string as_written = fmt::format("{} {}{}", name, cell(row, column.index), table_.units[static_cast<std::size_t>(column.index)].empty() ? "" : " " + table_.units[static_cast<std::size_t>(column.index)]);
      read.label += (read.label.empty() ? "" : ", ") + as_written;
    }
    if (read.label.empty()) read.label = "as in the case";
    return read;
  }

  std::vector<Reading> readings_of(std::size_t row) const {
    std::vector<Reading> all;
    for (const auto& [name, column] : channels_) {
      const std::optional<double> value = number(row, column);
      if (!value) continue;
      Reading one{name, *value, 0, 0, pair_ >= 0 ? cell(row, pair_) : ""};
      if (const auto deviation = deviations_.find(name); deviation != deviations_.end()) {
        const std::optional<double> given = number(row, deviation->second);
        if (!given || !(*given > 0)) table_.refuse(row, deviation->second.index, "allowed is a standard deviation above 0 beside each value");
        one.deviation = *given;
      }
      if (name == "rate") {
        const std::optional<double> energy = number(row, energy_);
        if (!energy || !(*energy > 0)) table_.refuse(row, energy_.index, "allowed is an energy above 0 J");
        if (*value < 0) table_.refuse(row, column.index, "allowed is a rate of at least 0 1/s");
        one.energy = *energy;
      }
      all.push_back(one);
    }
    return all;
  }

  static bool alike(const std::map<std::string, double>& a, const std::map<std::string, double>& b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) {
             return x.first == y.first && std::abs(x.second - y.second) <= 1e-9 * std::max(std::abs(x.second), std::abs(y.second));
           });
  }

  TextTable table_;
  int held_out_ = -1, pair_ = -1;
  Column energy_;
  std::map<std::string, Column> channels_, deviations_, conditions_;
};

}  // namespace

const MachineChannel& machine_channel(const std::string& name) {
  return *std::find_if(machine_channels.begin(), machine_channels.end(), [&](const MachineChannel& c) { return name == c.name; });
}

const char* unit_of_machine_condition(const std::string& name) {
  for (const MachineConditionName& one : machine_condition_names)
    if (name == one.name) return one.unit;
  return "1";
}

bool is_machine_recording(const std::string& file) {
  const TextTable table = read_cells(file);
  return table.find("t") < 0 && std::any_of(table.names.begin(), table.names.end(), is_channel);
}

MachineRecording read_machine_recordings(const std::vector<std::string>& files) {
  MachineRecording recording;
  for (const std::string& file : files) Reader(file).read(recording);
  std::stable_sort(recording.rows.begin(), recording.rows.end(), [](const MachineRow& a, const MachineRow& b) { return a.conditions < b.conditions; });
  return recording;
}

}  // namespace quern
