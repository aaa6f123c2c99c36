#include "src/case/grinding_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/csv.hpp"
#include "src/case/keys.hpp"
#include "src/grinding/passing_size.hpp"

namespace quern {
namespace {

constexpr const char* energy_rate = "impact_energy_rate";

bool is_digits(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); }); }

bool is_number(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == 0;
}

// "D80" or "d80".
bool is_measure(const std::string& name) { return name.size() > 1 && (name[0] == 'D' || name[0] == 'd') && is_digits(std::string_view(name).substr(1)); }

// The rows of one operating point: first those shared by all, then its own.
struct Group {
  std::string label;
  std::vector<std::size_t> rows;
  std::size_t shared = 0;

  std::size_t first() const { return rows[shared]; }
};

constexpr const char* every_run = "*";

// What the runs of a sweep sieved themselves, each under the name of its folder.
TextTable sizes_of_sweep(const std::string& folder) {
  const std::filesystem::path place(folder);
  const TextTable sweep = read_cells((place / "sweep.csv").string());
  const int directory = sweep.find("directory");
  if (directory < 0) throw InputError(fmt::format("{}:{}: the column directory is missing; allowed is the folder of a sweep.", sweep.file, sweep.header_line));
  TextTable all;
  for (const std::vector<std::string>& run : sweep.rows) {
    const std::string& name = run[static_cast<std::size_t>(directory)];
    TextTable one = read_cells((place / name / "product_sizes.csv").string());
    for (std::vector<std::string>& row : one.rows) row.push_back(name);
    one.names.push_back("run"), one.units.emplace_back();
    if (!all.names.empty() && one.names != all.names) throw InputError(fmt::format("{}:{}: its columns are not those of the runs before; allowed are runs of one sweep.", one.file, one.header_line));
    if (all.names.empty()) all = std::move(one), all.file = folder;
    else all.rows.insert(all.rows.end(), one.rows.begin(), one.rows.end()), all.lines.insert(all.lines.end(), one.lines.begin(), one.lines.end());
  }
  return all;
}

struct Reader {
  const GrindingRequest& request;
  TextTable table;
  GrindingStudy study;
  std::vector<Group> groups;
  std::vector<int> conditions;  // columns
  int time = -1;
  double time_factor = 1, last_time = std::numeric_limits<double>::infinity();

  explicit Reader(const GrindingRequest& r) : request(r), table(std::filesystem::is_directory(r.file) ? sizes_of_sweep(r.file) : read_cells(r.file)) {}

  [[noreturn]] void refuse_file(const std::string& what) const { throw InputError(fmt::format("{}:{}: {}.", table.file, table.header_line, what)); }

  bool sieved() const { return table.find("size") >= 0; }

  int required(const std::string& name, const std::string& example) const {
    const int column = table.find(name);
    if (column >= 0) return column;
    const std::string near = nearest_word(name, table.names);
    refuse_file(fmt::format("the column {} is missing; needed is {}{}", name, example, near.empty() ? "" : fmt::format(". The nearest here is {}", near)));
  }

  UnitFactor with_unit(int column, const std::vector<std::string>& allowed, const char* example) const {
    if (table.units[static_cast<std::size_t>(column)].empty()) refuse_file(fmt::format("column {} has no unit; write {}", table.names[static_cast<std::size_t>(column)], example));
    return unit_of(table, column, allowed);
  }

