#include "src/observe/fragment_tables.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include "src/observe/angles.hpp"
#include "src/observe/block_average.hpp"

namespace quern {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// The fragments with their sieve sizes.
struct Sized {
  Fragments fragments;
  std::vector<double> size;  // of each [m]
};

Sized sized(const Simulation& s) {
  Sized all{find_fragments(s.bonds, s.particles, s.domain), {}};
  for (std::size_t k = 0; k < all.fragments.list.size(); ++k) all.size.push_back(sieve_size(all.fragments, k, s.particles));
  return all;
}

struct GrainDiameters {
  double smallest = 1e300, largest = 0;  // [m]
};

GrainDiameters diameters_of(const Sized& all, const Particles& p) {
  GrainDiameters d;
  for (const std::vector<Index>& rows : all.fragments.members)
    for (const Index row : rows) d.smallest = std::min(d.smallest, 2 * p.radius(row)), d.largest = std::max(d.largest, 2 * p.radius(row));
  return d;
}

Table damage_table(const std::vector<Damage>& series) {
  const auto column = [&](const char* name, const char* unit, const char* description, double Damage::*of) {
    Column c{name, unit, description, {}, {}};
    for (const Damage& d : series) c.values.push_back(d.*of);
    return c;
  };
  return {"damage",
          "how broken bonded bodies are",
          {column("time", "s", "", &Damage::time), column("damage_ratio", "1", "bonds that failed over all that were made", &Damage::ratio),
           column("tension", "1", "bonds that failed in tension so far", &Damage::tension),
           column("shear", "1", "bonds that failed in shear so far", &Damage::shear),
           column("fragments", "1", "fragments, single grains included", &Damage::fragments),
           column("largest_fragment", "1", "mass of the largest fragment over that of its body, over all bodies", &Damage::largest),
           column("fines", "1", "mass of single grains over the whole", &Damage::fines),
           column("bond_energy", "J", "stored in bonds", &Damage::bond_energy),
           column("bond_failure", "J", "released by bonds that failed, since the start", &Damage::released),
           column("kinetic", "J", "kinetic energy of the grains, spin included", &Damage::kinetic)}};
}

Table fragment_table(const Sized& all) {
  const auto column = [&](const char* name, const char* unit, const char* description, auto&& of) {
    Column c{name, unit, description, {}, {}};
    for (std::size_t k = 0; k < all.fragments.list.size(); ++k) c.values.push_back(of(all.fragments.list[k], k));
    return c;
  };
  using F = const Fragment&;
  return {"fragments",
          "fragments at the end, the heaviest first; their masses sum to fragment_mass of the summary without a rounding",
          {column("fragment", "1", "least id of its grains", [](F f, std::size_t) { return f.id; }),
           column("body", "1", "least id of the grains of the body that it comes from", [](F f, std::size_t) { return f.body; }),
           column("grains", "1", "how many", [](F f, std::size_t) { return f.grains; }),
           column("mass", "kg", "", [](F f, std::size_t) { return f.mass; }),
           column("mass_fraction", "1", "of the mass of all", [&](F f, std::size_t) { return f.mass / all.fragments.mass; }),
           column("solid_volume", "m^3", "of its grains", [](F f, std::size_t) { return f.volume; }),
           column("size", "m", "side of the smallest square opening that it passes", [&](F, std::size_t k) { return all.size[k]; }),
           column("x", "m", "centre of mass", [](F f, std::size_t) { return f.centre.x; }),
           column("y", "m", "", [](F f, std::size_t) { return f.centre.y; }),
           column("z", "m", "", [](F f, std::size_t) { return f.centre.z; }),
           column("vx", "m/s", "velocity of the centre", [](F f, std::size_t) { return f.velocity.x; }),
           column("vy", "m/s", "", [](F f, std::size_t) { return f.velocity.y; }),
           column("vz", "m/s", "", [](F f, std::size_t) { return f.velocity.z; }),
           column("kinetic", "J", "half its mass times the square of that velocity", [](F f, std::size_t) { return f.kinetic_energy(); })}};
}

Table failure_table(const Bonds& bonds) {
  const auto column = [&](const char* name, const char* unit, const char* description, auto&& of) {
    Column c{name, unit, description, {}, {}};
    for (const BondFailure& f : bonds.failures) c.values.push_back(of(f));
    return c;
  };
  using F = const BondFailure&;
  Column mode{"mode", "1", "the criterion that was exceeded", {}, {}}, material{"bond", "1", "its kind", {}, {}};
  for (F f : bonds.failures) {
    mode.labels.push_back(f.mode == BondFailureMode::tension ? "tension" : "shear");
    material.labels.push_back(bonds.materials[at(bonds.list[at(f.bond)].material)].name);
  }
  return {"failures",
          "every bond that failed, in the order of time",
          {column("time", "s", "", [](F f) { return f.time; }), mode, material,
           column("energy", "J", "that it held", [](F f) { return f.energy; }),
           column("x", "m", "middle of the bond", [](F f) { return f.place.x; }), column("y", "m", "", [](F f) { return f.place.y; }),
           column("z", "m", "", [](F f) { return f.place.z; }),
           column("nx", "1", "unit vector from the first grain to the second: normal of the crack", [](F f) { return f.normal.x; }),
           column("ny", "1", "", [](F f) { return f.normal.y; }), column("nz", "1", "", [](F f) { return f.normal.z; }),
           column("first", "1", "id of a grain", [](F f) { return f.first; }), column("second", "1", "id of the other", [](F f) { return f.second; })}};
}

// Places in a list, by its values; equal ones as they stand.
std::vector<std::size_t> ascending(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] != values[b] ? values[a] < values[b] : a < b; });
  return order;
}

