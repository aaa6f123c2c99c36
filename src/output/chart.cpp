#include "src/output/chart.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace quern {
namespace {

const Table* find(const std::vector<Table>& tables, const std::string& name) {
  const auto found = std::find_if(tables.begin(), tables.end(), [&](const Table& table) { return table.name == name; });
  return found == tables.end() ? nullptr : &*found;
}

const Column* find(const Table& table, const std::string& name) {
  const auto found = std::find_if(table.columns.begin(), table.columns.end(), [&](const Column& column) { return column.name == name; });
  return found == table.columns.end() ? nullptr : &*found;
}

const Headline* find(const std::vector<Headline>& headlines, const std::string& key) {
  const auto found = std::find_if(headlines.begin(), headlines.end(), [&](const Headline& headline) { return headline.key == key; });
  return found == headlines.end() ? nullptr : &*found;
}

std::string titled(const std::string& what, const std::string& title) { return title.empty() ? what : what + " · " + title; }

// The pairs with a wall, or all others, as one curve; their independent errors add in quadrature.
Curve summed(const std::vector<Curve>& pairs, bool with_walls) {
  struct Sum {
    double rate = 0, below = 0, above = 0;
  };
  std::map<double, Sum> bins;
  for (const Curve& pair : pairs) {
    if (pair.name.ends_with("wall") != with_walls) continue;
    for (std::size_t k = 0; k < pair.x.size(); ++k) {
      Sum& sum = bins[pair.x[k]];
      sum.rate += pair.y[k];
      sum.below = std::hypot(sum.below, pair.y[k] - pair.lower[k]);
      sum.above = std::hypot(sum.above, pair.upper[k] - pair.y[k]);
    }
  }
  Curve curve{with_walls ? "with walls" : "between particles", {}, {}, {}, {}, true};
  for (const auto& [energy, sum] : bins) {
    curve.x.push_back(energy);
    curve.y.push_back(sum.rate);
    curve.lower.push_back(sum.rate - sum.below);
    curve.upper.push_back(sum.rate + sum.above);
  }
  return curve;
}

// Contacts that ended, against the energy they dissipated; one curve for each pair of bodies.
std::vector<Chart> spectrum_chart(const Table& table, const std::string& title) {
  const Column *measure = find(table, "measure"), *pair = find(table, "pair"), *type = find(table, "class"), *energy = find(table, "energy"),
               *rate = find(table, "rate"), *low = find(table, "rate_low"), *high = find(table, "rate_high");
  if (!measure || !pair || !type || !energy || !rate || !low || !high) return {};
  Panel panel{"dissipated energy [J]", "collisions per second, per bin [1/s]", true, true, {}};
  for (std::size_t row = 0; row < rate->values.size(); ++row) {
    if (measure->labels[row] != "dissipated" || type->labels[row] != "collision" || !(rate->values[row] > 0)) continue;
    auto curve = std::find_if(panel.curves.begin(), panel.curves.end(), [&](const Curve& c) { return c.name == pair->labels[row]; });
    if (curve == panel.curves.end()) curve = panel.curves.insert(curve, Curve{pair->labels[row], {}, {}, {}, {}, true});
    curve->x.push_back(energy->values[row]);
    curve->y.push_back(rate->values[row]);
    curve->lower.push_back(low->values[row]);
    curve->upper.push_back(high->values[row]);
  }
  if (panel.curves.empty()) return {};
  constexpr std::size_t readable = 4;
  if (panel.curves.size() > readable) panel.curves = {summed(panel.curves, false), summed(panel.curves, true)};
  std::erase_if(panel.curves, [](const Curve& c) { return c.x.empty(); });
  return {{"spectrum.png", titled("Collision spectrum", title), {panel}}};
}

// A level line from where averages begin to the end of the series.
void add_mean(Panel& panel, const std::vector<Headline>& headlines, const std::string& key, const std::vector<double>& time) {
  const Headline* mean = find(headlines, key);
  if (!mean || time.empty() || !std::isfinite(mean->value)) return;
  const Headline* steady = find(headlines, "steady_from");
  Curve level{mean->ci95 ? "mean and its 95 % interval" : "mean", {steady ? steady->value : time.front(), time.back()}, {mean->value, mean->value}, {}, {}, false};
  if (mean->ci95) level.lower.assign(2, (*mean->ci95)[0]), level.upper.assign(2, (*mean->ci95)[1]);
  panel.curves.push_back(level);
}

std::vector<Chart> power_chart(const Table& table, const std::vector<Headline>& headlines, const std::string& title) {
  const Column *time = find(table, "time"), *power = find(table, "power"), *torque = find(table, "torque");
  if (!time || !power || time->values.size() < 2) return {};
  Chart chart{"power.png", titled("Power", title), {}};
  for (const Column* column : {power, torque}) {
    if (!column) continue;
    Panel panel{"time [s]", column->name + " [" + column->unit + "]", false, false, {}};
    panel.curves.push_back({column->name, time->values, column->values, {}, {}, false});
    add_mean(panel, headlines, column->name, time->values);
    chart.panels.push_back(panel);
  }
  return {chart};
}

// E_i and the collisions per second over what was sampled, with their intervals.
std::vector<Chart> convergence_chart(const Table& table, const std::string& title) {
  const Column* sampled = find(table, "sampled");
  Chart chart{"convergence.png", titled("Convergence of the spectrum", title), {}};
  for (const auto& [key, label] : {std::pair("impact_energy_rate", "E_i [W]"), std::pair("collision_rate", "collisions per second [1/s]")}) {
    const Column *value = find(table, key), *low = find(table, std::string(key) + "_low"), *high = find(table, std::string(key) + "_high");
    if (!sampled || !value || !low || !high) return {};
    Curve curve{"mean so far and its 95 % interval", {}, {}, {}, {}, false};
    for (std::size_t row = 0; row < value->values.size(); ++row) {
      if (!std::isfinite(low->values[row])) continue;  // too short to tell
      curve.x.push_back(sampled->values[row]);
      curve.y.push_back(value->values[row]);
      curve.lower.push_back(low->values[row]);
      curve.upper.push_back(high->values[row]);
    }
    if (curve.x.size() < 2) return {};
    chart.panels.push_back({"time sampled [s]", label, false, false, {curve}});
  }
  return {chart};
}

// Above what is stored, below what went in and where it went.
std::vector<Chart> energy_chart(const Table& table, const std::string& title) {
  const Column* time = find(table, "time");
  if (!time || time->values.size() < 2) return {};
  const auto curve = [&](const char* name, const char* spoken, bool from_start) {
    Curve out{spoken, time->values, {}, {}, {}, false};
    if (const Column* column = find(table, name))
      for (const double value : column->values) out.y.push_back(value - (from_start ? column->values.front() : 0));
    return out;
  };
  Panel stored{"time [s]", "stored [J]", false, false, {curve("kinetic", "kinetic", false), curve("potential", "potential, since the start", true), curve("elastic", "elastic", false),
                curve("bond_energy", "in bonds", false)}};
  Panel passed{"time [s]", "since the start [J]", false, false,
               {curve("wall_work", "work of the walls", false), curve("normal_loss", "lost along the normal", false), curve("sliding_loss", "lost by sliding", false),
                curve("rolling_loss", "lost by rolling", false), curve("bond_loss", "lost in bonds", false),
                curve("bond_failure", "released by bonds that failed", false), curve("gap", "unaccounted for", false)}};
  const auto nothing = [](const Curve& c) { return std::all_of(c.y.begin(), c.y.end(), [](double y) { return y == 0; }); };
  std::erase_if(passed.curves, [&](const Curve& c) { return c.name != "unaccounted for" && nothing(c); });
  std::erase_if(stored.curves, [&](const Curve& c) { return c.name == "in bonds" && nothing(c); });
  return {{"energy.png", titled("Energy", title), {stored, passed}}};
}

// Above damage against time, below the fragments' sizes.
std::vector<Chart> damage_chart(const Table& damage, const Table* sizes, const std::string& title) {
  const Column* time = find(damage, "time");
  Chart chart{"damage.png", titled("Damage", title), {}};
  if (time && time->values.size() > 1) {
    Panel panel{"time [s]", "fraction", false, false, {}};
    for (const auto& [key, spoken] : {std::pair("damage_ratio", "broken bonds"), std::pair("largest_fragment", "mass of the largest fragment"), std::pair("fines", "mass of single grains")})
      if (const Column* column = find(damage, key)) panel.curves.push_back({spoken, time->values, column->values, {}, {}, false});
    chart.panels.push_back(panel);
  }
  const Column *size = sizes ? find(*sizes, "size") : nullptr, *finer = sizes ? find(*sizes, "finer") : nullptr;
  if (size && finer && size->values.size() > 1) {
    Panel panel{"sieve size of fragments [m]", "mass that passes", true, true, {}};
    panel.curves.push_back({"fragments", size->values, finer->values, {}, {}, true});
    if (const Column* law = find(*sizes, "schuhmann")) panel.curves.push_back({"Gates–Gaudin–Schuhmann", size->values, law->values, {}, {}, false});
    chart.panels.push_back(panel);
  }
  return chart.panels.empty() ? std::vector<Chart>{} : std::vector<Chart>{chart};
}

// Force and broken bonds against the way of each platen.
std::vector<Chart> loading_chart(const Table& table, const std::string& title) {
  const Column *wall = find(table, "wall"), *way = find(table, "displacement"), *force = find(table, "force"), *broken = find(table, "broken_bonds");
  if (!wall || !way || !force || !broken || way->values.size() < 2) return {};
  Panel forces{"displacement [mm]", "force [N]", false, false, {}}, bonds{"displacement [mm]", "broken bonds", false, false, {}};
  for (std::size_t row = 0; row < way->values.size(); ++row) {
    if (row == 0 || wall->labels[row] != wall->labels[row - 1]) {
      forces.curves.push_back({wall->labels[row], {}, {}, {}, {}, false});
      if (row == 0) bonds.curves.push_back({"broken bonds", {}, {}, {}, {}, false});
    }
    forces.curves.back().x.push_back(1e3 * way->values[row]);
    forces.curves.back().y.push_back(force->values[row]);
    if (forces.curves.size() > 1) continue;
    bonds.curves.back().x.push_back(1e3 * way->values[row]);
    bonds.curves.back().y.push_back(broken->values[row]);
  }
  return {{"loading.png", titled("Loading", title), {forces, bonds}}};
}

std::vector<Chart> discharge_chart(const Table& table, const std::vector<Headline>& headlines, const std::string& title) {
  const Column *time = find(table, "time"), *mass = find(table, "mass"), *rate = find(table, "rate");
  if (!time || !mass || !rate || time->values.size() < 2) return {};
  Panel masses{"time [s]", "mass [kg]", false, false, {}}, rates{"time [s]", "rate [kg/s]", false, false, {}};
  masses.curves.push_back({"mass", time->values, mass->values, {}, {}, false});
  rates.curves.push_back({"rate", time->values, rate->values, {}, {}, false});
  add_mean(rates, headlines, "discharge_rate", time->values);
  return {{"discharge.png", titled("Discharge", title), {masses, rates}}};
}

}  // namespace

std::vector<Chart> charts_of(const std::vector<Table>& tables, const std::vector<Headline>& headlines, const std::string& title) {
  std::vector<Chart> charts;
  const auto add = [&](const std::vector<Chart>& more) { charts.insert(charts.end(), more.begin(), more.end()); };
  if (const Table* table = find(tables, "spectra")) add(spectrum_chart(*table, title));
  if (const Table* table = find(tables, "convergence")) add(convergence_chart(*table, title));
  if (const Table* table = find(tables, "power")) add(power_chart(*table, headlines, title));
  if (const Table* table = find(tables, "loading")) add(loading_chart(*table, title));
  if (const Table* table = find(tables, "discharge")) add(discharge_chart(*table, headlines, title));
  if (const Table* table = find(tables, "energy")) add(energy_chart(*table, title));
  if (const Table* table = find(tables, "damage")) add(damage_chart(*table, find(tables, "fragment_sizes"), title));
  return charts;
}

}  // namespace quern