  void read_columns() {
    for (const std::string& name : table.names)
      if (std::count(table.names.begin(), table.names.end(), name) > 1) refuse_file(fmt::format("two columns are called {}; repeats are rows of the same time", name));
    time = required("t", "`t [s]` or another unit of time, or `t [1]` to count passes");
    const UnitFactor of_time = with_unit(time, {"s", "1"}, "`t [s]` or `t [min]`");
    study.time_unit = of_time.si, time_factor = of_time.factor;
    if (!request.until.empty()) {
      try {
        last_time = Units().read(request.until, study.time_unit);
      } catch (const InputError& e) {
        throw InputError(fmt::format("--until {}: {}.", request.until, e.what()));
      }
    }
    std::set<int> known = {time, table.find("run"), table.find("sample")};
    std::vector<int> sizes;
    if (sieved()) {
      study.measures = {"D80", "D50"};
      sizes.push_back(table.find("size"));
      if (table.find("percent") < 0 && table.find("finer") < 0) refuse_file("beside `size` the column `percent` (of each class) or `finer` (passing fraction) is needed");
      known.insert({table.find("percent"), table.find("finer"), sizes[0]});
    } else {
      for (int k = 0; k < static_cast<int>(table.names.size()); ++k) {
        const std::string& name = table.names[static_cast<std::size_t>(k)];
        if (!is_measure(name)) continue;
        study.measures.push_back(name);
        sizes.push_back(k);
        for (const char* more : {"", "_sd", "_limit"}) known.insert(table.find(name + more));
      }
      if (sizes.empty()) refuse_file("no column of sizes is there; needed is `D80 [um]`, `D50 [um]`, or `size [um]` with `percent` or `finer`");
    }
    const UnitFactor of_size = with_unit(sizes[0], {"m", "1"}, "`D80 [um]`");
    study.size_unit = of_size.si;
    study.shown_size = of_size.factor, study.shown_size_unit = table.units[static_cast<std::size_t>(sizes[0])];
    for (const std::string& measure : study.measures)
      if (!sieved()) with_unit(table.find(measure), {study.size_unit}, "`D80 [um]`");
    for (const std::string& name : table.names)
      for (const char* more : {"_sd", "_from", "_to"}) known.insert(table.find(name + more));
    for (int k = 0; k < static_cast<int>(table.names.size()); ++k)
      if (!known.count(k)) conditions.push_back(k);
  }

  // The variance of ln x by the columns that go with x's: its standard deviation, or the ends of its 95 % interval; 0 where there are none. The
  // numbers of a column are read by `number(column)`, in the unit of x.
  template <class Number>
  static double log_variance(const TextTable& t, std::size_t row, const std::string& name, double x, Number number) {
    const int sd = t.find(name + "_sd"), from = t.find(name + "_from"), to = t.find(name + "_to");
    const auto filled = [&](int column) { return column >= 0 && !t.rows[row][static_cast<std::size_t>(column)].empty(); };
    if (filled(sd)) {
      if (number(sd) < 0) t.refuse(row, sd, "allowed are standard deviations from 0");
      return std::pow(number(sd) / x, 2);
    }
    if (!filled(from) || !filled(to)) return 0;
    if (!(number(from) <= x && x <= number(to))) t.refuse(row, from, fmt::format("the interval does not hold {}, {:g}", name, x));
    constexpr double normal_quantile = 1.96;
    return std::pow(0.5 * (number(to) - number(from)) / x / normal_quantile, 2);
  }

