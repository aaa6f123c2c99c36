#include "src/diagnose/recording.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include "src/base/error.hpp"
#include "src/base/vec.hpp"
#include "src/case/csv.hpp"
#include "src/case/keys.hpp"

namespace quern {
namespace {

constexpr std::array<const char*, channel_count> channel_names = {"x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "force", "displacement", "impact"};
constexpr std::array<const char*, channel_count> channel_units = {"m", "m", "m", "m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s", "N", "m", "s"};
constexpr std::array quaternion_names = {"qw", "qx", "qy", "qz"};
constexpr std::size_t fewest_samples = 1;

// Between the means of the two or so samples on either side.
void find_rates(Series& series) {
  const std::size_t n = series.value.size();
  series.rate.assign(n, 0.0);
  if (series.channel == Channel::impact || n < 5) return;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t from = k >= 2 ? k - 2 : 0, to = std::min(n - 1, k + 2);
    const double step = series.t[to] - series.t[from];
    if (step > 0) series.rate[k] = (series.value[to] - series.value[from]) / step;
  }
}

// One column of numbers, empty cells allowed.
struct Column {
  int index = -1;
  double factor = 1;
};

class Reader {
 public:
  explicit Reader(const std::string& file) : table_(read_cells(file)) {}

  void read(Recording& recording, bool first_file) {
    const RecordingKind kind = find_columns();
    if (first_file) recording.kind = kind;
    if (kind != recording.kind)
      fail(fmt::format("this is a recording of {}, and {} one of {}; allowed are files of one kind", word_of(kind), recording.files.front(), word_of(recording.kind)));
    std::map<std::string, std::vector<std::size_t>> rows;
    std::vector<std::string> order;
    for (std::size_t row = 0; row < table_.rows.size(); ++row) {
      const std::string label = run_ >= 0 ? cell(row, run_) : "1";
      if (label.empty()) table_.refuse(row, run_, "found nothing; allowed is the label of a run");
      if (rows.find(label) == rows.end()) order.push_back(label);
      rows[label].push_back(row);
    }
    std::vector<double> times(table_.rows.size());  // of each row
    std::set<std::string> known;
    for (const RecordedRun& run : recording.runs) known.insert(run.label);
    for (const std::string& label : order) {
      if (known.count(label) > 0)
        fail(fmt::format("run {} stands in another file too; allowed is each label once", label));
      recording.runs.push_back(read_run(label, rows[label], kind, times, recording));
    }
    recording.files.push_back(table_.file);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(fmt::format("{}:{}: {}.", table_.file, table_.header_line, what)); }

  static const char* word_of(RecordingKind kind) {
    return kind == RecordingKind::trajectory ? "a trajectory" : kind == RecordingKind::contact ? "a contact" : "impact times";
  }

  const std::string& cell(std::size_t row, int column) const { return table_.rows[row][static_cast<std::size_t>(column)]; }

  double factor_of(int column, const std::string& si) const {
    // A column without a unit is in SI.
    return table_.units[static_cast<std::size_t>(column)].empty() ? 1.0 : unit_of(table_, column, {si}).factor;
  }

  RecordingKind find_columns() {
    channels_.fill({});
    for (int k = 0; k < static_cast<int>(table_.names.size()); ++k) {
      const std::string& name = table_.names[static_cast<std::size_t>(k)];
      const auto& names = table_.names;
      if (std::count(names.begin(), names.end(), name) > 1) fail(fmt::format("found two columns {}; allowed is one", name));
      if (name == "run") run_ = k;
      else if (name == "held_out") held_out_ = k;
      else if (name == "t") time_ = {k, factor_of(k, "s")};
      else if (!take_channel(name, k) && !take_condition(name, k)) refuse_column(name);
    }
    if (time_.index < 0) fail("found no column t [s]; needed is the time of each row");
    const bool contact = has(Channel::force) || has(Channel::displacement), impacts = has(Channel::impact);
    bool trajectory = quaternion_[0].index >= 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(Channel::force); ++c) trajectory |= channels_[c].index >= 0;
    if (contact + impacts + trajectory != 1)
      fail("needed are columns of one kind: force [N] or displacement [m] (a contact); x, y, z [m], vx … [m/s], wx … [rad/s], qw … qz (a trajectory); impact [1] (impact times)");
    return contact ? RecordingKind::contact : impacts ? RecordingKind::impacts : RecordingKind::trajectory;
  }

  bool has(Channel channel) const { return channels_[static_cast<std::size_t>(channel)].index >= 0; }

  bool take_channel(const std::string& name, int k) {
    for (std::size_t c = 0; c < channel_count; ++c) {
      const std::string plain = channel_names[c];
      const std::string unit = static_cast<Channel>(c) == Channel::impact ? "1" : channel_units[c];
      if (name == plain) channels_[c] = {k, factor_of(k, unit)};
      else if (name == plain + "_sd" || (static_cast<Channel>(c) == Channel::impact && name == "t_sd")) deviations_[c] = {k, factor_of(k, channel_units[c])};
      else continue;
      return true;
    }
    for (std::size_t q = 0; q < 4; ++q)
      if (name == quaternion_names[q]) return quaternion_[q] = {k, 1}, true;
    return false;
  }