// One row for each value that occurs, ascending, and the mass up to there.
Table cumulative(const char* name, const char* description, const std::vector<Column>& heads, const std::vector<double>& values,
                 const std::vector<Fragment>& list, double whole) {
  const std::vector<std::size_t> order = ascending(values);
  Column value = heads[0], fraction = heads[1];
  Column count{"fragments", "1", "of just that", {}, {}}, mass{"mass", "kg", "of those", {}, {}};
  double sum = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t f = order[k];
    sum += list[f].mass;
    if (value.values.empty() || value.values.back() != values[f]) {
      value.values.push_back(values[f]), fraction.values.push_back(0), count.values.push_back(0), mass.values.push_back(0);
    }
    fraction.values.back() = sum / whole, count.values.back() += 1, mass.values.back() += list[f].mass;
  }
  return {name, description, {value, count, mass, fraction}};
}

Table size_table(const Sized& all, const std::optional<SchuhmannFit>& fit) {
  Table table = cumulative("fragment_sizes", "mass that passes a sieve",
                           {{"size", "m", "side of a square opening", {}, {}}, {"finer", "1", "mass that passes it, over all", {}, {}}}, all.size,
                           all.fragments.list, all.fragments.mass);
  if (!fit) return table;
  Column law{"schuhmann", "1", "the same by the law of Gates, Gaudin and Schuhmann, within the range of its fit", {}, {}};
  for (const double x : table.columns[0].values)
    law.values.push_back(x >= fit->sieves.front() * (1 - 1e-9) && x <= fit->sieves.back() * (1 + 1e-9) ? fit->at(x) : std::nan(""));
  table.columns.push_back(law);
  return table;
}

ProductSize product_of(const Sized& all, double time) {
  ProductSize product{time};
  double finer = 0;
  for (const std::size_t k : ascending(all.size)) {
    const double before = finer;
    finer += all.fragments.list[k].mass;
    for (const auto& [share, size] : {std::pair(0.8, &product.d80), std::pair(0.5, &product.d50)})
      if (const double wanted = share * all.fragments.mass; before < wanted && wanted <= finer) *size = all.size[k];
  }
  return product;
}

// As `quern grinding` takes it.
Table product_table(const std::vector<ProductSize>& sieved) {
  const auto column = [&](const char* name, const char* unit, const char* description, double ProductSize::*of) {
    Column c{name, unit, description, {}, {}};
    for (const ProductSize& size : sieved) c.values.push_back(size.*of);
    return c;
  };
  return {"product_sizes",
          "sizes of all fragments against time",
          {column("t", "s", "", &ProductSize::time), column("D80", "m", "sieve that 80 % of the mass passes", &ProductSize::d80),
           column("D50", "m", "sieve that half of it passes", &ProductSize::d50)}};
}

Table speed_table(const Sized& all) {
  std::vector<double> speeds;
  for (const Fragment& f : all.fragments.list) speeds.push_back(length(f.velocity));
  return cumulative("fragment_speeds", "mass of the fragments that move no faster",
                    {{"speed", "m/s", "of a fragment's centre", {}, {}}, {"slower", "1", "mass of those no faster, over all", {}, {}}}, speeds,
                    all.fragments.list, all.fragments.mass);
}

