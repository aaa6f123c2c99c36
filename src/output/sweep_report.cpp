#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/output/page.hpp"
#include "src/output/pictures.hpp"
#include "src/output/run_report.hpp"
#include "src/output/saved_results.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

std::string e(std::string_view text) { return escaped_html(text); }

const Column* find(const Table& table, const std::string& name) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(), [&](const Column& column) { return column.name == name; });
  return found == table.columns.end() ? nullptr : &*found;
}

std::string cell(const Column& column, std::size_t row) { return column.labels.empty() ? fmt::format("{:.6g}", column.values[row]) : column.labels[row]; }

// Which columns were set, which are numbers that came out.
struct Sweep {
  Table table;
  std::size_t rows = 0;
  std::vector<const Column*> set, found;
  const Column* directory = nullptr;
};

Sweep read_sweep(const std::string& directory) {
  Sweep sweep;
  if (auto table = read_table(directory, "sweep")) sweep.table = std::move(*table);
  else throw InputError(fmt::format("{}/sweep.csv: no run of this sweep has finished yet.", directory));
  sweep.directory = find(sweep.table, "directory");
  if (sweep.directory == nullptr || sweep.directory->labels.empty()) throw InputError(fmt::format("{}/sweep.csv: the column \"directory\" is missing; this is no table of `quern sweep`.", directory));
  sweep.rows = sweep.directory->labels.size();
  std::set<std::string> known;
  for (const std::string& run : sweep.directory->labels)
    for (const Headline& one : read_headlines(directory + "/" + run + "/summary.json")) known.insert(one.key);
  for (const Column& column : sweep.table.columns) {
    const bool end = (column.name.ends_with("_from") && known.count(column.name.substr(0, column.name.size() - 5))) || (column.name.ends_with("_to") && known.count(column.name.substr(0, column.name.size() - 3)));
    if (&column == sweep.directory || (end && !known.count(column.name))) continue;
    (known.count(column.name) ? sweep.found : sweep.set).push_back(&column);
  }
  return sweep;
}

bool varies(const Column& column) {
  std::set<std::string> seen;
  for (std::size_t row = 0; row < std::max(column.values.size(), column.labels.size()); ++row) seen.insert(cell(column, row));
  return seen.size() > 1;
}

// A headline number against a key; a curve for each combination of the others.
Chart chart_of(const Sweep& sweep, const Column& key, const Column& number) {
  Panel panel{key.name + (key.unit == "1" ? "" : " [" + key.unit + "]"), spoken_name(number.name) + (number.unit == "1" ? "" : " [" + unit_symbol(number.unit) + "]"), false, false, {}};
  const Column *from = find(sweep.table, number.name + "_from"), *to = find(sweep.table, number.name + "_to");
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t row = 0; row < sweep.rows; ++row) {
    std::string label;
    for (const Column* other : sweep.set)
      if (other != &key && varies(*other)) label += (label.empty() ? "" : ", ") + fmt::format("{} {}", spoken_name(other->name.substr(other->name.rfind('.') + 1)), cell(*other, row));
    if (std::isfinite(number.values[row])) groups[label].push_back(row);
  }
  for (auto& [label, rows] : groups) {
    std::sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return key.values[a] < key.values[b]; });
    Curve curve{label.empty() && groups.size() == 1 ? spoken_name(number.name) : label, {}, {}, {}, {}, true};
    for (const std::size_t row : rows) {
      curve.x.push_back(key.values[row]), curve.y.push_back(number.values[row]);
      if (!from || !to) continue;
      const bool known = std::isfinite(from->values[row]) && std::isfinite(to->values[row]);
      curve.lower.push_back(known ? from->values[row] : number.values[row]), curve.upper.push_back(known ? to->values[row] : number.values[row]);
    }
    panel.curves.push_back(std::move(curve));
  }
  return {"", number.name, {panel}};
}

std::string table_of(const Sweep& sweep, const std::string& directory) {
  std::string head = "<th>run</th>", rows;
  const auto column_head = [&](const Column& column) { return fmt::format("<th class=\"n\">{}{}</th>", e(spoken_name(column.name)), column.unit == "1" ? "" : "<br>[" + e(unit_symbol(column.unit)) + "]"); };
  for (const Column* column : sweep.set) head += column_head(*column);
  for (const Column* column : sweep.found) head += column_head(*column);
  for (std::size_t row = 0; row < sweep.rows; ++row) {
    const std::string& run = sweep.directory->labels[row];
    const bool page = fs::exists(directory + "/" + run + "/report.html");
    rows += fmt::format("<tr><td data-value=\"{}\"><a href=\"{}/{}\">{}</a></td>", row + 1, e(run), page ? "report.html" : "", row + 1);
    for (const Column* column : sweep.set) rows += fmt::format("<td class=\"n\">{}</td>", e(cell(*column, row)));
    for (const Column* column : sweep.found) {
      const Column *from = find(sweep.table, column->name + "_from"), *to = find(sweep.table, column->name + "_to");
      Headline one{column->name, column->values[row], column->unit, {}, ""};
      if (from && to && std::isfinite(from->values[row]) && std::isfinite(to->values[row])) one.ci95 = {from->values[row], to->values[row]};
      rows += std::isfinite(one.value) ? fmt::format("<td class=\"n\" data-value=\"{}\">{}</td>", one.value, spoken_value(one)) : "<td class=\"n\" data-value=\"\">–</td>";
    }
    rows += "</tr>\n";
  }
  return fmt::format("<h2>All runs</h2>\n<p class=\"note\">A column's name sorts by it, once more the other way round. ± is half of the 95 % interval. The same is in <a href=\"sweep.csv\">sweep.csv</a>.</p>\n"
                     "<div class=\"wide\"><table class=\"sorts\"><thead><tr>{}</tr></thead><tbody>\n{}</tbody></table></div>\n", head, rows);
}

