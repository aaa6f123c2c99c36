#include "src/case/breakage_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include "src/base/error.hpp"
#include "src/base/units.hpp"
#include "src/case/csv.hpp"

namespace quern {
namespace {

namespace fs = std::filesystem;

std::string file_of(const std::string& source) { return fs::is_directory(source) ? (fs::path(source) / "sweep.csv").string() : source; }

struct Reader {
  const BreakageRequest& request;
  TextTable table;

  explicit Reader(const BreakageRequest& r) : request(r), table(read_cells(file_of(r.source))) {}

  [[noreturn]] void refuse_file(const std::string& what) const { throw InputError(fmt::format("{}:{}: {}.", table.file, table.header_line, what)); }

  const std::string& cell(std::size_t row, int column) const { return table.rows[row][static_cast<std::size_t>(column)]; }
  const std::string& name_of(int column) const { return table.names[static_cast<std::size_t>(column)]; }

  // What says how hard bodies were hit.
  int energy_column() const {
    if (!request.against.empty()) {
      const int column = table.find(request.against);
      if (column < 0) throw InputError(fmt::format("--against {}: {} has no such column; there are {}.", request.against, table.file, fmt::join(table.names, ", ")));
      return column;
    }
    for (const char* name : {"specific_energy", "speed"})
      if (const int column = table.find(name); column >= 0) return column;
    std::vector<int> found;
    for (int k = 0; k < static_cast<int>(table.names.size()); ++k)
      if (name_of(k).starts_with("insert.") && (name_of(k).ends_with(".speed") || name_of(k).ends_with(".velocity"))) found.push_back(k);
    if (found.size() == 1) return found[0];
    if (found.empty()) refuse_file("no column says how hard bodies were hit; needed is `specific_energy [J/kg]`, `speed [m/s]`, or a sweep over insert.<name>.speed");
    refuse_file(fmt::format("both {} and {} may be the speed of the bodies; --against says which", name_of(found[0]), name_of(found[1])));
  }

  // "[0, 0, -7.7]", each a number or with its unit.
  double length_of_vector(std::size_t row, int column) const {
    std::string text = cell(row, column);
    std::erase_if(text, [](char c) { return c == '[' || c == ']' || c == '"'; });
    std::istringstream parts(text);
    double squares = 0;
    int count = 0;
    for (std::string part; std::getline(parts, part, ','); ++count) {
      try {
        squares += std::pow(Units().read(part.substr(std::min(part.find_first_not_of(' '), part.size())), "m/s"), 2);
      } catch (const InputError&) {
        count = 99;
      }
    }
    if (count != 3) table.refuse(row, column, fmt::format("found {}; allowed are velocities [x, y, z]", cell(row, column)));
    return std::sqrt(squares);
  }

  double energy_at(std::size_t row, int column) const {
    if (cell(row, column).starts_with('[')) return 0.5 * std::pow(length_of_vector(row, column), 2);
    if (table.units[static_cast<std::size_t>(column)].empty()) refuse_file(fmt::format("column {} has no unit; write `speed [m/s]` or `specific_energy [J/kg]`", name_of(column)));
    const UnitFactor unit = unit_of(table, column, {"m/s", "J/kg"});
    const double value = number_in(table, row, column) * unit.factor;
    if (!(value > 0)) table.refuse(row, column, fmt::format("found {}; allowed are numbers above 0", cell(row, column)));
    return unit.si == "J/kg" ? value : 0.5 * value * value;
  }

  // Where a cell is empty nothing was measured.
  std::optional<double> fraction(std::size_t row, int column) const {
    if (column < 0 || cell(row, column).empty()) return std::nullopt;
    const double value = number_in(table, row, column) * unit_of(table, column, {"1"}).factor;
    if (!(value >= 0 && value <= 1)) table.refuse(row, column, fmt::format("found {}; allowed are fractions from 0 to 1", cell(row, column)));
    return value;
  }

  int whole(std::size_t row, int column, int least, int most) const {
    const double value = number_in(table, row, column);
    if (!(value >= least && value <= most) || value != std::floor(value))
      table.refuse(row, column, fmt::format("found {}; allowed are whole numbers from {} to {}", cell(row, column), least, most));
    return static_cast<int>(value);
  }

  // What else was swept must be the same for all: one study holds one kind of body. Swept keys have dots in their names, results none.
  void check_one_kind(int energy) const {
    for (int k = 0; k < static_cast<int>(table.names.size()); ++k) {
      if (k == energy || name_of(k).find('.') == std::string::npos) continue;
      for (std::size_t row = 1; row < table.rows.size(); ++row)
        if (cell(row, k) != cell(0, k)) table.refuse(row, k, fmt::format("found {} where line {} has {}; a study holds one kind of body, of which only the speed and the seed vary", cell(row, k), table.lines[0], cell(0, k)));
    }
  }

  BreakageStudy read() const {
    for (const std::string& name : table.names)
      if (std::count(table.names.begin(), table.names.end(), name) > 1) refuse_file(fmt::format("two columns are called {}", name));
    BreakageStudy study;
    study.broken_below = request.broken_below;
    if (!(study.broken_below > 0 && study.broken_below <= 1)) throw InputError(fmt::format("--broken {:g}: allowed is a part of the mass above 0 and at most 1.", study.broken_below));
    if (!request.size.empty()) {
      try {
        study.size = Units().read(request.size, "m");
      } catch (const InputError& e) {
        throw InputError(fmt::format("--size {}: {}.", request.size, e.what()));
      }
      if (!(*study.size > 0)) throw InputError(fmt::format("--size {}: allowed is a size above 0.", request.size));
    }
    const int energy = energy_column(), damage = table.find("damage_ratio"), largest = table.find("largest_fragment_fraction"), t10 = table.find("t10"), broken = table.find("broken"),
              tested = table.find("tested"), bodies = table.find("body_count");
    if (damage < 0 && largest < 0 && t10 < 0 && broken < 0)
      refuse_file("none of the columns damage_ratio, largest_fragment_fraction, broken and t10 is there; a sweep of cases with bonds has them");
    if (tested >= 0 && broken < 0) refuse_file("beside `tested` the column `broken` is needed");
    check_one_kind(energy);
    int crowded = 0;
    constexpr int many = 1000000000;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      BreakageRun run;
      run.energy = energy_at(row, energy);
      run.damage = fraction(row, damage), run.t10 = fraction(row, t10);
      if (broken >= 0) {
        run.tested = tested >= 0 ? whole(row, tested, 1, many) : 1;
        run.broken = whole(row, broken, 0, run.tested);
      } else if (const std::optional<double> part = fraction(row, largest)) {
        const bool alone = bodies < 0 || cell(row, bodies).empty() || number_in(table, row, bodies) == 1;
        if (alone) run.tested = 1, run.broken = *part < study.broken_below;
        else ++crowded;
      }
      study.runs.push_back(run);
    }
    if (crowded > 0) study.remarks.push_back(fmt::format("{} of {} runs have several bodies, whose largest fragments are not known one by one: out of the probability of breakage.", crowded, study.runs.size()));
    return study;
  }
};

}  // namespace

BreakageStudy read_breakage(const BreakageRequest& request) { return Reader(request).read(); }

}  // namespace quern
