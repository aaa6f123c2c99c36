#include "src/field/fields.hpp"

namespace quern {

double apply_fields(const std::vector<Field>& fields, double time, double time_step, const Particles& particles, Index first, Index last,
                    Load* load) {
  double power = 0;
  for (const Field& field : fields) {
    std::visit(
        [&](const auto& one) {
          const auto now = one.at(time, time_step);
          for (Index i = first; i < last; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const FieldLoad found = now(particles.position[k], particles.velocity[k], particles.spin[k]);
            add(load[i - first].force, found.force);
            add(load[i - first].torque, found.torque);
            power += found.force.dot(vec(particles.velocity[k])) + found.torque.dot(vec(particles.spin[k]));
          }
        },
        field);
  }
  return power;
}

}  // namespace quern
