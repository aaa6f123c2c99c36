#include "src/output/run_report.hpp"
#include <fmt/format.h>
#include <vtkBase64Utilities.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/output/angle_dial.hpp"
#include "src/output/page.hpp"
#include "src/output/pictures.hpp"
#include "src/output/report_scripts.hpp"
#include "src/output/saved_results.hpp"
#include "src/output/scene.hpp"
#include "src/output/svg_chart.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

std::string e(std::string_view text) { return escaped_html(text); }

const Headline* find(const std::vector<Headline>& all, std::string_view key) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Headline& one) { return one.key == key; });
  return found == all.end() ? nullptr : &*found;
}

std::string heading(const SavedRun& run, const std::string& frames_to) {
  const std::string title = run.of.title.empty() ? run.of.name : run.of.title;
  std::string text = fmt::format("<h1>{}</h1>\n", e(title));
  std::string line = "Case " + e(run.of.name);
  if (const Headline* count = find(run.headlines, "particle_count")) line += fmt::format(" · {:.0f} particles", count->value);
  if (run.ended) line += fmt::format(" · {:.4g} s simulated", run.time);
  if (const Headline* clock = find(run.headlines, "wall_clock")) line += fmt::format(" in {:.3g} s", clock->value);
  text += fmt::format("<p class=\"note\">{}</p>\n", line);
  if (!run.ended)
    text += fmt::format("<p class=\"warning\"><b>This run has not ended</b>: it still goes on, or was killed. {} Its tables and headline numbers come at its end{}.</p>\n", frames_to,
                        run.stopped ? "; if it was killed, <code>quern run … --resume</code> goes on from its last checkpoint" : "");
  else if (run.stopped)
    text += fmt::format("<p class=\"warning\"><b>This run was stopped</b> at {:.4g} of {:.4g} s; <code>quern run … --resume</code> goes on from there. What follows is what there was by then.</p>\n", run.time, run.of.duration);
  return text;
}

std::string cards(const std::vector<Headline>& headlines) {
  constexpr const char* first[] = {"power", "torque", "shoulder_angle", "toe_angle", "impact_energy_rate", "collision_rate", "mean_collision_energy", "damage_ratio", "largest_fragment_fraction", "fragment_count",
                                   "peak_force", "loading_stiffness", "discharge_rate", "energy_closure"};
  std::string text;
  for (const char* key : first) {
    const Headline* one = find(headlines, key);
    if (one == nullptr || !std::isfinite(one->value)) continue;
    text += fmt::format("<div title=\"{}\"><b>{}</b><span>{}</span></div>\n", e(one->description), e(spoken_with_unit(*one)), e(spoken_name(key)));
  }
  return text.empty() ? "" : fmt::format("<div class=\"cards\">\n{}</div>\n<p class=\"note\">± is half of the 95 % interval.</p>\n", text);
}

std::string all_numbers(const std::vector<Headline>& headlines) {
  if (headlines.empty()) return "";
  std::string rows;
  for (const Headline& one : headlines)
    rows += fmt::format("<tr><td><code>{}</code></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td></tr>\n", e(one.key), std::isfinite(one.value) ? spoken_value(one) : "–", spoken_interval(one), e(unit_symbol(one.unit)),
                        e(one.description));
  return fmt::format("<details><summary>All {} numbers of summary.json</summary><div class=\"wide\"><table class=\"sorts\"><thead><tr><th>number</th><th class=\"n\">value</th><th class=\"n\">95 % interval</th><th>unit</th><th>what it is</th></tr></thead><tbody>\n"
                     "{}</tbody></table></div></details>\n", headlines.size(), rows);
}

// A picture within the page.
std::string picture(const std::string& file, const std::string& alt) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (bytes.empty()) return "";
  std::string text(bytes.size() / 3 * 4 + 8, '\0');
  text.resize(vtkBase64Utilities::Encode(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), reinterpret_cast<unsigned char*>(text.data())));
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", e(alt), text);
}

