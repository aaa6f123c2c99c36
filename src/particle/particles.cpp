#include "src/particle/particles.hpp"
#include <cmath>
#include <numbers>
#include "shapes/superquadric.hpp"

namespace quern {
namespace {

constexpr Quad unturned{0, 0, 0, 1};

}  // namespace

Index Particles::add_sphere(const Triple<double>& centre, double r, double density, std::uint8_t material_index, std::uint8_t species_index) {
  const double m = 4.0 / 3.0 * std::numbers::pi * r * r * r * density;
  position.push_back({centre.x, centre.y, centre.z, r});
  velocity.push_back({0, 0, 0, m});
  spin.push_back({0, 0, 0, 0.4 * m * r * r});
  acceleration.push_back({0, 0, 0, 1 / m});
  angular_acceleration.push_back({0, 0, 0, 1 / (0.4 * m * r * r)});
  material.push_back(material_index);
  species.push_back(species_index);
  id.push_back(size() - 1);
  if (!orientation.empty()) orientation.push_back(unturned);
  if (!shape.empty()) shape.push_back(0), momentum.push_back({}), inertia.push_back({});
  return owned++;
}

Index Particles::add_shape(const Triple<double>& centre, const Superquadric& form, std::uint8_t shape_index, double size, double density,
                           std::uint8_t material_index, std::uint8_t species_index) {
  const Index row = add_sphere(centre, size * form.bounding_radius, density, material_index, species_index);
  const auto at = static_cast<std::size_t>(row);
  keep_orientations();
  shape.resize(position.size(), 0);
  momentum.resize(position.size());
  inertia.resize(position.size());
  const double mass = density * size * size * size * form.volume;
  const Vec3 moments = density * std::pow(size, 5) * form.inertia;
  velocity[at].w = mass;
  acceleration[at].w = 1 / mass;
  spin[at].w = moments.mean();
  angular_acceleration[at].w = 1;
  shape[at] = shape_index;
  inertia[at] = {moments.x(), moments.y(), moments.z(), 0};
  return row;
}

void Particles::keep_orientations() {
  if (orientation.empty()) orientation.assign(position.size(), unturned);
}

void Particles::reorder(const std::vector<Index>& order) {
  const auto permute = [&order](auto& array) {
    auto old = array;
    for (std::size_t k = 0; k < order.size(); ++k) array[k] = old[static_cast<std::size_t>(order[k])];
  };
  permute(position);
  permute(velocity);
  permute(spin);
  permute(acceleration);
  permute(angular_acceleration);
  permute(material);
  permute(species);
  permute(id);
  if (!orientation.empty()) permute(orientation);
  if (!shape.empty()) permute(shape), permute(momentum), permute(inertia);
}

}  // namespace quern
