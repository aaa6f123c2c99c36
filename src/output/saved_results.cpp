#include "src/output/saved_results.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <toml++/toml.h>
#include "src/base/error.hpp"
#include "src/case/csv.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

std::string content_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Vec3 vector_in(const toml::node_view<toml::node>& view, const Vec3& otherwise) {
  const toml::array* list = view.as_array();
  if (list == nullptr || list->size() != 3) return otherwise;
  Vec3 out;
  for (std::size_t k = 0; k < 3; ++k) out[static_cast<Eigen::Index>(k)] = list->get(k)->value_or(0.0);
  return out;
}

SavedCase case_in(const std::string& file) {
  SavedCase out;
  out.text = content_of(file);
  try {
    toml::table all = toml::parse(out.text, file);
    out.name = all["name"].value_or(std::string());
    out.title = all["title"].value_or(std::string());
    out.duration = all["duration"].value_or(0.0);
    out.gravity = vector_in(all["gravity"], out.gravity);
    if (all["mill"].is_table()) out.axis = vector_in(all["mill"]["axis"], Vec3::UnitZ());
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: this is no complete case ({}).", file, error.source().begin.line, error.description()));
  }
  return out;
}

}  // namespace

std::vector<Headline> read_headlines(const std::string& file) {
  std::vector<Headline> out;
  const auto all = nlohmann::ordered_json::parse(content_of(file), nullptr, false);
  if (!all.is_object()) return out;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const auto number = [&](const nlohmann::ordered_json& value) { return value.is_number() ? value.get<double>() : unknown; };
  for (const auto& [key, entry] : all.items()) {
    if (!entry.is_object()) continue;
    Headline one{key, number(entry.value("value", nlohmann::ordered_json())), entry.value("unit", "1"), {}, entry.value("description", "")};
    if (entry.contains("ci95") && entry["ci95"].is_array() && entry["ci95"].size() == 2) one.ci95 = {number(entry["ci95"][0]), number(entry["ci95"][1])};
    out.push_back(std::move(one));
  }
  return out;
}

SavedRun read_run(const std::string& directory) {
  const std::string file = directory + "/case.toml", summary = directory + "/summary.json";
  if (!fs::is_directory(directory)) throw InputError(fmt::format("{}: there is no such directory; a report is made from one that `quern run`, `quern sweep` or `quern diagnose` wrote.", directory));
  if (!fs::exists(file)) throw InputError(fmt::format("{}: this directory holds no run (no case.toml), no sweep (no sweep.csv) and no diagnosis (no diagnosis.json).", directory));
  SavedRun run;
  run.of = case_in(file);
  // A run writes its case when it begins: what is older belongs to the one before.
  run.ended = fs::exists(summary) && fs::last_write_time(summary) >= fs::last_write_time(file);
  run.stopped = fs::exists(directory + "/checkpoint");
  if (!run.ended) return run;
  run.headlines = read_headlines(summary);
  for (const Headline& one : run.headlines)
    if (one.key == "simulated_time") run.time = one.value;
  return run;
}

std::optional<Table> read_table(const std::string& directory, const std::string& name) {
  const std::string file = directory + "/" + name + ".csv";
  if (!fs::exists(file)) return {};
  TextTable cells;
  try {
    cells = read_cells(file);
  } catch (const InputError&) {
    return {};  // a header alone
  }
  Table table{name, "", {}};
  for (std::size_t c = 0; c < cells.names.size(); ++c) {
    Column column{cells.names[c], cells.units[c].empty() ? "1" : cells.units[c], "", {}, {}};
    bool words = false;
    for (const auto& row : cells.rows) {
      const std::string& cell = row[c];
      double value = std::numeric_limits<double>::quiet_NaN();
      words |= !cell.empty() && std::from_chars(cell.data(), cell.data() + cell.size(), value).ptr != cell.data() + cell.size();
      column.values.push_back(value);
    }
    if (words) {
      column.values.clear();
      for (const auto& row : cells.rows) column.labels.push_back(row[c]);
    }
    table.columns.push_back(std::move(column));
  }
  return table;
}

}  // namespace quern
