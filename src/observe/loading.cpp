#include "src/observe/loading.hpp"
#include <algorithm>
#include <cmath>
#include "src/observe/strain.hpp"

namespace quern {
namespace {

constexpr std::size_t grains_of_a_gauge = 13;

std::vector<std::size_t> rows_by_id(const Particles& particles) {
  std::vector<std::size_t> row(static_cast<std::size_t>(particles.owned));
  for (std::size_t k = 0; k < row.size(); ++k) row[static_cast<std::size_t>(particles.id[k])] = k;
  return row;
}

Vec3 displacement(const Simulation& s, const std::vector<std::size_t>& row_of, const RestingGrain& grain) {
  const Quad& now = s.particles.position[row_of[static_cast<std::size_t>(grain.id)]];
  return vec(s.domain.nearest(xyz(now) - grain.place));
}

double mean_along(const Simulation& s, const std::vector<std::size_t>& row_of, const std::vector<RestingGrain>& gauge, const Vec3& direction) {
  double sum = 0;
  for (const RestingGrain& grain : gauge) sum += displacement(s, row_of, grain).dot(direction);
  return sum / static_cast<double>(gauge.size());
}

}  // namespace

void Loading::begin(const Simulation& s, const ObserverSettings& settings) {
  for (const LoadedWall& loaded : settings.loading) {
    const Wall& wall = s.walls[static_cast<std::size_t>(loaded.wall)];
    walls.push_back({wall.name, wall.pose.origin.dot(loaded.along), 0, 0, {}, {}});
  }
  std::vector<bool> bonded(static_cast<std::size_t>(s.particles.owned));
  for (const Bond& bond : s.bonds.list) bonded[static_cast<std::size_t>(bond.first)] = bonded[static_cast<std::size_t>(bond.second)] = true;
  const std::vector<std::size_t> row_of = rows_by_id(s.particles);
  for (std::size_t id = 0; id < bonded.size(); ++id)
    if (bonded[id]) specimen.push_back({static_cast<Index>(id), xyz(s.particles.position[row_of[id]])});

  const Vec3& along = settings.loading.front().along;
  double low = 1e300, high = -1e300;
  for (const RestingGrain& grain : specimen) {
    const double at = vec(grain.place).dot(along);
    low = std::min(low, at), high = std::max(high, at);
  }
  for (const RestingGrain& grain : specimen)
    if (std::abs(vec(grain.place).dot(along) - 0.5 * (low + high)) <= 0.25 * (high - low)) middle.push_back(grain);

  for (const Vec3& place : settings.gauges) {
    std::vector<RestingGrain> nearest = specimen;
    const std::size_t count = std::min(grains_of_a_gauge, nearest.size());
    std::stable_sort(nearest.begin(), nearest.end(), [&](const RestingGrain& a, const RestingGrain& b) {
      return (vec(a.place) - place).squaredNorm() < (vec(b.place) - place).squaredNorm();
    });
    nearest.resize(count);
    if (count > 0) gauges.push_back(std::move(nearest));
  }
  began = true;
}

void Loading::see(const Simulation& s, const ObserverSettings& settings) {
  if (!began) return begin(s, settings);
  const double dt = s.clock.time_step;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const LoadedWall& loaded = settings.loading[w];
    const Wall& wall = s.walls[static_cast<std::size_t>(loaded.wall)];
    walls[w].displacement_sum += dt * (wall.pose.origin.dot(loaded.along) - walls[w].start);
    walls[w].force_sum -= dt * vec(wall.force).dot(loaded.along);
  }
  seconds += dt;
  if (seconds < settings.loading_interval * (1 - 1e-9)) return;
  time.push_back(s.clock.time());
  for (WallLoading& wall : walls) {
    wall.displacement.push_back(wall.displacement_sum / seconds);
    wall.force.push_back(wall.force_sum / seconds);
    wall.displacement_sum = wall.force_sum = 0;
  }
  seconds = 0;
  kinetic.push_back(s.kinetic_and_potential()[0]);
  bond_energy.push_back(s.ledger.bond_energy);
  broken.push_back(static_cast<double>(s.bonds.failures.size()));
  if (!settings.strain && gauges.empty()) return;

  const Vec3& along = settings.loading.front().along;
  const std::vector<std::size_t> row_of = rows_by_id(s.particles);
  if (settings.strain) {
    std::vector<Vec3> place, moved;
    for (const RestingGrain& grain : middle) place.push_back(vec(grain.place)), moved.push_back(displacement(s, row_of, grain));
    const Mat3 axes = axes_with_z(along);
    strain_along.push_back(strain_of(place, moved, along));
    strain_across.push_back(0.5 * (strain_of(place, moved, axes.col(0)) + strain_of(place, moved, axes.col(1))));
  }
  if (!gauges.empty()) {
    double others = 0;
    for (std::size_t g = 1; g < gauges.size(); ++g) others += mean_along(s, row_of, gauges[g], along) / static_cast<double>(gauges.size() - 1);
    gauge.push_back(mean_along(s, row_of, gauges[0], along) - others);
  }
}

