#include "src/observe/torque_power.hpp"

#include <algorithm>
#include <cmath>

namespace quern {

void WallHistory::add(const WallHistory& later) {
  seconds += later.seconds;
  force = force + later.force;
  torque += later.torque;
  work += later.work;
  peak_force = std::max(peak_force, later.peak_force);
}

void WallHistories::add(const WallHistories& later) {
  if (walls.size() < later.walls.size()) walls.resize(later.walls.size());
  for (std::size_t w = 0; w < later.walls.size(); ++w) walls[w].add(later.walls[w]);
}

bool is_driven(const Simulation& simulation, const std::vector<int>& listed, std::size_t wall) {
  if (listed.empty()) return simulation.walls[wall].frame >= 0;
  return std::find(listed.begin(), listed.end(), static_cast<int>(wall)) != listed.end();
}

namespace {

// What the charge has taken up: the heat it made and the energy it stores, less what other fields gave.
double taken_up(const Simulation& simulation) {
  const auto [kinetic, potential] = simulation.kinetic_and_potential();
  const Ledger& ledger = simulation.ledger;
  return ledger.dissipated() + kinetic + potential + ledger.elastic + ledger.bond_energy - ledger.field_work;
}

}  // namespace

void TorquePower::see(const Simulation& simulation, const ObserverSettings& settings) {
  const Ledger& ledger = simulation.ledger;
  const double now = simulation.clock.time(), dt = simulation.clock.time_step;
  if (!began) {
    began = true;
    last_wall_work = ledger.wall_work;
    last_taken_up = taken_up(simulation);
    for (const Wall& wall : simulation.walls) wall_names.push_back(wall.name);
    walls.span = 10 * settings.power_interval;
    walls.open(now).sums.walls.resize(simulation.walls.size());
    return;
  }
  if (walls.due(now - dt)) walls.open(now - dt).sums.walls.resize(simulation.walls.size());
  auto& block = walls.blocks.back();
  block.to = now;
  const Vec3 axis = settings.mill ? ((settings.mill->speed < 0 ? -1 : 1) * settings.mill->axis.normalized()).eval() : Vec3::Zero().eval();
  const Turn disc = settings.planetary ? turn_at(disc_motion(*settings.planetary), now) : Turn{};
  const std::vector<Pose> frames = settings.planetary ? poses_at(simulation.frames, now) : std::vector<Pose>{};
  for (std::size_t w = 0; w < simulation.walls.size(); ++w) {
    const Wall& wall = simulation.walls[w];
    const Vec3 force = vec(wall.force), moment = vec(wall.torque);
    const double work = -dt * (force.dot(wall.pose.velocity) + moment.dot(wall.pose.angular_velocity));
    const double about_axis = settings.mill ? axis.dot(moment + (wall.pose.origin - settings.mill->centre).cross(force)) : 0.0;
    if (settings.planetary) {
      const double sense = disc.speed < 0 ? -1 : 1;
      const double about_disc = sense * disc.axis.dot(moment + (wall.pose.origin - disc.centre).cross(force));
      double about_vial = 0, vial_speed = 0;
      if (wall.frame >= 1 && wall.frame <= settings.planetary->vials) {
        const Turn vial = turn_at(simulation.frames[static_cast<std::size_t>(wall.frame)].motion, now);
        const Vec3 axis_now = (vial.speed < 0 ? -1 : 1) * (frames[0].axes * vial.axis), middle = frames[0].to_fixed(vial.centre);
        about_vial = axis_now.dot(moment + (wall.pose.origin - middle).cross(force));
        vial_speed = std::abs(vial.speed);
      }
      block.sums.walls[w].add({dt, dt * wall.force, dt * about_vial, -dt * (about_disc * std::abs(disc.speed) + about_vial * vial_speed), force.norm()});
      if (!is_driven(simulation, settings.driven_walls, w)) continue;
      torque_sum -= dt * about_disc;
      vial_torque_sum -= dt * about_vial;
      vial_work_sum -= dt * about_vial * vial_speed;
      work_sum -= dt * (about_disc * std::abs(disc.speed) + about_vial * vial_speed);
      continue;
    }
    block.sums.walls[w].add({dt, dt * wall.force, dt * about_axis, work, force.norm()});
    if (!is_driven(simulation, settings.driven_walls, w)) continue;
    torque_sum -= dt * about_axis;
    work_sum += settings.mill ? -dt * about_axis * wall.pose.angular_velocity.dot(axis) : work;
  }
  seconds += dt;
  if (seconds < settings.power_interval * (1 - 1e-9)) return;
  time.push_back(now);
  torque.push_back(torque_sum / seconds);
  power.push_back(work_sum / seconds);
  if (settings.planetary) {
    vial_torque.push_back(vial_torque_sum / seconds);
    vial_power.push_back(vial_work_sum / seconds);
  }
  wall_power.push_back((ledger.wall_work - last_wall_work) / seconds);
  const double now_taken_up = taken_up(simulation);
  ledger_power.push_back((now_taken_up - last_taken_up) / seconds);
  last_wall_work = ledger.wall_work;
  last_taken_up = now_taken_up;
  seconds = torque_sum = work_sum = vial_torque_sum = vial_work_sum = 0;
}

std::size_t TorquePower::steady_index(const ObserverSettings& settings) const {
  if (settings.start_time < 0) return steady_start(power);
  const auto first = std::upper_bound(time.begin(), time.end(), settings.start_time + 0.5 * settings.power_interval);
  return static_cast<std::size_t>(first - time.begin());
}

double TorquePower::steady_time(const ObserverSettings& settings) const {
  if (settings.start_time >= 0) return settings.start_time;
  const std::size_t index = steady_index(settings);
  return index == 0 || index > time.size() ? 0.0 : time[index - 1];
}

std::vector<Headline> TorquePower::headlines(const ObserverSettings& settings) const {
  const std::size_t from = steady_index(settings);
  if (from >= time.size()) return {};
  const auto steady = [&](const std::vector<double>& series) {
    return block_average(std::vector<double>(series.begin() + static_cast<std::ptrdiff_t>(from), series.end()));
  };
  std::vector<Headline> lines;
  const auto add = [&](const char* key, const BlockAverage& average, const char* unit, const char* description) {
    lines.push_back({key, average.mean, unit, average.ci95, description});
  };
  const BlockAverage by_torque = steady(power), by_ledger = steady(ledger_power), by_walls = steady(wall_power);
  // Of the drive, with what it loses on the way to the charge.
  const DriveLoss& loss = settings.drive;
  const double speed = settings.mill ? std::abs(settings.mill->speed) : 0;
  const auto driven = [&](BlockAverage average, double bearings) {
    const auto with_losses = [&](double x) { return (x + bearings) * (1 + loss.gear_loss); };
    average.mean = with_losses(average.mean);
    if (average.ci95) average.ci95 = {{with_losses((*average.ci95)[0]), with_losses((*average.ci95)[1])}};
    return average;
  };
  if (settings.mill) add("torque", driven(steady(torque), loss.bearing_torque), "N m", "torque of the drive on the driven walls about the mill's axis");
  if (settings.planetary) {
    add("torque", steady(torque), "N m", "torque of the drive about the disc's axis, in the sense in which the disc turns");
    add("vial_torque", steady(vial_torque), "N m", "torque of the drive on all vials about their own axes, in the sense in which they turn on the disc");
    add("vial_power", steady(vial_power), "W", "vial_torque times the speed of the vials against the disc; the rest of the power is torque times the disc's speed");
  }
  add("power", driven(by_torque, loss.bearing_torque * speed), "W", loss.any() ? "of the drive: torque on the driven walls times their angular speed, and what bearings and gears take" : "torque on the driven walls times their angular speed");
  if (loss.any()) add("power_charge", by_torque, "W", "torque of the charge on the driven walls times their angular speed");
  add("power_ledger", by_ledger, "W", "energy taken up by the charge per second, dissipated and stored, by the energy ledger");
  add("power_walls", by_walls, "W", "work of all walls on the particles per second, by the energy ledger");
  if (by_torque.mean != 0)
    lines.push_back({"power_agreement", by_ledger.mean / by_torque.mean - 1, "1", std::nullopt, "power by the ledger over power by torque, less one"});
  lines.push_back({"steady_from", steady_time(settings), "s", std::nullopt,
                   settings.start_time < 0 ? "where the power was found to be steady (MSER-5); averages begin here" : "averages begin here, as asked"});
  return lines;
}

std::vector<Table> TorquePower::tables() const {
  Table series{"power", "torque and power of the driven walls, averaged over the intervals that end at each time", {}};
  series.columns = {{"time", "s", "end of the interval", time, {}},
                    {"torque", "N m", "of the drive on the driven walls, positive in the sense of rotation", torque, {}},
                    {"power", "W", "torque times angular speed", power, {}},
                    {"power_walls", "W", "work of all walls on the particles, by the energy ledger", wall_power, {}},
                    {"power_ledger", "W", "energy taken up by the charge, dissipated and stored, by the energy ledger", ledger_power, {}}};
  if (!vial_torque.empty()) {
    series.columns[1].description = "of the drive about the disc's axis, positive in the sense in which it turns";
    series.columns[2].description = "torque times angular speed, of disc and vials together";
    series.columns.push_back({"vial_torque", "N m", "of the drive on all vials about their own axes, positive in the sense in which they turn on the disc", vial_torque, {}});
    series.columns.push_back({"vial_power", "W", "vial_torque times the speed of the vials against the disc", vial_power, {}});
  }
  Table walls_table{"walls", "mean force, torque and power of each wall over successive spans of time", {}};
  Column from{"from", "s", "begin of the span", {}, {}}, to{"to", "s", "end of the span", {}, {}}, name{"wall", "1", "name of the wall", {}, {}};
  Column fx{"force_x", "N", "of the particles on the wall", {}, {}}, fy{"force_y", "N", "of the particles on the wall", {}, {}},
      fz{"force_z", "N", "of the particles on the wall", {}, {}}, peak{"peak_force", "N", "largest in the span, at any step", {}, {}},
      turn{"torque", "N m", "of the particles on the wall about the mill's axis, in the sense of rotation", {}, {}},
      work{"power", "W", "done by the wall on the particles", {}, {}};
  for (const auto& block : walls.blocks)
    for (std::size_t w = 0; w < block.sums.walls.size(); ++w) {
      const WallHistory& wall = block.sums.walls[w];
      if (wall.seconds <= 0) continue;
      from.values.push_back(block.from);
      to.values.push_back(block.to);
      name.labels.push_back(wall_names[w]);
      fx.values.push_back(wall.force.x / wall.seconds);
      fy.values.push_back(wall.force.y / wall.seconds);
      fz.values.push_back(wall.force.z / wall.seconds);
      peak.values.push_back(wall.peak_force);
      turn.values.push_back(wall.torque / wall.seconds);
      work.values.push_back(wall.work / wall.seconds);
    }
  walls_table.columns = {from, to, name, fx, fy, fz, peak, turn, work};
  return {series, walls_table};
}

}  // namespace quern
