#include "src/field/fields.hpp"
#include "src/field/shape_fields.hpp"

namespace quern {
namespace {

// `place` gives the position of a row and the radius that the fields see.
template <class Place>
double apply(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, Index first, Index last, Load* load, Place&& place) {
  double power = 0;
  for (const Field& field : fields) {
    std::visit(
        [&](const auto& one) {
          const auto& now = one.at(time, time_step);
          for (Index i = first; i < last; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const FieldLoad found = now(place(k), particles.velocity[k], particles.spin[k]);
            add(load[i - first].force, found.force);
            add(load[i - first].torque, found.torque);
            power += found.force.dot(vec(particles.velocity[k])) + found.torque.dot(vec(particles.spin[k]));
          }
        },
        field);
  }
  return power;
}

}  // namespace

double apply_fields(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, Index first, Index last, Load* load) {
  return apply(fields, time, time_step, particles, first, last, load, [&](std::size_t k) -> const Quad& { return particles.position[k]; });
}

double apply_fields_to_shapes(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, const Superquadric* shapes, Index first, Index last, Load* load) {
  return apply(fields, time, time_step, particles, first, last, load, [&](std::size_t k) {
    Quad position = particles.position[k];
    if (const std::uint8_t shape = particles.shape[k]; shape != 0) position.w *= shapes[shape].volume_radius / shapes[shape].bounding_radius;
    return position;
  });
}

bool takes_shapes(const Field& field) { return !std::holds_alternative<TurningFrame>(field) && !std::holds_alternative<TableForce>(field); }

Vec3 field_force(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, std::size_t row) {
  Vec3 sum = Vec3::Zero();
  for (const Field& field : fields)
    sum += std::visit([&](const auto& one) -> Vec3 { return one.at(time, time_step)(particles.position[row], particles.velocity[row], particles.spin[row]).force; }, field);
  return sum;
}

std::string name_of(const Field& field) {
  return std::visit(
      [](const auto& one) -> std::string {
        if constexpr (requires { one.title; }) return "force." + one.title;
        else return one.name;
      },
      field);
}

double rate_of(const Field& field, double radius, double inertia, double speed, double spin) {
  return std::visit([&](const auto& one) { return one.rate(radius, inertia, speed, spin); }, field);
}

void add_carried_inertia(double carried_density, Particles& particles) {
  for (std::size_t k = 0; k < particles.position.size(); ++k)
    if (double& inverse = particles.acceleration[k].w; inverse > 0) inverse = 1 / (particles.velocity[k].w + carried_density * ball_volume(particles.position[k].w));
}

void take_carried_weight(double carried_density, const Vec3& gravity, const Particles& particles, Index first, Index last, Load* load) {
  for (Index i = first; i < last; ++i) add(load[i - first].force, -carried_density * ball_volume(particles.radius(i)) * gravity);
}

}  // namespace quern