Slope slope_of(const double* x, const double* y, std::size_t count) {
  Slope slope;
  if (count < 2) return slope;
  const auto n = static_cast<double>(count);
  double mean_x = 0, mean_y = 0;
  for (std::size_t k = 0; k < count; ++k) mean_x += x[k] / n, mean_y += y[k] / n;
  double xx = 0, xy = 0;
  for (std::size_t k = 0; k < count; ++k) xx += (x[k] - mean_x) * (x[k] - mean_x), xy += (x[k] - mean_x) * (y[k] - mean_y);
  if (!(xx > 0)) return slope;
  slope.value = xy / xx;
  slope.zero = slope.value != 0 ? mean_x - mean_y / slope.value : mean_x;
  double squares = 0, lagged = 0, before = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double residual = y[k] - mean_y - slope.value * (x[k] - mean_x);
    squares += residual * residual;
    if (k > 0) lagged += residual * before;
    before = residual;
  }
  const double correlation = squares > 0 ? std::clamp(lagged / squares, 0.0, 0.98) : 0;
  const double error = count > 2 ? std::sqrt(squares / (n - 2) / xx * (1 + correlation) / (1 - correlation)) : 0;
  slope.ci95 = {slope.value - 1.96 * error, slope.value + 1.96 * error};
  return slope;
}

std::optional<Loading::LinearPart> Loading::linear_part() const {
  if (walls.empty() || walls.front().force.empty()) return std::nullopt;
  const std::vector<double>& force = walls.front().force;
  LinearPart part;
  part.peak = static_cast<std::size_t>(std::max_element(force.begin(), force.end()) - force.begin());
  const double peak = force[part.peak];
  if (!(peak > 0)) return std::nullopt;
  const auto first_above = [&](double share) {
    return static_cast<std::size_t>(std::find_if(force.begin(), force.end(), [&](double f) { return f >= share * peak; }) - force.begin());
  };
  part.from = first_above(0.2), part.to = first_above(0.6) + 1;
  if (part.to < part.from + 4) return std::nullopt;
  return part;
}

std::vector<Headline> Loading::headlines(const ObserverSettings& settings) const {
  if (walls.empty() || walls.front().force.empty()) return {};
  const WallLoading& wall = walls.front();
  std::vector<Headline> lines;
  const auto peak = std::max_element(wall.force.begin(), wall.force.end());
  lines.push_back({"peak_force", *peak, "N", std::nullopt, "largest force that " + wall.name + " pushed with, averaged over an interval"});
  const std::optional<LinearPart> part = linear_part();
  if (!part) return lines;
  const std::size_t count = part->to - part->from;
  const auto over = [&](const std::vector<double>& x, const std::vector<double>& y) { return slope_of(x.data() + part->from, y.data() + part->from, count); };
  const Slope stiffness = over(wall.displacement, wall.force);
  lines.push_back({"displacement_at_peak", wall.displacement[part->peak] - stiffness.zero, "m", std::nullopt,
                   "of " + wall.name + " at the peak force, from where the line through the linear part meets no force"});
  lines.push_back({"loading_stiffness", stiffness.value, "N/m", stiffness.ci95, "force over displacement between 20 and 60 % of the peak force"});
  if (settings.strain) {
    const Slope axial = over(strain_along, wall.force), poisson = over(strain_along, strain_across);
    lines.push_back({"axial_stiffness", -axial.value, "N", std::array{-axial.ci95[1], -axial.ci95[0]},
                     "force over strain of the specimen's middle half in that part: Young's modulus times cross-section"});
    lines.push_back({"specimen_poisson", -poisson.value, "1", std::array{-poisson.ci95[1], -poisson.ci95[0]},
                     "lengthening across over shortening along, of the middle half in that part"});
  }
  if (!gauge.empty()) {
    const Slope gauged = over(gauge, wall.force);
    lines.push_back({"gauge_stiffness", gauged.value, "N/m", gauged.ci95, "force over what the gauges read in that part"});
  }
  double still = 0;
  for (std::size_t k = part->from; k < std::max(part->to, part->peak); ++k)
    if (bond_energy[k] > 0) still = std::max(still, kinetic[k] / bond_energy[k]);
  lines.push_back({"kinetic_over_bond_energy", still, "1", std::nullopt,
                   "largest ratio of kinetic energy to that stored in bonds, from 20 % of the peak force up to the peak: small where loading is slow enough"});
  return lines;
}

std::vector<Table> Loading::tables(const ObserverSettings& settings) const {
  Table table{"loading", "way of the loading walls and force on them, averaged over the intervals that end at each time", {}};
  Column name{"wall", "1", "name of the wall", {}, {}}, end{"time", "s", "end of the interval", {}, {}};
  Column way{"displacement", "m", "of the wall along its motion since the start", {}, {}}, push{"force", "N", "of the wall on the particles along its motion", {}, {}};
  Column along{"strain_along", "1", "of the specimen's middle half along the motion of the first wall, positive: longer", {}, {}};
  Column across{"strain_across", "1", "of the same across, mean of two directions", {}, {}};
  Column read{"gauge", "m", "displacement of the first gauge along that motion, less the mean of the others", {}, {}};
  Column moving{"kinetic_energy", "J", "of all particles at the end of the interval", {}, {}}, stored{"bond_energy", "J", "stored in bonds then", {}, {}};
  Column failed{"broken_bonds", "1", "since the start", {}, {}};
  for (const WallLoading& wall : walls) {
    for (std::size_t k = 0; k < time.size(); ++k) {
      name.labels.push_back(wall.name);
      end.values.push_back(time[k]);
      way.values.push_back(wall.displacement[k]);
      push.values.push_back(wall.force[k]);
      if (settings.strain) along.values.push_back(strain_along[k]), across.values.push_back(strain_across[k]);
      if (!gauge.empty()) read.values.push_back(gauge[k]);
      moving.values.push_back(kinetic[k]);
      stored.values.push_back(bond_energy[k]);
      failed.values.push_back(broken[k]);
    }
  }
  table.columns = {name, end, way, push};
  if (settings.strain) table.columns.insert(table.columns.end(), {along, across});
  if (!gauge.empty()) table.columns.push_back(read);
  table.columns.insert(table.columns.end(), {moving, stored, failed});
  return {table};
}

}  // namespace quern
