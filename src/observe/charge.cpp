#include "src/observe/charge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "src/observe/block_average.hpp"
#include "src/observe/spectrum.hpp"

namespace quern {

namespace {

constexpr double pi = 3.141592653589793;
constexpr double impact_lowest = 1e-12;  // of the impact bins [J]
constexpr std::int64_t samples_per_field = 4;  // paths need finer steps than averages
constexpr int impact_bins = 180, impact_bins_per_decade = 10;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double self_weighted_mean(const std::vector<double>& x) {
  double sum = 0, squares = 0;
  for (double v : x) sum += v, squares += v * v;
  return sum > 0 ? squares / sum : 0;
}

void add_each(std::vector<double>& sums, const std::vector<double>& more) {
  if (sums.size() < more.size()) sums.resize(more.size());
  for (std::size_t k = 0; k < more.size(); ++k) sums[k] += more[k];
}

// A mean over the three sectors around each.
std::vector<double> smoothed(const std::vector<double>& x) {
  std::vector<double> out(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) out[k] = (x[(k + x.size() - 1) % x.size()] + x[k] + x[(k + 1) % x.size()]) / 3;
  return out;
}

// Angle of the sum of vectors [degrees]; none for a vanishing sum.
std::optional<double> direction(double cosine, double sine) {
  if (std::hypot(cosine, sine) <= 0) return std::nullopt;
  return wrapped(std::atan2(sine, cosine) / degree);
}

// The difference that is nearest to 0 [degrees].
double nearest_difference(double a, double b) { return std::remainder(a - b, 360.0); }

}  // namespace

double PolarGrid::volume(int ring) const {
  const double inner = ring * radius / radius_cells, outer = (ring + 1) * radius / radius_cells;
  return pi * (outer * outer - inner * inner) / angle_cells * length;
}

void ChargeSums::add(const ChargeSums& later) {
  samples += later.samples;
  add_each(volume, later.volume);
  add_each(flow_ahead, later.flow_ahead);
  add_each(flow_up, later.flow_up);
  add_each(layer, later.layer);
  followed += later.followed;
  flown += later.flown;
  held += later.held;
  held_turn += later.held_turn;
  add_each(leaving, later.leaving);
  if (impacts.size() < later.impacts.size()) impacts.resize(later.impacts.size());
  for (std::size_t k = 0; k < later.impacts.size(); ++k) {
    impacts[k].energy += later.impacts[k].energy;
    impacts[k].cosine += later.impacts[k].cosine;
    impacts[k].sine += later.impacts[k].sine;
  }
  rises += later.rises;
  rise_sum += later.rise_sum;
  falls += later.falls;
  fall_sum += later.fall_sum;
  fall_max = std::max(fall_max, later.fall_max);
}

std::optional<std::array<double, 2>> half_level_angles(const std::vector<double>& raw) {
  const std::vector<double> profile = smoothed(raw);
  const int n = static_cast<int>(profile.size());
  const double half = 0.5 * self_weighted_mean(profile), width = 360.0 / n;
  if (half <= 0) return std::nullopt;
  double cosine = 0, sine = 0;
  for (int k = 0; k < n; ++k) {
    const double p = profile[static_cast<std::size_t>(k)], angle = (k + 0.5) * width * degree;
    cosine += p * p * std::cos(angle);
    sine += p * p * std::sin(angle);
  }
  const std::optional<double> middle = direction(cosine, sine);
  if (!middle) return std::nullopt;
  const int start = static_cast<int>(*middle / width) % n;
  if (profile[static_cast<std::size_t>(start)] < half) return std::nullopt;
  std::array<double, 2> edge{};
  for (int side = 0; side < 2; ++side) {
    const int step = side == 0 ? -1 : 1;
    int k = start, walked = 0;
    while (walked < n && profile[static_cast<std::size_t>((k + step + n) % n)] >= half) k = (k + step + n) % n, ++walked;
    if (walked >= n) return std::nullopt;
    const double inside = profile[static_cast<std::size_t>(k)], outside = profile[static_cast<std::size_t>((k + step + n) % n)];
    edge[static_cast<std::size_t>(side)] = wrapped((k + 0.5) * width + step * width * (inside - half) / (inside - outside));
  }
  return edge;
}

ChargeSums Charge::empty_sums() const {
  ChargeSums s;
  s.volume.resize(grid.cells());
  s.flow_ahead.resize(grid.cells());
  s.flow_up.resize(grid.cells());
  s.layer.resize(static_cast<std::size_t>(grid.angle_cells));
  s.leaving.resize(static_cast<std::size_t>(grid.angle_cells));
  s.impacts.resize(impact_bins);
  return s;
}

bool Charge::fits(const ChargeSums& sums) const {
  const ChargeSums empty = empty_sums();
  return sums.volume.size() == empty.volume.size() && sums.flow_ahead.size() == empty.flow_ahead.size() && sums.flow_up.size() == empty.flow_up.size() && sums.layer.size() == empty.layer.size() &&
         sums.leaving.size() == empty.leaving.size() && sums.impacts.size() == empty.impacts.size();
}

void Charge::begin(const Simulation& simulation, const ObserverSettings& settings, const Seat& seat) {
  const MillAxis mill = charge_axis(settings);
  const Particles& p = simulation.particles;
  grid = {mill.radius, mill.length, settings.radius_cells, settings.angle_cells};
  double volume = 0, weighted = 0, low = INFINITY, high = -INFINITY;
  for (Index i = 0; i < p.owned; ++i) {
    const double r = p.radius(i), along = (seat.seen(vec(p.position[at(i)])) - mill.centre).dot(mill.axis.normalized());
    volume += r * r * r;
    weighted += 2 * r * r * r * r;
    low = std::min(low, along - r);
    high = std::max(high, along + r);
  }
  mean_diameter = volume > 0 ? weighted / volume : 0;
  if (grid.length <= 0) grid.length = std::max(high - low, 1e-9);
  layer_from = mill.radius - mill.lifter_height - mean_diameter;
  if (settings.velocity_line) {
    const MillView* view = &seat.view;
    const Vec3 point = settings.velocity_line->point - mill.centre, along = settings.velocity_line->direction;
    line_point = {point.dot(view->ahead), point.dot(view->up)};
    line_direction = {along.dot(view->ahead), along.dot(view->up)};
    const double size = std::hypot(line_direction[0], line_direction[1]);
    line_direction = size > 0 ? std::array<double, 2>{line_direction[0] / size, line_direction[1] / size} : std::array<double, 2>{0, 1};
  }
  const double revolution = mill.speed != 0 ? 2 * pi / std::abs(mill.speed) : 1.0;
  interval = settings.charge_interval > 0 ? settings.charge_interval : std::max(revolution / 360, 50 * simulation.clock.time_step);
  next_sample = simulation.clock.time();
  next_revolution = simulation.clock.time() + revolution;
  blocks.span = revolution / 4;
  shell_speed = std::abs(mill.speed);
  began = true;
}

void Charge::see(const Simulation& simulation, const ObserverSettings& settings) {
  if (simulation.particles.owned == 0) return;
  const std::optional<Seat> seat = Seat::of(settings, simulation);
  if (!seat) return;
  const double now = simulation.clock.time(), half_step = 0.5 * simulation.clock.time_step;
  if (now < settings.start_time - half_step) return;
  if (!began) begin(simulation, settings, *seat);
  if (now >= next_sample - half_step) {
    if (blocks.due(now)) blocks.open(now).sums = empty_sums();
    ChargeSums& sums = blocks.blocks.back().sums;
    if (sampled++ % samples_per_field == 0) sample(simulation, *seat, sums);
    follow(simulation, *seat, sums);
    if (now >= next_revolution - half_step) {
      end_revolution(sums);
      const double speed = charge_axis(settings).speed;
      next_revolution += speed != 0 ? 2 * pi / std::abs(speed) : 1.0;
    }
    blocks.blocks.back().to = now;
    while (next_sample <= now + half_step) next_sample += interval;
  }
  take_impacts(simulation, *seat, blocks.blocks.back().sums);
}

void Charge::sample(const Simulation& simulation, const Seat& seat, ChargeSums& sums) {
  // A sphere seen along the axis as seven points with the moments of its mass up to the fifth: the middle with weight 0.3 and a hexagon
  // of radius √(4/7) R with 0.7/6 each.
  static const double reach = std::sqrt(4.0 / 7.0);
  static const std::array<std::array<double, 3>, 7> points = [] {
    std::array<std::array<double, 3>, 7> q{};
    q[0] = {0, 0, 0.3};
    for (int k = 0; k < 6; ++k) q[static_cast<std::size_t>(k) + 1] = {reach * std::cos(k * pi / 3), reach * std::sin(k * pi / 3), 0.7 / 6};
    return q;
  }();
  const Particles& p = simulation.particles;
  const MillView& view = seat.view;
  sums.samples += 1;
  for (Index i = 0; i < p.owned; ++i) {
    const Vec3 place = seat.seen(vec(p.position[at(i)])) - view.centre, velocity = seat.seen_velocity(vec(p.position[at(i)]), vec(p.velocity[at(i)]));
    const double radius = simulation.solid_radius(i), volume = 4.0 / 3.0 * pi * radius * radius * radius;
    const double ahead = place.dot(view.ahead), up = place.dot(view.up), v_ahead = velocity.dot(view.ahead), v_up = velocity.dot(view.up);
    const bool held = ahead * ahead + up * up > layer_from * layer_from && !seat.in_free_flight(simulation, i);
    if (held) sums.held += volume, sums.held_turn += volume * (v_ahead * up - v_up * ahead) / (ahead * ahead + up * up);
    for (const auto& [a, b, weight] : points) {
      const double x = ahead + a * radius, y = up + b * radius;
      const int sector = grid.sector_of(wrapped(std::atan2(x, y) / degree));
      const std::size_t cell = grid.cell(grid.ring_of(std::sqrt(x * x + y * y)), sector);
      const double part = weight * volume;
      sums.volume[cell] += part;
      sums.flow_ahead[cell] += part * v_ahead;
      sums.flow_up[cell] += part * v_up;
      if (held) sums.layer[static_cast<std::size_t>(sector)] += part;
    }
  }
}

void Charge::follow(const Simulation& simulation, const Seat& seat, ChargeSums& sums) {
  const Particles& p = simulation.particles;
  const MillView& view = seat.view;
  for (Index i = 0; i < p.owned; ++i) {
    const std::size_t id = at(p.id[at(i)]);
    if (id >= balls.size()) balls.resize(id + 1);
    BallTrack& ball = balls[id];
    const Vec3 place = seat.seen(vec(p.position[at(i)]));
    const double height = view.height(place), angle = view.angle(place), radius = p.radius(i);
    const double volume = 4.0 / 3.0 * pi * radius * radius * radius;
    const bool in_layer = view.radius(place) > layer_from;
    const bool flying = seat.in_free_flight(simulation, i);
    const bool first_seen = !ball.known;
    sums.followed += volume;
    if (first_seen) {
      ball.known = 1;
      ball.last = height;
      ball.lowest = ball.highest = height;
    } else {
      ball.lowest = std::min(ball.lowest, height);
      ball.highest = std::max(ball.highest, height);
      if (ball.in_layer && !in_layer) sums.leaving[static_cast<std::size_t>(grid.sector_of(ball.held_angle))] += volume;
      if (!ball.in_layer && in_layer) sums.leaving[static_cast<std::size_t>(grid.sector_of(angle))] -= volume;
      if (ball.flying && !flying && ball.whole_flight) {
        const double drop = ball.apex - std::min(height, ball.last);
        if (drop > 0.5 * mean_diameter) {
          sums.falls += 1;
          sums.fall_sum += drop;
          sums.fall_max = std::max(sums.fall_max, drop);
          sums.flown += volume * ball.flight_samples;
        }
      }
    }
    ball.flight_samples = flying ? ball.flight_samples + 1 : 0;
    // A flight that was under way at the first sample has lost its beginning.
    if (flying && !ball.flying) ball.whole_flight = !first_seen;
    ball.apex = flying ? (ball.flying ? std::max(ball.apex, height) : std::max(ball.last, height)) : height;
    ball.last = height;
    if (in_layer && (!flying || !ball.in_layer)) ball.held_angle = angle;
    ball.in_layer = in_layer;
    ball.flying = flying;
  }
}

void Charge::end_revolution(ChargeSums& sums) {
  for (BallTrack& ball : balls) {
    if (!ball.known) continue;
    sums.rises += 1;
    sums.rise_sum += ball.highest - ball.lowest;
    ball.lowest = ball.highest = ball.last;
  }
}

void Charge::take_impacts(const Simulation& simulation, const Seat& seat, ChargeSums& sums) const {
  const MillView& view = seat.view;
  for (const Collision& c : simulation.ended_collisions()) {
    const Vec3 place = seat.seen(vec(c.place));
    const double r = view.radius(place), energy = impact_energy(c);
    if (!(r >= layer_from && r <= grid.radius + mean_diameter && energy > impact_lowest)) continue;
    const int bin = static_cast<int>(std::min(impact_bins - 1.0, std::log10(energy / impact_lowest) * impact_bins_per_decade));
    const double angle = view.angle(place) * degree;
    ImpactBin& to = sums.impacts[static_cast<std::size_t>(bin)];
    to.energy += energy;
    to.cosine += energy * std::cos(angle);
    to.sine += energy * std::sin(angle);
  }
}

ChargeShape Charge::shape(const ChargeSums& sums) const {
  ChargeShape result;
  if (sums.samples <= 0) return result;
  const std::optional<std::array<double, 2>> ends = half_level_angles(sums.layer);
  if (ends) {
    result.toe = (*ends)[0];
    result.shoulder = (*ends)[1];
    const double middle = (*ends)[0] + 0.5 * wrapped((*ends)[1] - (*ends)[0]);
    double cosine = 0, sine = 0;
    for (int k = 0; k < grid.angle_cells; ++k) {
      const double angle = grid.sector_angle(k), out = sums.leaving[static_cast<std::size_t>(k)];
      if (out <= 0 || wrapped(angle - middle) > 180) continue;
      cosine += out * std::cos(angle * degree);
      sine += out * std::sin(angle * degree);
    }
    result.departure = direction(cosine, sine);
  }
  double impact_total = 0;
  for (const ImpactBin& b : sums.impacts) impact_total += b.energy;
  if (impact_total > 0) {
    double taken = 0, cosine = 0, sine = 0;
    for (std::size_t k = sums.impacts.size(); k-- > 0 && taken < 0.5 * impact_total;) {
      taken += sums.impacts[k].energy;
      cosine += sums.impacts[k].cosine;
      sine += sums.impacts[k].sine;
    }
    result.impact = direction(cosine, sine);
  }

  std::vector<double> fraction(grid.cells());
  double squares = 0, plain = 0;
  for (int ring = 0; ring < grid.radius_cells; ++ring)
    for (int sector = 0; sector < grid.angle_cells; ++sector) {
      const std::size_t c = grid.cell(ring, sector);
      const double v = grid.volume(ring);
      fraction[c] = sums.volume[c] / (sums.samples * v);
      plain += fraction[c] * v;
      squares += fraction[c] * fraction[c] * v;
    }
  if (plain <= 0) return result;
  result.bed_fraction = squares / plain;
  const auto in_bed = [&](int ring, int sector) {
    return ring >= 0 && ring < grid.radius_cells &&
           fraction[grid.cell(ring, (sector + grid.angle_cells) % grid.angle_cells)] >= 0.5 * result.bed_fraction;
  };
  // The inside of the bed: a particle's radius away from the shell, and two cells from where the bed ends.
  double inside = 0, solid = 0, ahead = 0, up = 0;
  for (int ring = 0; ring < grid.radius_cells; ++ring)
    for (int sector = 0; sector < grid.angle_cells; ++sector) {
      if (!in_bed(ring, sector)) continue;
      const double v = grid.volume(ring), f = fraction[grid.cell(ring, sector)], angle = grid.sector_angle(sector) * degree;
      ahead += f * v * grid.ring_radius(ring) * std::sin(angle);
      up += f * v * grid.ring_radius(ring) * std::cos(angle);
      bool deep = grid.ring_radius(ring) < grid.radius - 0.5 * mean_diameter - 0.5 * grid.radius / grid.radius_cells;
      for (int d = -2; d <= 2; ++d) {
        deep = deep && in_bed(ring, sector + d);
        deep = deep && (ring + d >= grid.radius_cells || in_bed(ring + d, sector));
      }
      if (deep) inside += v, solid += f * v;
    }
  if (inside > 0) result.porosity = 1 - solid / inside;
  if (const std::optional<double> middle = direction(up, ahead)) result.repose = beyond_six_oclock(*middle);
  return result;
}

std::array<double, 3> Charge::field_at(const ChargeSums& sums, double radius, double angle) const {
  const double ring = radius / grid.radius * grid.radius_cells - 0.5, sector = wrapped(angle) / 360 * grid.angle_cells - 0.5;
  double volume = 0, ahead = 0, up = 0, space = 0;
  for (int dr = 0; dr < 2; ++dr)
    for (int ds = 0; ds < 2; ++ds) {
      const int r = static_cast<int>(std::floor(ring)) + dr, s = static_cast<int>(std::floor(sector)) + ds;
      const double weight = (1 - std::abs(ring - r)) * (1 - std::abs(sector - s));
      // Inside the innermost ring the line goes on into the sector across; beyond the outermost the last ring holds.
      const int row = std::clamp(r, 0, grid.radius_cells - 1), turn = r < 0 ? s + grid.angle_cells / 2 : s;
      const std::size_t c = grid.cell(row, (turn + grid.angle_cells) % grid.angle_cells);
      volume += weight * sums.volume[c];
      ahead += weight * sums.flow_ahead[c];
      up += weight * sums.flow_up[c];
      space += weight * grid.volume(row);
    }
  if (volume <= 0) return {0, 0, 0};
  return {ahead / volume, up / volume, volume / (space * std::max(1.0, sums.samples))};
}

std::vector<Headline> Charge::headlines(double from) const {
  if (blocks.blocks.empty()) return {};
  const std::size_t first = blocks.first_from(from);
  const ChargeSums all = blocks.total(first);
  const ChargeShape whole = shape(all);
  std::vector<ChargeShape> parts;
  std::vector<double> rises, falls, flights, slips;
  const auto flight_share = [](const ChargeSums& s) { return s.followed > 0 ? s.flown / s.followed : 0; };
  const auto slip = [&](const ChargeSums& s) { return 1 - s.held_turn / (s.held * shell_speed); };
  for (std::size_t k = first; k < blocks.blocks.size(); ++k) {
    const ChargeSums& s = blocks.blocks[k].sums;
    if (s.samples < 5) continue;
    parts.push_back(shape(s));
    flights.push_back(flight_share(s));
    if (s.held > 0 && shell_speed > 0) slips.push_back(slip(s));
    if (s.rises > 0) rises.push_back(s.rise_sum / s.rises);
    if (s.falls > 0) falls.push_back(s.fall_sum / s.falls);
  }
  std::vector<Headline> lines;
  const auto add = [&](const char* key, double value, const char* unit, const std::vector<double>& series, const char* description) {
    Headline line{key, value, unit, std::nullopt, description};
    const BlockAverage average = block_average(series);
    if (average.ci95 && series.size() >= 5) {
      const double half = 0.5 * ((*average.ci95)[1] - (*average.ci95)[0]);
      line.ci95 = {{value - half, value + half}};
    }
    lines.push_back(line);
  };
  const auto add_angle = [&](const char* key, std::optional<double> ChargeShape::*member, const char* description) {
    const std::optional<double>& value = whole.*member;
    if (!value) return;
    std::vector<double> series;
    for (const ChargeShape& part : parts)
      if (part.*member) series.push_back(*value + nearest_difference(*(part.*member), *value));
    add(key, *value, "deg", series, description);
  };
  add_angle("shoulder_angle", &ChargeShape::shoulder, "where the layer next to the shell ends, from 12 o'clock in the sense of rotation");
  add_angle("toe_angle", &ChargeShape::toe, "where the layer next to the shell begins, from 12 o'clock in the sense of rotation");
  add_angle("departure_angle", &ChargeShape::departure, "mean angle at which balls leave the shell, from 12 o'clock in the sense of rotation");
  add_angle("impact_angle", &ChargeShape::impact, "mean angle of the strongest impacts next to the shell, from 12 o'clock in the sense of rotation");
  add_angle("angle_of_repose", &ChargeShape::repose, "dynamic: inclination of a flat bed with the same centre of mass");
  if (whole.porosity) {
    std::vector<double> series;
    for (const ChargeShape& part : parts)
      if (part.porosity) series.push_back(*part.porosity);
    add("bed_porosity", *whole.porosity, "1", series, "void fraction inside the bed");
  }
  add("flight_share", flight_share(all), "1", flights, "share of the charge that is in free flight, drops below half a diameter left out");
  if (all.held > 0 && shell_speed > 0) add("shell_slip", slip(all), "1", slips, "how far the balls next to the shell lag behind it: 1 less their angular speed over its own");
  if (all.rises > 0) add("release_height", all.rise_sum / all.rises, "m", rises, "highest less lowest position of a ball within one revolution of the mill, mean over balls");
  if (all.falls > 0) {
    lines.push_back({"fall_height_max", all.fall_max, "m", std::nullopt, "largest drop of a ball in free flight"});
    add("fall_height_mean", all.fall_sum / all.falls, "m", falls, "mean drop of balls in free flight, drops below half a diameter left out");
  }
  return lines;
}

std::vector<Table> Charge::tables(const ObserverSettings& settings, double from) const {
  if (blocks.blocks.empty()) return {};
  const ChargeSums sums = blocks.total(blocks.first_from(from));
  if (sums.samples <= 0) return {};
  Column radius{"radius", "m", "middle of the cell", {}, {}}, angle{"angle", "deg", "middle of the cell, from 12 o'clock in the sense of rotation", {}, {}},
      horizontal{"horizontal", "m", "middle of the cell, towards the 90 degree position", {}, {}}, vertical{"vertical", "m", "middle of the cell, upwards", {}, {}},
      fraction{"solid_fraction", "1", "mean share of the cell's volume that is solid", {}, {}},
      ahead{"velocity_horizontal", "m/s", "mean, weighted by volume", {}, {}}, up{"velocity_vertical", "m/s", "mean, weighted by volume", {}, {}},
      around{"velocity_tangential", "m/s", "mean, positive in the sense of rotation", {}, {}}, outward{"velocity_radial", "m/s", "mean, positive outwards", {}, {}};
  for (int ring = 0; ring < grid.radius_cells; ++ring)
    for (int sector = 0; sector < grid.angle_cells; ++sector) {
      const std::size_t c = grid.cell(ring, sector);
      const double r = grid.ring_radius(ring), a = grid.sector_angle(sector), s = std::sin(a * degree), k = std::cos(a * degree);
      const double v = sums.volume[c], va = v > 0 ? sums.flow_ahead[c] / v : 0, vu = v > 0 ? sums.flow_up[c] / v : 0;
      radius.values.push_back(r);
      angle.values.push_back(a);
      horizontal.values.push_back(r * s);
      vertical.values.push_back(r * k);
      fraction.values.push_back(v / (sums.samples * grid.volume(ring)));
      ahead.values.push_back(va);
      up.values.push_back(vu);
      around.values.push_back(va * k - vu * s);
      outward.values.push_back(va * s + vu * k);
    }
  Table field{"charge_field", "solid fraction and velocity of the charge on a polar grid, averaged over the steady state",
              {radius, angle, horizontal, vertical, fraction, ahead, up, around, outward}};

  Column sector_angle{"angle", "deg", "middle of the sector, from 12 o'clock in the sense of rotation", {}, {}},
      layer{"solid_volume", "m^3", "mean volume of the balls next to the shell in the sector", {}, {}},
      leaving{"leaving", "m^3", "net volume of balls that left that layer in the sector; negative: came to it", {}, {}};
  for (int sector = 0; sector < grid.angle_cells; ++sector) {
    sector_angle.values.push_back(grid.sector_angle(sector));
    layer.values.push_back(sums.layer[static_cast<std::size_t>(sector)] / sums.samples);
    leaving.values.push_back(sums.leaving[static_cast<std::size_t>(sector)]);
  }
  Table shell{"charge_layer", "the layer of balls next to the shell, by angle", {sector_angle, layer, leaving}};

  // The line in the cross-section, as (horizontal, vertical); along it and, as the flow of interest, across it.
  const ChargeShape whole = shape(sums);
  double px = 0, py = 0, dx = 0, dy = 1;
  if (settings.velocity_line) {
    px = line_point[0], py = line_point[1], dx = line_direction[0], dy = line_direction[1];
  } else if (whole.repose) {
    const double a = (*whole.repose + 180) * degree;
    dx = std::sin(a), dy = std::cos(a);
  }
  Column distance{"distance", "m", "along the line; from the centre towards the bed where the line was not given", {}, {}},
      across{"velocity_across", "m/s", "mean, positive ahead of the line when turned in the sense of rotation", {}, {}}, along{"velocity_along", "m/s", "mean", {}, {}},
      solid{"solid_fraction", "1", "mean", {}, {}};
  const int steps = 2 * grid.radius_cells;
  for (int k = 0; k <= steps; ++k) {
    const double s = grid.radius * (2.0 * k / steps - 1), x = px + s * dx, y = py + s * dy, r = std::hypot(x, y);
    if (r > grid.radius * (1 + 1e-9)) continue;
    const auto [va, vu, f] = field_at(sums, r, std::atan2(x, y) / degree);
    distance.values.push_back(s);
    across.values.push_back(va * dy - vu * dx);
    along.values.push_back(va * dx + vu * dy);
    solid.values.push_back(f);
  }
  Table profile{"velocity_profile", "mean velocity of the charge along a line through the cross-section", {distance, across, along, solid}};
  return {field, shell, profile};
}

}  // namespace quern
