#include "src/cli/machine_runs.hpp"
#include <fmt/format.h>
#include <boost/crc.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include "src/base/error.hpp"
#include "src/base/say.hpp"
#include "src/case/csv.hpp"
#include "src/case/echo.hpp"
#include "src/cli/points.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

constexpr double of_interval = 2 * 1.96;  // width of a 95 % interval over the standard deviation

// rates of finished and enduring contacts by the energy that they dissipated.
void read_spectrum(const std::string& file, Outcome& outcome) {
  const TextTable table = read_cells(file);
  const auto column = [&](const char* name) { return table.find(name); };
  const int measure = column("measure"), pair = column("pair"), type = column("class"), from = column("energy_from"), to = column("energy_to"), count = column("count"), rate = column("rate");
  for (const int needed : {measure, pair, type, from, to, count, rate})
    if (needed < 0) return;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto word = [&](int c) { return table.rows[row][static_cast<std::size_t>(c)]; };
    if (word(measure) != "dissipated" || (word(type) != "collision" && word(type) != "enduring")) continue;
    const double seen = number_in(table, row, count), per_second = number_in(table, row, rate);
    outcome.bins.push_back({word(pair), number_in(table, row, from), number_in(table, row, to), per_second, seen > 0 ? per_second / std::sqrt(seen) : 0});
  }
}

Outcome outcome_of(const Point& point) {
  Outcome outcome;
  if (!point.finished) return outcome;
  const nlohmann::json summary = nlohmann::json::parse(content_of(point.directory + "/summary.json"), nullptr, false);
  if (!summary.is_object()) return outcome;
  for (const auto& [name, entry] : summary.items()) {
    if (!entry.is_object() || !entry.contains("value") || !entry["value"].is_number()) continue;
    Outcome::Number number{entry["value"].get<double>(), 0};
    if (entry.contains("ci95") && entry["ci95"].is_array() && entry["ci95"].size() == 2 && entry["ci95"][0].is_number() && entry["ci95"][1].is_number())
      number.deviation = (entry["ci95"][1].get<double>() - entry["ci95"][0].get<double>()) / of_interval;
    outcome.numbers[name] = number;
  }
  if (const std::string spectrum = point.directory + "/spectra.csv"; fs::exists(spectrum)) read_spectrum(spectrum, outcome);
  outcome.sound = true;
  return outcome;
}

std::string spoken_time(double seconds) { return seconds < 90 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60); }

}  // namespace

CaseRunner run_cases_in(const std::string& directory, int jobs, bool quiet) {
  // What the runs so far took, by which the next are judged.
  auto seconds_per_run = std::make_shared<double>(0);
  return [=](const std::vector<WantedRun>& wanted) {
    std::vector<Point> points;
    for (const WantedRun& one : wanted) {
      Point point;
      std::vector<NamedFile> files;
      point.text = echo_of(one.values, files);
      boost::crc_32_type crc;
      crc.process_bytes(point.text.data(), point.text.size());
      point.directory = (fs::path(directory) / fmt::format("{:08x}", crc.checksum())).string();
      fs::create_directories(point.directory);
      point.file = point.directory + "/wanted.toml";
      copy_files(files, point.directory);
      write_aside(point.file, point.text);
      point.label = one.label;
      points.push_back(point);
    }
    const std::size_t kept = keep_finished(points), fresh = points.size() - kept;
    if (fresh > 0 && !quiet)
      say(fmt::format("{} run{}{}{}\n", fresh, fresh > 1 ? "s" : "", kept > 0 ? fmt::format(" ({} are there already)", kept) : "",
                      *seconds_per_run > 0 ? ", about " + spoken_time(*seconds_per_run * static_cast<double>(fresh)) : ""), stdout);
    const auto begin = std::chrono::steady_clock::now();
    const int status = run_points(points, jobs, [] {});
    if (status >= 128) throw Stopped{status - 128};
    if (fresh > 0) *seconds_per_run = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / static_cast<double>(fresh);
    std::vector<Outcome> outcomes;
    for (const Point& point : points) outcomes.push_back(outcome_of(point));
    return outcomes;
  };
}

}  // namespace quern
