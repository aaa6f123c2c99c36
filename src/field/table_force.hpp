// A force on single particles, or a torque, that a table gives: learnt from recordings, or measured.
#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>
#include "src/field/load.hpp"

namespace quern {

struct TableForce {
  enum class Variable { speed, x, y, z, vx, vy, vz, spin, time };
  enum class Direction {
    against_velocity,  // −v/|v|
    x, y, z,
    lift,              // ω×v over its length
    against_spin,      // a torque along −ω/|ω|
  };
  std::string title;  // the case's name of it
  Variable variable = Variable::speed;
  Direction direction = Direction::against_velocity;
  std::vector<double> points;  // of the variable, ascending, at least two [m, m/s, rad/s or s]
  std::vector<double> values;  // the force or torque at each, linear in between and constant beyond the ends [N, N m]

  double value(double where) const {
    const auto above = std::upper_bound(points.begin(), points.end(), where);
    if (above == points.begin()) return values.front();
    if (above == points.end()) return values.back();
    const auto k = static_cast<std::size_t>(above - points.begin());
    return values[k - 1] + (where - points[k - 1]) / (points[k] - points[k - 1]) * (values[k] - values[k - 1]);
  }

  // The field at one instant.
  struct Now {
    const TableForce& table;
    double time, time_step;

    double variable(const Quad& position, const Quad& velocity, const Quad& spin) const {
      switch (table.variable) {
        case Variable::speed: return vec(velocity).norm();
        case Variable::x: return position.x;
        case Variable::y: return position.y;
        case Variable::z: return position.z;
        case Variable::vx: return velocity.x;
        case Variable::vy: return velocity.y;
        case Variable::vz: return velocity.z;
        case Variable::spin: return vec(spin).norm();
        case Variable::time: break;
      }
      return time;
    }
    FieldLoad operator()(const Quad& position, const Quad& velocity, const Quad& spin) const {
      const double force = table.value(variable(position, velocity, spin));
      switch (table.direction) {
        case Direction::x: return {{force, 0, 0}};
        case Direction::y: return {{0, force, 0}};
        case Direction::z: return {{0, 0, force}};
        case Direction::against_velocity: return {-braking(force, velocity)};
        case Direction::against_spin: return {Vec3::Zero(), -braking(force, spin)};
        case Direction::lift: break;
      }
      const Vec3 across = vec(spin).cross(vec(velocity));
      const double length = across.norm();
      return {length > 0 ? Vec3(force / length * across) : Vec3(Vec3::Zero())};
    }
    // Along the motion, a velocity or a spin with its inertia. What brakes takes at most half of it in a step: a force that is there down to rest, such as friction, then ends in rest.
    Vec3 braking(double force, const Quad& motion) const {
      const Vec3 v = vec(motion);
      const double speed = v.norm();
      return speed > 0 ? Vec3(std::min(force / speed, 0.5 * motion.w / time_step) * v) : Vec3(Vec3::Zero());
    }
  };
  Now at(double time, double time_step) const { return {*this, time, time_step}; }

  // See medium.hpp; the steepest part of the table counts, wherever it is. A force that depends on the place is a spring.
  double rate(double radius, double inertia, double, double) const {
    const bool torque = direction == Direction::against_spin;
    if (variable == Variable::time || (variable == Variable::spin) != torque) return 0;
    const bool place = variable == Variable::x || variable == Variable::y || variable == Variable::z;
    double steepest = 0;
    for (std::size_t k = 1; k < points.size(); ++k) steepest = std::max(steepest, std::abs((values[k] - values[k - 1]) / (points[k] - points[k - 1])));
    if (torque) return steepest / (0.4 * inertia * radius * radius);  // of a solid sphere
    return place ? std::sqrt(steepest / inertia) : steepest / inertia;
  }
};

}  // namespace quern
