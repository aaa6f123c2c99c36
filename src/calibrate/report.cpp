// What a calibration of bonds says: tables, headline numbers, keys, words.
#include <fmt/format.h>
#include <cmath>
#include <functional>
#include <limits>
#include "src/calibrate/bonds.hpp"

namespace quern {
namespace {

constexpr double unbreakable = 1e300;
const double unknown = std::numeric_limits<double>::quiet_NaN();

double mean_or_none(const std::optional<Scatter>& s) { return s ? s->mean : unknown; }
double deviation_or_none(const std::optional<Scatter>& s) { return s ? s->deviation : unknown; }

std::string table_name(const BondCase& bond) { return bond.a == "default" ? "bond.default" : "bond." + bond.a + "." + bond.b; }

double ratio_of(const BondMaterial& m) { return m.young > 0 ? m.young / m.shear_modulus : m.normal_stiffness / m.shear_stiffness; }

}  // namespace

std::vector<Table> calibration_tables(const BondCalibration& calibration) {
  const auto column = [](const char* name, const char* unit, const char* meaning) { return Column{name, unit, meaning, {}, {}}; };
  Table trials{"bond_trials", "specimens that were measured on the way, means over those of one trial", {}};
  Column kind = column("kind", "1", "what was measured"), young_factor = column("young_factor", "1", "of the bonds' stiffness against the case"),
         ratio = column("stiffness_ratio", "1", "of the bonds; empty: as in the case"), tensile_factor = column("tensile_factor", "1", "of the bonds' tensile strength"),
         shear_factor = column("shear_factor", "1", "of the bonds' shear strength"), young = column("young", "Pa", "of the specimen"),
         poisson = column("poisson", "1", "of the specimen"), stress = column("strength", "Pa", "of the specimen"),
         still = column("kinetic_over_bond_energy", "1", "greatest, up to the peak");
  for (const BondTrial& trial : calibration.trials) {
    const bool elastic = trial.kind == "elasticity";
    kind.labels.push_back(trial.kind);
    young_factor.values.push_back(trial.scale.young);
    ratio.values.push_back(trial.scale.stiffness_ratio.value_or(unknown));
    tensile_factor.values.push_back(trial.scale.tensile);
    shear_factor.values.push_back(trial.scale.shear);
    young.values.push_back(elastic ? trial.figures.young.mean : unknown);
    poisson.values.push_back(elastic ? trial.figures.poisson.mean : unknown);
    stress.values.push_back(trial.kind == "tension" ? mean_or_none(trial.figures.tensile) : mean_or_none(trial.figures.compressive));
    still.values.push_back(elastic ? unknown : trial.figures.kinetic_share);
  }
  trials.columns = {kind, young_factor, ratio, tensile_factor, shear_factor, young, poisson, stress, still};

  Table sizes{"size_effect", "the same bonds in specimens of other sizes: mean and standard deviation over specimens", {}};
  const auto add = [&](const char* name, const char* unit, const std::function<double(const SpecimenFigures&)>& value) {
    Column c = column(name, unit, "of the specimens");
    for (const SpecimenFigures& figures : calibration.sizes) c.values.push_back(value(figures));
    sizes.columns.push_back(c);
  };
  add("grains", "1", [](const SpecimenFigures& f) { return static_cast<double>(f.grains); });
  add("diameter", "m", [](const SpecimenFigures& f) { return f.diameter; });
  add("solid_fraction", "1", [](const SpecimenFigures& f) { return f.solid_fraction; });
  add("young", "Pa", [](const SpecimenFigures& f) { return f.young.mean; });
  add("young_sd", "Pa", [](const SpecimenFigures& f) { return f.young.deviation; });
  add("poisson", "1", [](const SpecimenFigures& f) { return f.poisson.mean; });
  add("poisson_sd", "1", [](const SpecimenFigures& f) { return f.poisson.deviation; });
  add("tensile_strength", "Pa", [](const SpecimenFigures& f) { return mean_or_none(f.tensile); });
  add("tensile_strength_sd", "Pa", [](const SpecimenFigures& f) { return deviation_or_none(f.tensile); });
  add("compressive_strength", "Pa", [](const SpecimenFigures& f) { return mean_or_none(f.compressive); });
  add("compressive_strength_sd", "Pa", [](const SpecimenFigures& f) { return deviation_or_none(f.compressive); });
  return {trials, sizes};
}

std::vector<Headline> calibration_headlines(const BondCalibration& calibration, const BondTargets& targets) {
  std::vector<Headline> lines;
  const auto add = [&](const char* key, const Scatter& reached, const char* unit, std::optional<double> target, const char* meaning) {
    lines.push_back({key, reached.mean, unit, std::nullopt, meaning});
    if (target) lines.push_back({std::string(key) + "_residual", reached.mean / *target - 1, "1", std::nullopt, "reached over asked for, less one"});
  };
  const SpecimenFigures& r = calibration.reached;
  add("young", r.young, "Pa", targets.young, "Young's modulus of the specimens, mean");
  add("poisson", r.poisson, "1", targets.poisson, "Poisson's ratio of the specimens, mean");
  if (r.tensile) add("tensile_strength", *r.tensile, "Pa", targets.tensile, "of the specimens in direct tension, mean");
  if (r.compressive) add("compressive_strength", *r.compressive, "Pa", targets.compressive, "of the specimens in uniaxial compression, mean");
  if (r.tensile || r.compressive) lines.push_back({"kinetic_over_bond_energy", r.kinetic_share, "1", std::nullopt, "greatest, up to the peak stress"});
  return lines;
}

std::string bond_tables(const BondCalibration& calibration) {
  std::string text;
  for (const BondCase& bond : calibration.bonds) {
    const BondMaterial& m = bond.material;
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", table_name(bond));
    if (m.young > 0) text += fmt::format("young = {:.5g}\n", m.young);
    else text += fmt::format("normal_stiffness = {:.5g}\n", m.normal_stiffness);
    text += fmt::format("stiffness_ratio = {:.5g}\n", ratio_of(m));
    if (m.strength.tensile < unbreakable) text += fmt::format("tensile_strength = {:.5g}\n", m.strength.tensile);
    if (m.strength.shear < unbreakable) text += fmt::format("shear_strength = {:.5g}\n", m.strength.shear);
  }
  return text;
}

std::vector<std::string> calibration_words(const BondCalibration& calibration, const BondTargets& targets) {
  std::vector<std::string> words;
  const auto add = [&](const char* name, const Scatter& reached, double unit, const char* unit_name, std::optional<double> target) {
    words.push_back(fmt::format("{:<22}{:>10.4g}{} ± {:.2g} from specimen to specimen{}", name, reached.mean / unit, unit_name, reached.deviation / unit,
                                target ? fmt::format(", asked for {:.4g}, {:+.2f} %", *target / unit, 100 * (reached.mean / *target - 1)) : ""));
  };
  const SpecimenFigures& r = calibration.reached;
  words.push_back(fmt::format("Specimens of {} grains, {:.3g} mm across, {} trials", r.grains, 1e3 * r.diameter, calibration.trials.size()));
  add("Young's modulus", r.young, 1e9, " GPa", targets.young);
  add("Poisson's ratio", r.poisson, 1, "", targets.poisson);
  if (r.tensile) add("tensile strength", *r.tensile, 1e6, " MPa", targets.tensile);
  if (r.compressive) add("compressive strength", *r.compressive, 1e6, " MPa", targets.compressive);
  for (const SpecimenFigures& size : calibration.sizes) {
    std::string line = fmt::format("at {:>5} grains: E {:.4g} ± {:.2g} GPa, ν {:.3f} ± {:.3f}", size.grains, 1e-9 * size.young.mean, 1e-9 * size.young.deviation,
                                   size.poisson.mean, size.poisson.deviation);
    if (size.tensile) line += fmt::format(", tension {:.3g} ± {:.2g} MPa", 1e-6 * size.tensile->mean, 1e-6 * size.tensile->deviation);
    if (size.compressive) line += fmt::format(", compression {:.3g} ± {:.2g} MPa", 1e-6 * size.compressive->mean, 1e-6 * size.compressive->deviation);
    words.push_back(line);
  }
  return words;
}

}  // namespace quern
