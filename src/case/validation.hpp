// What the results of a case must meet: check.toml (docs/adding-a-case.md), the figures measured against it, result.json and the
// page made of them. Nothing here runs a simulation.
#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>
#include "src/case/grid.hpp"
#include "src/case/grinding_input.hpp"

namespace quern {

struct CheckRun {
  std::string name, file;         // file: of the case, with its folder
  std::vector<std::string> set;   // overrides
  std::vector<SweptKey> sweep;
  bool slow = false;
  std::optional<GrindingRequest> grinding = {};  // instead of a simulation: fits to measured sizes
};

// Which run of a sweep: key → value, as written.
using SweepPlace = std::map<std::string, std::string>;

struct HeadlineMeasure {
  std::string key;
};
// Over the runs of a sweep.
struct SweepMeasure {
  enum class Kind { peak_at, largest, smallest, mean, exponent, slope };
  Kind kind = Kind::largest;
  std::string of, over;
};
struct PairMeasure {
  bool ratio = true;  // otherwise the difference
  std::string of, of2, run;
  SweepPlace at;
};
struct TableMeasure {
  std::string file, column, over, pick, x;  // over: a column to divide by, or empty; pick: first, last, max, min, mean; or x and at
  double at = 0;
  SweepPlace where;
};

struct Figure {
  std::string name, run, unit, kind, note, where;  // where: "check.toml:12"
  SweepPlace at;
  std::variant<HeadlineMeasure, SweepMeasure, PairMeasure, TableMeasure> measure;
  double scale = 1, offset = 0;
  std::optional<double> reference;
  std::array<double, 2> band{};
  bool known_miss = false;
};

struct Check {
  std::string folder, name, source;
  std::vector<CheckRun> runs;
  std::vector<Figure> figures;

  const CheckRun& run(const std::string& run_name) const;
  bool slow(const Figure& figure) const;
};

// Reads FOLDER/check.toml. Throws InputError: file, line, key, what was found, what is allowed.
Check read_check(const std::string& folder);

// One finished run.
struct RunResult {
  SweepPlace place;       // the swept keys
  std::string directory;  // of summary.json and the tables
};
using RunResults = std::map<std::string, std::vector<RunResult>>;  // by the name of the run

struct Measured {
  double value = 0;  // as shown: scaled
  std::optional<std::array<double, 2>> ci95;
};

// What came out for a figure. Throws InputError where it is not there: no such headline, column or run.
Measured measure(const Figure& figure, const RunResults& results);

bool meets(const Figure& figure, const Measured& measured);

// The latest figures of a case by name, with the day and version that they come from.
struct RememberedFigure {
  Measured measured;
  std::string date, version;
};
using Memory = std::map<std::string, RememberedFigure>;

Memory read_memory(const std::string& folder);                     // FOLDER/result.json; empty where there is none
std::string memory_text(const Check& check, const Memory& memory);  // in the order of the check; figures no longer asked for are left out

// "pass", "MISS", "MISS (known)" or "not run".
std::string verdict(const Figure& figure, const Memory& memory);
std::string number_text(double value);
std::string ours_text(const Measured& measured);  // with its interval
std::string band_text(const std::array<double, 2>& band);

// The page of all cases, Markdown.
std::string validation_page(const std::vector<Check>& checks);

}  // namespace quern
