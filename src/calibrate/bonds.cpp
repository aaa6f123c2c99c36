#include "src/calibrate/bonds.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/base/threads.hpp"

namespace quern {
namespace {

constexpr double least_ratio = 1, most_ratio = 100;  // of the key stiffness_ratio
constexpr double unbreakable = 1e300;

Scatter scatter_of(const std::vector<double>& values) {
  Scatter s;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) s.mean += v / n;
  for (const double v : values) s.deviation += (v - s.mean) * (v - s.mean);
  s.deviation = values.size() > 1 ? std::sqrt(s.deviation / (n - 1)) : 0;
  return s;
}

class Bench {
 public:
  Bench(const Case& c, const BondRequest& request, std::int64_t grains, ThreadTeam& team) : team_(team), specimens_(static_cast<std::size_t>(request.specimens)) {
    team_.run(static_cast<int>(specimens_.size()),
              [&](int k) { specimens_[static_cast<std::size_t>(k)] = make_specimen(c, request.agglomerate, grains, c.seed + static_cast<std::uint64_t>(k)); });
  }

  SpecimenFigures elasticity(const BondScale& scale) {
    SpecimenFigures figures = blank();
    std::vector<Elasticity> all(specimens_.size());
    team_.run(static_cast<int>(all.size()), [&](int k) { all[static_cast<std::size_t>(k)] = measure_elasticity(specimens_[static_cast<std::size_t>(k)], scale); });
    std::vector<double> young, poisson;
    for (const Elasticity& one : all) young.push_back(one.young), poisson.push_back(one.poisson);
    figures.young = scatter_of(young), figures.poisson = scatter_of(poisson);
    return figures;
  }

  SpecimenFigures strength(const BondScale& scale, Pull pull) {
    SpecimenFigures figures = blank();
    std::vector<Strength> all(specimens_.size());
    team_.run(static_cast<int>(all.size()), [&](int k) { all[static_cast<std::size_t>(k)] = measure_strength(specimens_[static_cast<std::size_t>(k)], scale, pull); });
    std::vector<double> stress;
    for (const Strength& one : all) {
      stress.push_back(one.stress);
      figures.kinetic_share = std::max(figures.kinetic_share, one.kinetic_share);
      figures.all_failed &= one.failed;
    }
    (pull == Pull::tension ? figures.tensile : figures.compressive) = scatter_of(stress);
    return figures;
  }

 private:
  SpecimenFigures blank() const {
    SpecimenFigures figures;
    for (const Specimen& one : specimens_) {
      figures.grains += one.grains;
      figures.solid_fraction += one.solid_fraction / static_cast<double>(specimens_.size());
    }
    figures.grains /= static_cast<std::int64_t>(specimens_.size());
    figures.diameter = 0.5 * specimens_.front().length;
    return figures;
  }

  ThreadTeam& team_;
  std::vector<Specimen> specimens_;
};

class Search {
 public:
  Search(const BondTargets& targets, Bench& bench, BondCalibration& out) : targets_(targets), bench_(bench), out_(out) {}

  void stiffness() {
    SpecimenFigures now = elastic();
    if (targets_.poisson) now = ratio();
    for (int k = 0; k < 4 && std::abs(now.young.mean / targets_.young - 1) > 0.002; ++k) {
      out_.scale.young *= targets_.young / now.young.mean;
      now = elastic();
    }
    out_.reached = now;
  }

  void strengths() {
    const Pull first = targets_.tensile ? Pull::tension : Pull::compression;
    if (!targets_.tensile && !targets_.compressive) return;
    fit(first);
    if (!targets_.tensile || !targets_.compressive) return;
    // Compression against tension: by the ratio of the bonds' shear strength to their tensile strength.
    double low = 0, low_value = 0, high = 0, high_value = 0;
    const double wanted = std::log(*targets_.compressive / *targets_.tensile);
    for (int k = 0; k < 6; ++k) {
      const double value = std::log(strength(Pull::compression).mean / out_.reached.tensile->mean), at = std::log(out_.scale.shear / out_.scale.tensile);
      if (std::abs(value - wanted) < 0.03) return;
      if (value < wanted) low = at, low_value = value;
      else high = at, high_value = value;
      const bool both = low_value != 0 && high_value != 0;
      double next = both ? low + (high - low) * std::clamp((wanted - low_value) / (high_value - low_value), 0.1, 0.9) : at + std::clamp(2 * (wanted - value), -1.0, 1.0);
      if (k == 5) next = at;
      out_.scale.shear = out_.scale.tensile * std::exp(next);
      if (k < 5) fit(Pull::tension);
    }
    out_.remarks.push_back(fmt::format("The compressive strength was not reached: with this packing it came to {:.3g} times the tensile strength, {:.3g} were asked for.",
                                       out_.reached.compressive->mean / out_.reached.tensile->mean, std::exp(wanted)));
  }

 private:
  SpecimenFigures elastic() {
    out_.trials.push_back({"elasticity", out_.scale, bench_.elasticity(out_.scale)});
    return out_.trials.back().figures;
  }

