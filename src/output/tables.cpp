#include "src/output/tables.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

namespace quern {
namespace {

std::string quoted(const std::string& word) {
  if (word.find_first_of(",\"\r\n") == std::string::npos) return word;
  std::string out = "\"";
  for (const char c : word) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

std::size_t rows_of(const Column& column) { return std::max(column.values.size(), column.labels.size()); }

nlohmann::ordered_json number(double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr); }

}  // namespace

std::string header_of(const Column& column) {
  const bool bare = column.unit.empty() || column.unit == "1" || !column.labels.empty() || column.name.find(" [") != std::string::npos;
  return bare ? column.name : column.name + " [" + column.unit + "]";
}

std::string csv_of(const Table& table) {
  std::string out;
  std::size_t rows = 0;
  for (const Column& column : table.columns) {
    if (&column != &table.columns.front()) out += ',';
    out += quoted(header_of(column));
    rows = std::max(rows, rows_of(column));
  }
  out += '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    for (const Column& column : table.columns) {
      if (&column != &table.columns.front()) out += ',';
      if (row < column.labels.size()) {
        out += quoted(column.labels[row]);
      } else if (row < column.values.size() && std::isfinite(column.values[row])) {
        fmt::format_to(std::back_inserter(out), "{}", column.values[row]);
      }
    }
    out += '\n';
  }
  return out;
}

std::string json_of(const std::vector<Headline>& headlines) {
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (const Headline& headline : headlines) {
    nlohmann::ordered_json& one = all[headline.key];
    one = {{"value", number(headline.value)}, {"unit", headline.unit}};
    if (headline.ci95) one["ci95"] = {number((*headline.ci95)[0]), number((*headline.ci95)[1])};
    if (!headline.description.empty()) one["description"] = headline.description;
  }
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace quern