  void group_rows() {
    const int run = table.find("run");
    std::vector<std::size_t> shared;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      std::string label = run >= 0 ? table.rows[row][static_cast<std::size_t>(run)] : "";
      if (run >= 0 && label.empty()) table.refuse(row, run, "is empty; needed is a name for the series");
      if (run < 0)
        for (const int k : conditions) {
          const auto c = static_cast<std::size_t>(k);
          label += (label.empty() ? "" : ", ") + table.names[c] + " " + table.rows[row][c] + (table.units[c].empty() || table.units[c] == "1" ? "" : " " + table.units[c]);
        }
      if (label.empty()) label = "all";
      if (time_at(row) > last_time) continue;
      if (run >= 0 && label == every_run) {
        shared.push_back(row);
        continue;
      }
      auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.label == label; });
      if (group == groups.end()) group = groups.insert(groups.end(), Group{label, {}});
      group->rows.push_back(row);
    }
    if (groups.empty()) throw InputError(table.file + (request.until.empty() ? ": every row is of the run *; needed are rows of runs." : ": no row is within --until."));
    for (Group& group : groups) group.rows.insert(group.rows.begin(), shared.begin(), shared.end()), group.shared = shared.size();
  }

  double time_at(std::size_t row) const {
    const double t = number_in(table, row, time) * time_factor;
    if (t < 0) table.refuse(row, time, fmt::format("found {}; allowed are times from 0", table.rows[row][static_cast<std::size_t>(time)]));
    return t;
  }

  // A number in a column that must be the same in all rows of a group.
  double constant(const Group& group, int column) const {
    const double value = number_in(table, group.first(), column);
    for (std::size_t k = group.shared; k < group.rows.size(); ++k)
      if (const std::size_t row = group.rows[k]; number_in(table, row, column) != value)
        table.refuse(row, column, fmt::format("found {} where {} has {} before; it must be the same in a run", table.rows[row][static_cast<std::size_t>(column)], group.label, value));
    return value;
  }

  std::optional<double> limit_of(const Group& group, const std::string& measure) const {
    std::optional<double> limit;
    for (const std::string& words : request.limits) {
      const auto equals = words.find('=');
      const std::string name = equals == words.npos ? measure : words.substr(0, equals), quantity = equals == words.npos ? words : words.substr(equals + 1);
      if (std::find(study.measures.begin(), study.measures.end(), name) == study.measures.end())
        throw InputError(fmt::format("--limit {}: found {}; this file has {}.", words, name, fmt::join(study.measures, ", ")));
      if (name != measure) continue;
      try {
        limit = Units().read(quantity, study.size_unit);
      } catch (const InputError& e) {
        throw InputError(fmt::format("--limit {}: {}.", words, e.what()));
      }
      if (*limit < 0) throw InputError(fmt::format("--limit {}: allowed is a size from 0.", words));
    }
    const int column = table.find(measure + "_limit");
    if (limit || column < 0) return limit;
    limit = constant(group, column) * with_unit(column, {study.size_unit}, "`D80_limit [um]`").factor;
    if (*limit < 0) table.refuse(group.first(), column, "allowed is a size from 0");
    return limit;
  }

  SizeSeries sizes_of(const Group& group, const std::string& measure) const {
    const int column = table.find(measure), deviation = table.find(measure + "_sd");
    const double factor = unit_of(table, column, {study.size_unit}).factor;
    SizeSeries series;
    for (const std::size_t row : group.rows) {
      if (table.rows[row][static_cast<std::size_t>(column)].empty()) continue;  // not measured at this time
      const double t = time_at(row), size = number_in(table, row, column) * factor;
      if (!series.times.empty() && t < series.times.back()) table.refuse(row, time, fmt::format("the times of {} do not ascend: found {:g} {} after {:g} {}", group.label, t, study.time_unit, series.times.back(), study.time_unit));
      if (!(size > 0)) table.refuse(row, column, "allowed are sizes above 0");
      series.times.push_back(t), series.sizes.push_back(size);
      if (deviation < 0) continue;
      const double sd = number_in(table, row, deviation) * unit_of(table, deviation, {study.size_unit}).factor;
      if (!(sd > 0)) table.refuse(row, deviation, "allowed are standard deviations above 0");
      series.weights.push_back(1 / (sd * sd));
    }
    // Only their ratios matter; a mean of 1 keeps the scatter readable as a size.
    double sum = 0;
    for (const double w : series.weights) sum += w;
    for (double& w : series.weights) w *= static_cast<double>(series.weights.size()) / sum;
    return series;
  }

  SizeSeries passing_sizes(const Group& group, const std::string& measure) {
    const int size = table.find("size"), percent = table.find("percent"), amount = percent >= 0 ? percent : table.find("finer");
    const double factor = unit_of(table, size, {study.size_unit}).factor, part = percent >= 0 ? 1 : unit_of(table, amount, {"1"}).factor;
    using Sample = std::pair<double, std::string>;  // its time and name
    std::map<Sample, std::map<double, double>> samples;
    std::map<Sample, std::size_t> row_of;
    const int name = table.find("sample");
    for (const std::size_t row : group.rows) {
      const double t = time_at(row), x = number_in(table, row, size) * factor, y = number_in(table, row, amount) * part;
      if (x < 0 || (percent >= 0 && x == 0)) table.refuse(row, size, "allowed are sizes above 0");
      if (y < 0) table.refuse(row, amount, "allowed are amounts from 0");
      const Sample key(t, name < 0 ? "" : table.rows[row][static_cast<std::size_t>(name)]);
      if (!samples[key].emplace(x, y).second) table.refuse(row, size, fmt::format("this size is there twice for {} at {:g} {}; a column `sample` can name repeats", group.label, t, study.time_unit));
      row_of.emplace(key, row);
    }
    SizeSeries series;
    double least = 100, most = 100;  // of the sums [%]
    for (const auto& [key, sample] : samples) {
      const double t = key.first;
      const std::size_t row = row_of[key];
      std::vector<double> sizes, amounts;
      double sum = 0;
      for (const auto& [x, y] : sample) {
        if (percent < 0 && !amounts.empty() && y < amounts.back()) table.refuse(row, amount, fmt::format("the passing fraction of {} at {:g} {} falls with the size", group.label, t, study.time_unit));
        sizes.push_back(x), amounts.push_back(y), sum += y;
      }
      if (percent >= 0) least = std::min(least, sum), most = std::max(most, sum);
      const double fraction = std::stod(measure.substr(1)) / 100;
      const double d = percent >= 0 ? passing_size_of_classes(sizes, amounts, fraction) : passing_size(sizes, amounts, fraction);
      if (!std::isfinite(d) || !(d > 0)) table.refuse(row, amount, fmt::format("{} of {} at {:g} {} lies outside the sizes given", measure, group.label, t, study.time_unit));
      series.times.push_back(t), series.sizes.push_back(d);
    }
    constexpr double rounding = 2;
    if (most - least > rounding && measure == study.measures[0])
      study.remarks.push_back(fmt::format("The classes of {} sum to {:.0f} to {:.0f} %; they are taken as parts of their sum.", group.label, least, most));
    return series;
  }

  // Too few, or growing beyond their scatter.
  void check_series(const Group& group, const SizeSeries& s, const std::string& measure, std::optional<double> limit) const {
    const std::size_t row = group.rows.back();
    const int column = sieved() ? table.find("size") : table.find(measure);
    const std::set<double> times(s.times.begin(), s.times.end());
    const std::size_t needed = limit ? 2 : 3;
    if (times.size() < needed)
      table.refuse(row, column, fmt::format("{} has {} of {} at {} time{}; {} are needed{}", group.label, s.sizes.size(), measure, times.size(), times.size() == 1 ? "" : "s", needed,
                                            limit ? "" : fmt::format(" where the limit is not known, or 2 with `{}_limit` or --limit", measure)));
    const double largest = *std::max_element(s.sizes.begin(), s.sizes.end());
    if (limit && *limit >= largest)
      table.refuse(row, column, fmt::format("the known limit of {}, {:g} {}, is not below its largest {}, {:g} {}", group.label, *limit / study.shown_size, study.shown_size_unit, measure,
                                            largest / study.shown_size, study.shown_size_unit));
    const auto n = static_cast<double>(s.times.size());
    double t = 0, d = 0, tt = 0, td = 0, dd = 0;
    for (std::size_t k = 0; k < s.times.size(); ++k) t += s.times[k] / n, d += s.sizes[k] / n;
    for (std::size_t k = 0; k < s.times.size(); ++k) tt += std::pow(s.times[k] - t, 2), td += (s.times[k] - t) * (s.sizes[k] - d), dd += std::pow(s.sizes[k] - d, 2);
    const double unexplained = std::max(0.0, dd - td * td / tt);
    const bool sure = n < 3 || td * td / tt > std::pow(boost::math::quantile(boost::math::students_t(n - 2), 0.975), 2) * unexplained / (n - 2);
    if (td > 0 && sure)
      table.refuse(row, column, fmt::format("the {} of {} grow, from {:g} to {:g} {}; kinetics of grinding needs sizes that fall", measure, group.label, s.sizes.front() / study.shown_size,
                                            s.sizes.back() / study.shown_size, study.shown_size_unit));
    if (std::all_of(s.sizes.begin(), s.sizes.end(), [&](double size) { return size == s.sizes[0]; }))
      table.refuse(row, column, fmt::format("the {} of {} are all the same; kinetics of grinding needs sizes that fall", measure, group.label));
  }

  void read_against() {
    int column = -1;
    if (!request.against.empty()) {
      column = table.find(request.against);
      if (column < 0) {
        std::vector<std::string> names;
        for (const int k : conditions) names.push_back(table.names[static_cast<std::size_t>(k)]);
        throw InputError(fmt::format("--against {}: {} has no such column{}.", request.against, table.file, names.empty() ? "" : fmt::format("; allowed is one of {}", fmt::join(names, ", "))));
      }
    } else {
      for (const char* name : {energy_rate, "E_i"})
        if (column < 0) column = table.find(name);
      if (column < 0 && conditions.size() == 1 && is_number(table.rows[groups[0].first()][static_cast<std::size_t>(conditions[0])])) column = conditions[0];
    }
    if (column < 0) return;
    const auto c = static_cast<std::size_t>(column);
    const bool energy = table.names[c] == energy_rate || table.names[c] == "E_i";
    study.x_name = energy ? "E_i" : table.names[c];
    study.x_unit = energy ? "W" : table.units[c].empty() ? "1" : table.units[c];
    const double factor = energy ? with_unit(column, {"W"}, "`E_i [W]`").factor : 1;
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const double x = constant(groups[k], column) * factor;
      if (!(x > 0)) table.refuse(groups[k].first(), column, fmt::format("found {}; allowed are numbers above 0", table.rows[groups[k].first()][c]));
      study.points[k].x = x;
      study.points[k].log_x_variance =
          log_variance(table, groups[k].first(), table.names[c], x, [&](int of) { return constant(groups[k], of) * unit_of(table, of, {study.x_unit}).factor; });
    }
  }

  // Which row of the sweep a group belongs to.
  std::size_t row_in(const TextTable& sweep, const Group& group, const std::vector<std::pair<int, int>>& shared) const {
    std::vector<std::size_t> found;
    const int directory = sweep.find("directory");
    for (std::size_t row = 0; row < sweep.rows.size(); ++row)
      if (directory >= 0 && sweep.rows[row][static_cast<std::size_t>(directory)] == group.label) return row;
    for (std::size_t row = 0; row < sweep.rows.size() && !shared.empty(); ++row) {
      const bool same = std::all_of(shared.begin(), shared.end(), [&](const std::pair<int, int>& both) {
        const std::string& here = table.rows[group.first()][static_cast<std::size_t>(both.first)];
        const std::string& there = sweep.rows[row][static_cast<std::size_t>(both.second)];
        const std::string& si = sweep.units[static_cast<std::size_t>(both.second)];
        if (si.empty()) return here == there;
        const double a = number_in(table, group.first(), both.first) * unit_of(table, both.first, {si}).factor, b = number_in(sweep, row, both.second);
        constexpr double rounding = 1e-6;
        return std::abs(a - b) <= rounding * std::max(std::abs(a), std::abs(b));
      });
      if (same) found.push_back(row);
    }
    if (found.size() == 1) return found[0];
    throw InputError(fmt::format("{}:{}: {} matches {} of the {} runs in {}; `run` must name their folders, or columns such as `{}` what was swept.", table.file, table.lines[group.first()], group.label,
                                 found.size(), sweep.rows.size(), sweep.file, sweep.names[0]));
  }

  void read_sweep() {
    const TextTable sweep = read_cells((std::filesystem::path(request.sweep) / "sweep.csv").string());
    const std::string name = request.against.empty() ? energy_rate : request.against;
    const int energy = sweep.find(name);
    if (energy < 0)
      throw InputError(fmt::format("{}:{}: the column {} is missing; {}.", sweep.file, sweep.header_line, name,
                                   name.starts_with(energy_rate) ? "run the sweep with --set observe.spectrum=true" : fmt::format("there are {}", fmt::join(sweep.names, ", "))));
    std::vector<std::pair<int, int>> shared;
    for (const int k : conditions) {
      const std::string& here = table.names[static_cast<std::size_t>(k)];
      for (int j = 0; j < static_cast<int>(sweep.names.size()); ++j) {
        const std::string& key = sweep.names[static_cast<std::size_t>(j)];
        if (key == here || key.ends_with("." + here)) shared.emplace_back(k, j);
      }
    }
    const std::string& unit = sweep.units[static_cast<std::size_t>(energy)];
    study.x_name = name == energy_rate ? "E_i" : name, study.x_unit = unit.empty() ? "1" : unit;
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::size_t row = row_in(sweep, groups[k], shared);
      const double x = number_in(sweep, row, energy);
      if (!(x > 0)) sweep.refuse(row, energy, fmt::format("found {:g}; allowed are numbers above 0", x));
      study.points[k].x = x;
      study.points[k].log_x_variance = log_variance(sweep, row, name, x, [&](int of) { return number_in(sweep, row, of); });
    }
  }

  GrindingStudy read() {
    read_columns();
    group_rows();
    for (const Group& group : groups) {
      GrindingPoint point;
      point.label = group.label;
      for (const std::string& measure : study.measures) {
        point.limits.push_back(limit_of(group, measure));
        point.series.push_back(sieved() ? passing_sizes(group, measure) : sizes_of(group, measure));
        if (!point.series.back().times.empty()) check_series(group, point.series.back(), measure, point.limits.back());
      }
      study.points.push_back(std::move(point));
    }
    if (request.sweep.empty()) read_against();
    else read_sweep();
    return study;
  }
};

}  // namespace

GrindingStudy read_grinding(const GrindingRequest& given) {
  GrindingRequest request = given;
  if (request.sweep.empty() && std::filesystem::is_directory(request.file)) request.sweep = request.file;
  return Reader(request).read();
}

}  // namespace quern