// Obliquely onto the end of a mill; otherwise from the front and above.
SceneView view_of(const SavedCase& of) {
  const Vec3 up = of.gravity.norm() > 0 ? Vec3(-of.gravity.normalized()) : Vec3::UnitZ();
  Vec3 axis = of.axis.norm() > 0 ? of.axis.normalized() : -Vec3::UnitY().eval();
  if (axis.dot(up) < -0.5) axis = -axis;
  const Vec3 aside = std::abs(axis.dot(up)) > 0.9 ? Vec3::UnitX().cross(up).norm() > 0.1 ? Vec3(-Vec3::UnitY()) : Vec3(Vec3::UnitZ()) : up.cross(axis).normalized().eval();
  const bool standing = std::abs(axis.dot(up)) > 0.9;
  const Vec3 towards_viewer = standing ? Vec3(0.75 * axis + aside) : Vec3(axis + 0.45 * aside + 0.3 * up);
  return {-towards_viewer.normalized(), up};
}

struct ChargeShown {
  std::string html, frames_to;
  bool scene = false;
};

ChargeShown charge_of(const std::string& directory, const SavedRun& run, ReportWritten& written) {
  ChargeShown shown;
  std::optional<PackedScene> scene;
  try {
    scene = pack_scene(directory, view_of(run.of));
  } catch (const RunError& error) {
    written.remarks.push_back(std::string("The charge in 3-D is left out of the report: ") + error.what());
  }
  const std::string still = picture(directory + "/charge.png", "The charge at the end of the run");
  if (scene) shown.frames_to = fmt::format("Its frames reach to {:.4g} s.", scene->last_time);
  if (!scene && still.empty()) return shown;
  shown.html = "<h2>The charge</h2>\n<figure class=\"charge3d\">";
  if (!still.empty()) shown.html += fmt::format("<div class=\"still\">{}</div>", still);
  if (scene && !charge_script().empty()) {
    shown.scene = true;
    shown.html += data_of("scene", scene->description) + data_of("bytes", scene->bytes);
  }
  shown.html += "</figure>\n";
  if (shown.scene) {
    shown.html += fmt::format("<p class=\"note screen\">Drag to turn, with shift to move, wheel or two fingers to come nearer. {} frames from {:.4g} to {:.4g} s{}.</p>\n", scene->shown, scene->first_time, scene->last_time,
                              scene->shown < scene->saved ? fmt::format(", evenly chosen: {} of the {} saved are left out to keep this page small", scene->saved - scene->shown, scene->saved) : "");
  } else if (!scene) {
    shown.html += "<p class=\"note\">The run wrote no frames (<code>output.paraview = false</code>), so there is no charge in 3-D.</p>\n";
  } else {
    shown.html += "<p class=\"note\">This quern was built without npm (QUERN_REPORT): the charge does not turn here, and plots do not zoom. <code>frames.pvd</code> opens in ParaView.</p>\n";
  }
  return shown;
}

// Of the last row of the ledger: what went in, and where it is.
std::string ledger(const std::optional<Table>& energy) {
  if (!energy || energy->columns.size() < 2 || energy->columns.front().values.empty()) return "";
  const auto value = [&](std::string_view name, bool since_start = false) {
    for (const Column& column : energy->columns)
      if (column.name == name && !column.values.empty()) return column.values.back() - (since_start ? column.values.front() : 0);
    return 0.0;
  };
  std::string rows;
  const double in = value("wall_work") + value("field_work");
  const auto row = [&](const char* name, double joule, bool always = false) {
    if (joule == 0 && !always) return;
    rows += fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", name, fmt::format("{:.5g}", joule), in != 0 ? fmt::format("{:.2f} %", 100 * joule / in) : "");
  };
  row("work of the walls", value("wall_work"), true);
  row("work of fields other than gravity", value("field_work"));
  row("kinetic, since the start", value("kinetic", true), true);
  row("potential, since the start", value("potential", true), true);
  row("elastic, in contacts", value("elastic", true));
  row("elastic, in bonds", value("bond_energy", true));
  row("lost along the normal", value("normal_loss"));
  row("lost by sliding", value("sliding_loss"));
  row("lost by rolling", value("rolling_loss"));
  row("lost in bonds", value("bond_loss"));
  row("set free by bonds that failed", value("bond_failure"));
  row("missing", value("gap"), true);
  return fmt::format("<h2>Ledger of energy</h2>\n<div class=\"wide\"><table><tr><th>at t = {:.4g} s</th><th class=\"n\">J</th><th class=\"n\">of the work</th></tr>\n{}</table></div>\n", energy->columns.front().values.back(), rows);
}