  // The stiffness ratio at which Poisson's ratio is as asked, with the modulus near to it all along.
  SpecimenFigures ratio() {
    const double wanted = *targets_.poisson;
    const auto at = [&](double r) {
      out_.scale.stiffness_ratio = r;
      const SpecimenFigures figures = elastic();
      out_.scale.young *= targets_.young / figures.young.mean;
      return figures;
    };
    double low = least_ratio, high = most_ratio;
    const SpecimenFigures lowest = at(low);
    double below = lowest.poisson.mean - wanted;
    const SpecimenFigures highest = at(high);
    double above = highest.poisson.mean - wanted;
    if (below > 0 || above < 0) {
      out_.remarks.push_back(fmt::format("Poisson's ratio of {:.3g} cannot be reached by this packing: it has {:.3f} at a stiffness ratio of {:g} and {:.3f} at {:g}; the nearest is taken.",
                                         wanted, lowest.poisson.mean, least_ratio, highest.poisson.mean, most_ratio));
      return at(below > 0 ? least_ratio : most_ratio);
    }
    SpecimenFigures figures = highest;
    int same = 0;
    for (int k = 0; k < 8; ++k) {
      const double share = std::clamp(-below / (above - below), 0.02, 0.98);
      const double r = std::exp(std::log(low) + share * (std::log(high) - std::log(low)));
      figures = at(r);
      const double miss = figures.poisson.mean - wanted;
      if (std::abs(miss) < 0.001) break;
      // The end that stays twice counts half (Illinois).
      if (miss < 0) {
        low = r, below = miss;
        if (same == -1) above *= 0.5;
        same = -1;
      } else {
        high = r, above = miss;
        if (same == 1) below *= 0.5;
        same = 1;
      }
    }
    return figures;
  }

  Scatter strength(Pull pull) {
    const SpecimenFigures figures = bench_.strength(out_.scale, pull);
    out_.trials.push_back({pull == Pull::tension ? "tension" : "compression", out_.scale, figures});
    out_.reached.kinetic_share = figures.kinetic_share;
    out_.reached.all_failed = figures.all_failed;
    if (pull == Pull::tension) return *(out_.reached.tensile = figures.tensile);
    return *(out_.reached.compressive = figures.compressive);
  }

  // Both strengths of the bonds by one factor.
  void fit(Pull pull) {
    const double wanted = pull == Pull::tension ? *targets_.tensile : *targets_.compressive;
    for (int k = 0; k < 4; ++k) {
      const double factor = wanted / strength(pull).mean;
      if (std::abs(factor - 1) < 0.01) return;
      if (k == 3) break;
      out_.scale.tensile *= factor, out_.scale.shear *= factor;
    }
    out_.remarks.push_back(fmt::format("The {} strength is within {:.1f} % of what was asked for, not within 1 %.", pull == Pull::tension ? "tensile" : "compressive",
                                       100 * std::abs((pull == Pull::tension ? out_.reached.tensile : out_.reached.compressive)->mean / wanted - 1)));
  }

  const BondTargets& targets_;
  Bench& bench_;
  BondCalibration& out_;
};

// Bonds without a strength of their own begin at the strain at which cement fails, about.
Case with_strengths(Case c) {
  for (BondCase& bond : c.bonds) {
    BondStrength& strength = bond.material.strength;
    const double start = bond.material.young > 0 ? 1e-3 * bond.material.young : 1e7;
    if (strength.tensile >= unbreakable) strength.tensile = start;
    if (strength.shear >= unbreakable) strength.shear = 3 * strength.tensile;
  }
  return c;
}

}  // namespace

BondCalibration calibrate_bonds(const Case& given, const BondRequest& request) {
  const BondTargets& targets = request.targets;
  if (given.bonds.empty()) throw InputError(fmt::format("{}: bond: found no table [bond.…] to begin with; allowed is one for every two kinds of grains, or [bond.default].", given.file));
  const bool breaks = targets.tensile || targets.compressive;
  const Case c = breaks ? with_strengths(given) : given;
  ThreadTeam team(request.threads);
  Bench bench(c, request, request.grains, team);
  BondCalibration out;
  Search search(targets, bench, out);
  search.stiffness();
  search.strengths();
  for (const BondCase& bond : c.bonds) out.bonds.push_back({bond.a, bond.b, scaled(bond.material, out.scale)});

  if (const std::optional<double> asked = c.agglomerates[request.agglomerate].request.solid_fraction; asked && out.reached.solid_fraction < 0.99 * *asked)
    out.remarks.push_back(fmt::format("Specimens of {} grains pack to a solid fraction of {:.3f}, not {:.3f}; more grains come nearer.", out.reached.grains, out.reached.solid_fraction, *asked));
  if (out.reached.kinetic_share > 0.05)
    out.remarks.push_back(fmt::format("Up to the peak the kinetic energy reached {:.2g} of that in the bonds: strengths may be those of a fast test.", out.reached.kinetic_share));
  if (!out.reached.all_failed) out.remarks.push_back("Not every specimen failed within the strain at which it was given up; its greatest stress was taken.");
  if (!request.sizes) return out;
  for (const std::int64_t grains : {request.grains / 2, request.grains, 2 * request.grains}) {
    if (grains == request.grains) {
      out.sizes.push_back(out.reached);
      continue;
    }
    Bench other(c, request, grains, team);
    SpecimenFigures figures = other.elasticity(out.scale);
    if (targets.tensile) figures.tensile = other.strength(out.scale, Pull::tension).tensile;
    if (targets.compressive) figures.compressive = other.strength(out.scale, Pull::compression).compressive;
    out.sizes.push_back(figures);
  }
  return out;
}

}  // namespace quern