Table crack_table(const Bonds& bonds, const Vec3& direction, const std::string& name) {
  constexpr int bins = 9;
  std::vector<double> tension(bins, 0), shear(bins, 0), energy(bins, 0);
  for (const BondFailure& failure : bonds.failures) {
    const double angle = std::acos(std::min(1.0, std::abs(vec(failure.normal).dot(direction)))) / degree;
    const auto bin = static_cast<std::size_t>(std::min(bins - 1, static_cast<int>(angle * bins / 90)));
    (failure.mode == BondFailureMode::tension ? tension : shear)[bin] += 1;
    energy[bin] += failure.energy;
  }
  Column from{"angle_from", "deg", "between the normal of a crack and " + name + "; 90 degrees: the crack lies along it", {}, {}};
  Column to{"angle_to", "deg", "", {}, {}}, share{"share", "1", "of all failures", {}, {}};
  Column relative{"relative", "1", "share over that of directions at random", {}, {}};
  Column low{"relative_low", "1", "lower end of the 95 % interval (Poisson)", {}, {}}, high{"relative_high", "1", "its upper end", {}, {}};
  const auto all = static_cast<double>(bonds.failures.size());
  for (int k = 0; k < bins; ++k) {
    const double a = 90.0 * k / bins, b = 90.0 * (k + 1) / bins, random = std::cos(a * degree) - std::cos(b * degree);
    const double count = tension[static_cast<std::size_t>(k)] + shear[static_cast<std::size_t>(k)];
    const auto [least, most] = poisson_interval(count);
    from.values.push_back(a), to.values.push_back(b), share.values.push_back(count / all);
    relative.values.push_back(count / all / random), low.values.push_back(least / all / random), high.values.push_back(most / all / random);
  }
  return {"crack_directions",
          "which way cracks face",
          {from, to, {"tension", "1", "failures in tension", tension, {}}, {"shear", "1", "failures in shear", shear, {}}, {"energy", "J", "of these failures", energy, {}},
           share, relative, low, high}};
}

// Mass of what passes a tenth of the sieve size that its body had; not known where no grain does.
double t10(const Sized& all, const std::map<Index, double>& body_size, double smallest_grain) {
  double passing = 0;
  bool resolved = false;
  for (std::size_t k = 0; k < all.size.size(); ++k) {
    const double limit = 0.1 * body_size.at(all.fragments.list[k].body);
    resolved |= smallest_grain <= limit;
    if (all.size[k] <= limit) passing += all.fragments.list[k].mass;
  }
  return resolved ? passing / all.fragments.mass : std::nan("");
}

}  // namespace

ProductSize product_size(const Simulation& simulation) { return product_of(sized(simulation), simulation.clock.time()); }

std::pair<std::vector<Headline>, std::vector<Table>> fragment_results(const FragmentView& view) {
  const Bonds& bonds = view.simulation.bonds;
  const Sized all = sized(view.simulation);
  const GrainDiameters grains = diameters_of(all, view.simulation.particles);
  std::vector<double> masses;
  for (const Fragment& f : all.fragments.list) masses.push_back(f.mass);
  const std::optional<SchuhmannFit> fit = fit_schuhmann(all.size, masses, grains.largest);

  std::vector<ProductSize> sieved = view.sieved;
  if (const double now = view.simulation.clock.time(); sieved.empty() || sieved.back().time < now) sieved.push_back(product_of(all, now));
  std::vector<Table> tables = {damage_table(view.series), fragment_table(all), size_table(all, fit), speed_table(all), product_table(sieved)};
  if (!bonds.failures.empty()) {
    tables.push_back(failure_table(bonds));
    tables.push_back(crack_table(bonds, view.direction, view.direction_name));
  }

  const Damage& last = view.series.back();
  std::vector<Headline> lines;
  const auto add = [&](const char* key, double value, const char* unit, const char* description, std::optional<std::array<double, 2>> ci95 = {}) {
    lines.push_back({key, value, unit, ci95, description});
  };
  add("damage_ratio", last.ratio, "1", "bonds that failed over all that were made");
  add("bond_failures_tension", last.tension, "1", "bonds that failed in tension");
  add("bond_failures_shear", last.shear, "1", "bonds that failed in shear");
  add("bond_failure_energy", last.released, "J", "that bonds held when they failed");
  add("body_count", static_cast<double>(view.body_size.size()), "1", "bodies of bonded grains at the start");
  add("fragment_count", last.fragments, "1", "fragments at the end, single grains included");
  add("fragment_mass", all.fragments.mass, "kg", "of all fragments");
  add("largest_fragment_fraction", last.largest, "1", "mass of the largest fragment over that of its body; of several bodies: the sum of their largest over all");
  add("fines_fraction", last.fines, "1", "mass of single grains over the whole");
  add("t10", t10(all, view.body_size, grains.smallest), "1", "mass that passes a tenth of its body's sieve size at the start, over the whole; null where all grains are larger");
  if (fit) {
    add("schuhmann_modulus", fit->modulus, "1", "m of finer = (size/k)^m", fit->modulus_ci95);
    add("schuhmann_size", fit->size, "m", "k of finer = (size/k)^m", fit->size_ci95);
  }
  return {std::move(lines), std::move(tables)};
}

}  // namespace quern