std::string fragments(const std::optional<Table>& table) {
  if (!table || table->columns.empty()) return "";
  constexpr std::size_t most = 12;
  std::string head, rows;
  std::size_t count = 0;
  for (const Column& column : table->columns) {
    const bool words = !column.labels.empty();
    head += fmt::format("<th{}>{}{}</th>", words ? "" : " class=\"n\"", e(spoken_name(column.name)), column.unit == "1" ? "" : " [" + e(unit_symbol(column.unit)) + "]");
    count = std::max({count, column.labels.size(), column.values.size()});
  }
  for (std::size_t row = 0; row < std::min(count, most); ++row) {
    rows += "<tr>";
    for (const Column& column : table->columns) rows += column.labels.empty() ? fmt::format("<td class=\"n\">{:.4g}</td>", column.values[row]) : fmt::format("<td>{}</td>", e(column.labels[row]));
    rows += "</tr>\n";
  }
  return fmt::format("<h2>Fragments</h2>\n<div class=\"wide\"><table class=\"sorts\"><thead><tr>{}</tr></thead><tbody>\n{}</tbody></table></div>\n{}", head, rows,
                     count > most ? fmt::format("<p class=\"note\">{} more are in <a href=\"fragments.csv\">fragments.csv</a>.</p>\n", count - most) : "");
}

std::string spoken_size(std::uintmax_t bytes) { return bytes < 1'000'000 ? fmt::format("{:.0f} kB", std::ceil(static_cast<double>(bytes) / 1000)) : fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6); }

std::string files(const std::string& directory) {
  std::vector<std::string> items;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || name == "report.html" || name.starts_with("checkpoint") || name.ends_with(".journal") || name[0] == '.') continue;
    items.push_back(fmt::format("<li><a href=\"{0}\">{0}</a> <span class=\"note\">{1}</span></li>\n", e(name), spoken_size(entry.file_size())));
  }
  std::sort(items.begin(), items.end());
  std::string list;
  for (const std::string& item : items) list += item;
  return "<h2>Files beside this page</h2>\n<ul class=\"files\">\n" + list + "</ul>\n<p class=\"note\">Tables have their units in the header; results.h5 is H5MD; frames.pvd opens in ParaView.</p>\n";
}

// Tables that a report shows.
constexpr const char* shown_tables[] = {"spectra", "convergence", "power", "loading", "discharge", "energy", "damage", "fragment_sizes"};

}  // namespace

ReportWritten write_run_report(const std::string& directory, bool draw) {
  ReportWritten written;
  const SavedRun run = read_run(directory);
  std::vector<Table> tables;
  if (run.ended)
    for (const char* name : shown_tables)
      if (auto table = read_table(directory, name)) tables.push_back(std::move(*table));
  const std::vector<Chart> charts = charts_of(tables, run.headlines, "");
  const ChargeShown charge = charge_of(directory, run, written);

  std::string plots;
  for (const Chart& chart : charts) plots += figure_of(chart, chart.title);
  if (const std::string dial = angle_dial(run.headlines); !dial.empty())
    plots += fmt::format("<figure class=\"dial\"><figcaption>Angles of the charge</figcaption>{}<p class=\"note\">Drawn so that the mill turns anticlockwise; bands are 95 % intervals.</p></figure>\n", dial);
  std::string body = heading(run, charge.frames_to) + cards(run.headlines) + all_numbers(run.headlines) + charge.html;
  if (!plots.empty()) body += fmt::format("<h2>Plots</h2>\n<div class=\"plots\">\n{}</div>\n", plots);
  if (run.ended) body += fragments(read_table(directory, "fragments")) + ledger(read_table(directory, "energy"));
  body += fmt::format("<h2>The case</h2>\n<details><summary>The complete case as run, every default spelled out</summary><pre>{}</pre></details>\n", e(run.of.text));
  body += files(directory);
  const std::string title = run.of.title.empty() ? run.of.name : run.of.title;
  write_whole_file(directory + "/report.html", whole_page(title, body, charge.scene));
  written.files.push_back("report.html");
  if (!draw) return written;
  PictureRequest missing;
  missing.directory = directory;
  for (const Chart& chart : charts_of(tables, run.headlines, title))
    if (!fs::exists(directory + "/" + chart.file)) missing.charts.push_back(chart);
  const Drawn drawn = draw_pictures(missing);
  written.files.insert(written.files.end(), drawn.files.begin(), drawn.files.end());
  written.remarks.insert(written.remarks.end(), drawn.remarks.begin(), drawn.remarks.end());
  return written;
}

}  // namespace quern
