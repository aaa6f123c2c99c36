#include "src/observe/seat.hpp"
#include <cmath>

namespace quern {

MillAxis charge_axis(const ObserverSettings& settings) {
  if (settings.mill) return *settings.mill;
  const PlanetaryMill& mill = *settings.planetary;
  const Pose vial = vial_pose(mill, 0);
  return {vial.origin,
          vial.axes.col(2),
          turn_at(vial_motion(mill, 0), mill.ramp).speed,
          0.5 * mill.vial_diameter,
          mill.vials * mill.vial_length,
          0};
}

std::optional<Seat> Seat::of(const ObserverSettings& settings, const Simulation& simulation) {
  Seat seat;
  if (!settings.mill && !settings.planetary) return std::nullopt;
  Vec3 pull = simulation.gravity;
  if (settings.planetary) {
    const PlanetaryMill& mill = *settings.planetary;
    const double now = simulation.clock.time();
    pull = mill.speed * mill.speed * (vial_pose(mill, 0).origin - mill.centre);
    seat.planetary = &mill;
    seat.disc = disc_pose(mill, now);
    if (mill.axes == PlanetaryMill::Axes::disc)
      seat.field = TurningFrame{disc_motion(mill), simulation.gravity}.at(now, simulation.clock.time_step);
  }
  const std::optional<MillView> view = view_of(charge_axis(settings), pull);
  if (!view) return std::nullopt;
  seat.view = *view;
  seat.pull = pull.norm();
  return seat;
}

Mat3 Seat::to_first_vial(const Vec3& in_disc) const {
  const Vec3 axis = planetary->axis.normalized(), first = vial_pose(*planetary, 0).origin - planetary->centre,
             r = in_disc - planetary->centre;
  const double angle = std::atan2(axis.cross(first).dot(r), first.dot(r)), share = 2 * 3.141592653589793 / planetary->vials;
  return Eigen::AngleAxisd(-share * std::nearbyint(angle / share), axis).toRotationMatrix();
}

Vec3 Seat::seen(const Vec3& place) const {
  if (!planetary) return place;
  const Vec3 in_disc = disc.to_local(place);
  return planetary->centre + to_first_vial(in_disc) * (in_disc - planetary->centre);
}

Vec3 Seat::seen_velocity(const Vec3& place, const Vec3& velocity) const {
  if (!planetary) return velocity;
  return to_first_vial(disc.to_local(place)) * (disc.axes.transpose() * (velocity - disc.velocity_at(place)));
}

bool Seat::in_free_flight(const Simulation& simulation, Index i) const {
  const auto k = static_cast<std::size_t>(i);
  const Particles& p = simulation.particles;
  const double carried = simulation.carried_density > 0 ? simulation.carried_density * ball_volume(p.radius(i)) / p.mass(i) : 0;
  Vec3 pushed = (1 + carried) * vec(p.acceleration[k]) - simulation.gravity;
  if (field) pushed -= (*field)(p.position[k], p.velocity[k], p.spin[k]).force / p.mass(i);
  else if (!simulation.fields.empty()) pushed -= field_force(simulation.fields, simulation.clock.time(), simulation.clock.time_step, p, k) / p.mass(i);
  return pushed.norm() < 0.1 * pull;
}

Simulation first_vial(const Simulation& simulation, const PlanetaryMill& mill) {
  const Pose disc = disc_pose(mill, simulation.clock.time());
  const Vec3 out = vial_pose(mill, 0).origin - mill.centre, across = mill.axis.normalized().cross(out);
  const double share = 3.141592653589793 / mill.vials;
  Simulation s;
  s.materials = simulation.materials;
  s.species = simulation.species;
  s.shapes = simulation.shapes;
  s.clock = simulation.clock;
  s.gravity = disc.axes.transpose() * simulation.gravity;
  for (const Wall& original : simulation.walls) {
    if (original.frame > 1 && original.frame <= mill.vials) continue;
    Wall wall = original;
    wall.pose.origin = disc.to_local(original.pose.origin);
    wall.pose.axes = disc.axes.transpose() * original.pose.axes;
    wall.pose.velocity = disc.axes.transpose() * (original.pose.velocity - disc.velocity_at(original.pose.origin));
    wall.pose.angular_velocity = disc.axes.transpose() * (original.pose.angular_velocity - disc.angular_velocity);
    s.walls.push_back(std::move(wall));
  }
  s.bonds = simulation.bonds;
  const Particles& p = simulation.particles;
  const Rotation turned_back(Mat3(disc.axes.transpose()));
  for (Index i = 0; i < p.owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vec3 place = disc.to_local(vec(p.position[k])), r = place - mill.centre;
    if (std::abs(std::atan2(across.dot(r), out.dot(r))) > share) continue;
    const std::uint8_t shape = p.shape.empty() ? 0 : p.shape[k];
    const double density = simulation.materials[p.material[k]].density;
    const auto row = static_cast<std::size_t>(
        shape == 0 ? s.particles.add_sphere(triple(place), p.radius(i), density, p.material[k], p.species[k])
                   : s.particles.add_shape(triple(place), s.shapes[shape], shape, p.radius(i) / s.shapes[shape].bounding_radius, density, p.material[k], p.species[k]));
    if (shape != 0) {
      const Rotation turned = turned_back * rotation_of(p.orientation[k]);
      s.particles.orientation[row] = {turned.x(), turned.y(), turned.z(), turned.w()};
    }
    set(s.particles.velocity[row], disc.axes.transpose() * (vec(p.velocity[k]) - disc.velocity_at(vec(p.position[k]))));
    s.particles.id[row] = p.id[k];
    set(s.particles.spin[row], disc.axes.transpose() * (vec(p.spin[k]) - disc.angular_velocity));
  }
  return s;
}

}  // namespace quern
