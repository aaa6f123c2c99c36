// The whole of a grinding study: kinetics at every operating point, and the rate against what was set.
#pragma once
#include <optional>
#include <string>
#include <vector>
#include "src/grinding/kinetics.hpp"
#include "src/grinding/power_law.hpp"

namespace quern {

struct GrindingPoint {
  std::string label;
  std::vector<SizeSeries> series;              // one for each measure; without times where it was not measured
  std::vector<std::optional<double>> limits;   // known D_∞, one for each measure
  std::optional<double> x;                     // what was set or computed, such as E_i
  double log_x_variance = 0;
};

struct GrindingStudy {
  std::vector<std::string> measures;  // "D80", "D50"
  std::string time_unit = "s", size_unit = "m";
  double shown_size = 1;              // of the unit that the sizes were given in, for people
  std::string shown_size_unit = "m";
  std::string x_name, x_unit;         // "" where the rate is held against nothing
  std::vector<GrindingPoint> points;
  std::vector<std::string> remarks;   // plain sentences
};

struct RateResult {
  std::size_t point = 0;  // of the study
  KineticsFit fit;
  bool limit_known = false;
  bool open = false;               // K_p may be none and any, by its interval
  std::optional<ShapeFit> shape;
  std::optional<double> held_out, held_out_shape;  // of sizes
};

struct MeasureResult {
  std::string measure;
  std::vector<RateResult> rates;
  std::optional<PowerLawFit> law;
};

struct GrindingResult {
  std::vector<MeasureResult> measures;
  std::vector<std::string> remarks;
};

// The errors of the sizes of one measure are taken to have the same standard deviation at every operating point where the law is
// concerned (that of single series is too uncertain for a weight), and their own in the interval of each rate.
GrindingResult study_grinding(const GrindingStudy& study);

}  // namespace quern