  bool take_condition(const std::string& name, int k) {
    for (const ConditionName& one : condition_names)
      if (name == one.name) return conditions_[name] = {k, factor_of(k, one.unit)}, true;
    const Key* key = find_key(split_path(name));
    if (key == nullptr || (key->kind != KeyKind::number && key->kind != KeyKind::whole)) return false;
    // Keys whose unit depends on an exponent have none in the table.
    conditions_[name] = {k, std::string_view(key->unit) == "1" ? 1.0 : factor_of(k, key->unit)};
    return true;
  }

  [[noreturn]] void refuse_column(const std::string& name) const {
    std::vector<std::string> words = {"run", "t", "held_out", "qw", "qx", "qy", "qz"};
    for (const char* channel : channel_names) words.emplace_back(channel), words.push_back(std::string(channel) + "_sd");
    for (const ConditionName& one : condition_names) words.emplace_back(one.name);
    const std::string nearest = nearest_word(name, words);
    fail(fmt::format("found the column {}; allowed are run, t, held_out, the channels x y z vx vy vz wx wy wz qw qx qy qz force displacement impact (each with _sd), the conditions mass, "
                     "diameter, density, impact_speed, impact_angle, drop_height, x0 … wz0, and any key of the case that is a number{}",
                     name, nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }

  std::optional<double> number(std::size_t row, const Column& column) const {
    if (column.index < 0) return std::nullopt;
    const std::string& text = cell(row, column.index);
    if (text.empty() || text == "nan" || text == "NaN" || text == "NA") return std::nullopt;
    return number_in(table_, row, column.index) * column.factor;
  }

  RecordedRun read_run(const std::string& label, const std::vector<std::size_t>& rows, RecordingKind kind, std::vector<double>& times, Recording& recording) const {
    RecordedRun run;
    run.label = label;
    run.where = fmt::format("{}:{}", table_.file, table_.lines[rows.front()]);
    for (const std::size_t row : rows) {
      if (held_out_ >= 0 && !cell(row, held_out_).empty()) {
        const double flag = number_in(table_, row, held_out_);
        if (flag != 0 && flag != 1) table_.refuse(row, held_out_, fmt::format("found {}; allowed are 0 and 1", flag));
        if (run.held_out && *run.held_out != (flag == 1)) table_.refuse(row, held_out_, fmt::format("found 0 and 1 within run {}; allowed is one of them: a run is held out whole or not at all", label));
        run.held_out = flag == 1;
      }
      for (const auto& [name, column] : conditions_) {
        const std::optional<double> value = number(row, column);
        if (!value) continue;
        const auto [old, fresh] = run.conditions.emplace(name, *value);
        if (!fresh && std::abs(old->second - *value) > 1e-9 * std::abs(*value))
          table_.refuse(row, column.index, fmt::format("found two values within run {}; allowed is one, since it is a condition", label));
      }
    }
    // In order of time, whatever the order of the rows; of two rows of one time and channel the mean is not taken: both stay.
    std::vector<std::size_t> sorted = rows;
    for (const std::size_t row : rows) {
      const std::optional<double> t = number(row, time_);
      if (!t) table_.refuse(row, time_.index, "found nothing; allowed is a time");
      times[row] = *t;
    }
    std::stable_sort(sorted.begin(), sorted.end(), [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
    if (kind == RecordingKind::impacts) add_impacts(sorted, times, run);
    else
      for (std::size_t c = 0; c < channel_count; ++c) add_series(static_cast<Channel>(c), sorted, times, run);
    if (quaternion_[0].index >= 0) add_spin(sorted, times, run, recording);
    std::size_t samples = 0;
    for (const Series& series : run.series) samples += series.value.size();
    if (samples < fewest_samples) throw InputError(fmt::format("{}: run {} holds no numbers; needed is at least one.", run.where, label));
    return run;
  }

  void add_series(Channel channel, const std::vector<std::size_t>& rows, const std::vector<double>& times, RecordedRun& run) const {
    const auto c = static_cast<std::size_t>(channel);
    if (channels_[c].index < 0) return;
    Series series{channel, {}, {}, {}, {}, {}};
    for (const std::size_t row : rows) {
      const std::optional<double> value = number(row, channels_[c]);
      if (!value) continue;
      series.t.push_back(times[row]);
      series.value.push_back(*value);
      add_deviation(row, c, series);
    }
    if (!series.value.empty()) run.series.push_back(std::move(series));
  }

  void add_deviation(std::size_t row, std::size_t c, Series& series) const {
    if (deviations_[c].index < 0) return;
    const std::optional<double> deviation = number(row, deviations_[c]);
    if (!deviation || !(*deviation > 0)) table_.refuse(row, deviations_[c].index, "allowed is a standard deviation above 0 beside each value");
    series.deviation.push_back(*deviation);
  }

  void add_impacts(const std::vector<std::size_t>& rows, const std::vector<double>& times, RecordedRun& run) const {
    const auto c = static_cast<std::size_t>(Channel::impact);
    Series series{Channel::impact, {}, {}, {}, {}, {}};
    for (const std::size_t row : rows) {
      const std::optional<double> count = number(row, channels_[c]);
      if (!count || *count < 1 || *count != std::floor(*count)) table_.refuse(row, channels_[c].index, "allowed is the number of the impact: 1, 2, 3 …");
      if (!series.t.empty() && *count <= series.t.back()) table_.refuse(row, channels_[c].index, "allowed are numbers that grow with the time");
      series.t.push_back(*count);
      series.value.push_back(times[row]);
      add_deviation(row, c, series);
    }
    run.series.push_back(std::move(series));
  }

  // The mean spin between two orientations, at the middle of their times.
  void add_spin(const std::vector<std::size_t>& rows, const std::vector<double>& times, RecordedRun& run, Recording& recording) const {
    for (const Column& column : quaternion_)
      if (column.index < 0) fail("found some of qw, qx, qy, qz; allowed are all four or none");
    std::array<Series, 3> spin = {Series{Channel::wx, {}, {}, {}, {}, {}}, Series{Channel::wy, {}, {}, {}, {}, {}}, Series{Channel::wz, {}, {}, {}, {}, {}}};
    std::optional<Rotation> before;
    double time_before = 0;
    for (const std::size_t row : rows) {
      double q[4];
      bool whole = true;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::optional<double> value = number(row, quaternion_[k]);
        whole &= value.has_value();
        q[k] = value.value_or(0);
      }
      Rotation now(q[0], q[1], q[2], q[3]);
      if (!whole) continue;
      if (!(now.norm() > 0.5 && now.norm() < 2)) table_.refuse(row, quaternion_[0].index, "found a quaternion far from length 1; allowed are orientations");
      now.normalize();
      if (before && times[row] > time_before) {
        const Eigen::AngleAxisd turn(now * before->conjugate());
        const double angle = turn.angle() > M_PI ? turn.angle() - 2 * M_PI : turn.angle();
        for (int axis = 0; axis < 3; ++axis) {
          spin[static_cast<std::size_t>(axis)].t.push_back(0.5 * (times[row] + time_before));
          spin[static_cast<std::size_t>(axis)].value.push_back(angle * turn.axis()[axis] / (times[row] - time_before));
        }
      }
      before = now, time_before = times[row];
    }
    if (recording.remarks.empty()) recording.remarks.push_back("Orientations were compared as the mean spin between each two.");
    for (Series& one : spin)
      if (!one.t.empty() && run.find(one.channel) == nullptr) run.series.push_back(std::move(one));
  }

  TextTable table_;
  int run_ = -1, held_out_ = -1;
  Column time_;
  std::array<Column, channel_count> channels_, deviations_;
  std::array<Column, 4> quaternion_;
  std::map<std::string, Column> conditions_;
};

}  // namespace

const char* name_of(Channel channel) { return channel_names[static_cast<std::size_t>(channel)]; }
const char* unit_of(Channel channel) { return channel_units[static_cast<std::size_t>(channel)]; }

const char* quantity_of(Channel channel) {
  constexpr std::array words = {"position", "velocity", "spin"};
  return channel < Channel::force ? words[static_cast<std::size_t>(channel) / 3] : name_of(channel);
}

double RecordedRun::first_time() const {
  double first = 1e300;
  for (const Series& one : series) first = std::min(first, one.t.front());
  return first;
}

double RecordedRun::last_time() const {
  double last = -1e300;
  for (const Series& one : series) last = std::max(last, one.channel == Channel::impact ? one.value.back() : one.t.back());
  return last;
}

const Series* RecordedRun::find(Channel channel) const {
  for (const Series& one : series)
    if (one.channel == channel) return &one;
  return nullptr;
}

Recording read_recordings(const std::vector<std::string>& files) {
  Recording recording;
  for (const std::string& file : files) Reader(file).read(recording, file == files.front());
  for (RecordedRun& run : recording.runs)
    for (Series& series : run.series) find_rates(series);
  return recording;
}

std::vector<std::size_t> channels_of(const Recording& recording) {
  std::vector<bool> seen(channel_count);
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series) seen[static_cast<std::size_t>(series.channel)] = true;
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < channel_count; ++c)
    if (seen[c]) channels.push_back(c);
  return channels;
}

double resolution_of(const Recording& recording, Channel channel) {
  double largest = 0;
  for (const RecordedRun& run : recording.runs)
    for (const Series& series : run.series)
      if (series.channel == channel)
        for (double y : series.value) largest = std::max(largest, std::abs(y));
  return 1e-7 * std::max(largest, 1e-12);
}

}  // namespace quern