// Of interest to whoever tends the program, not the mill.
bool of_the_program(const std::string& name) {
  static const std::set<std::string> all = {"wall_clock", "particle_steps_per_second", "time_step", "simulated_time", "sampled_time", "steady_from"};
  return all.count(name) > 0;
}

bool comes_first(const std::string& name) {
  static const std::set<std::string> all = {"power", "torque", "shoulder_angle", "toe_angle", "impact_energy_rate", "collision_rate", "mean_collision_energy", "damage_ratio", "largest_fragment_fraction", "fragment_count", "peak_force",
                                            "discharge_rate"};
  return all.count(name) > 0;
}

}  // namespace

ReportWritten write_sweep_report(const std::string& directory) {
  const Sweep sweep = read_sweep(directory);
  ReportWritten written;
  // Few runs have pages of their own.
  constexpr std::size_t few = 24;
  if (sweep.rows <= few)
    for (const std::string& run : sweep.directory->labels) {
      try {
        const ReportWritten one = write_run_report(directory + "/" + run);
        written.remarks.insert(written.remarks.end(), one.remarks.begin(), one.remarks.end());
      } catch (const InputError& error) {
        written.remarks.push_back(error.what());
      }
    }
  std::string title = fs::path(directory).lexically_normal().filename().string();
  if (title.empty()) title = fs::path(directory).lexically_normal().parent_path().filename().string();
  try {
    const SavedCase first = read_run(directory + "/" + sweep.directory->labels.front()).of;
    title = first.title.empty() ? first.name : first.title;
  } catch (const InputError&) {
    // The folder's name will do.
  }

  std::string body = fmt::format("<h1>{}</h1>\n<p class=\"note\">A sweep of {} runs{}</p>\n", e(title), sweep.rows, sweep.set.empty() ? "." : " over:");
  std::string keys;
  for (const Column* key : sweep.set) {
    std::vector<std::string> values;
    for (std::size_t row = 0; row < sweep.rows; ++row)
      if (const std::string value = cell(*key, row); std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    keys += fmt::format("<li><code>{}</code>: {}{}</li>\n", e(key->name), e(fmt::format("{}", fmt::join(values, ", "))), key->unit == "1" ? "" : " " + e(unit_symbol(key->unit)));
  }
  if (!keys.empty()) body += "<ul>\n" + keys + "</ul>\n";
  std::vector<Chart> pictures;
  for (const Column* key : sweep.set) {
    if (!key->labels.empty() || !varies(*key)) continue;
    std::string first, further;
    std::size_t count = 0;
    for (const Column* number : sweep.found) {
      if (!number->labels.empty() || !varies(*number) || of_the_program(number->name)) continue;
      const Chart chart = chart_of(sweep, *key, *number);
      if (chart.panels.front().curves.empty()) continue;
      if (comes_first(number->name)) {
        first += figure_of(chart, spoken_name(number->name));
        pictures.push_back({fmt::format("sweep_{}_{}.png", key->name.substr(key->name.rfind('.') + 1), number->name), spoken_name(number->name) + " · " + title, chart.panels});
      } else {
        further += figure_of(chart, spoken_name(number->name)), ++count;
      }
    }
    if (first.empty() && further.empty()) continue;
    body += fmt::format("<h2>Against <code>{}</code></h2>\n", e(key->name));
    if (!first.empty()) body += fmt::format("<div class=\"plots\">\n{}</div>\n", first);
    if (!further.empty()) body += fmt::format("<details{}><summary>{} further numbers</summary><div class=\"plots\">\n{}</div></details>\n", first.empty() ? " open" : "", count, further);
  }
  body += table_of(sweep, directory);
  write_whole_file(directory + "/report.html", whole_page(title, body, false));
  written.files.push_back("report.html");
  if (!pictures.empty()) {
    PictureRequest request;
    request.directory = directory;
    request.charts = pictures;
    const Drawn drawn = draw_pictures(request);
    written.files.insert(written.files.end(), drawn.files.begin(), drawn.files.end());
    written.remarks.insert(written.remarks.end(), drawn.remarks.begin(), drawn.remarks.end());
  }
  return written;
}

}  // namespace quern
