#include "src/particle/particles.hpp"
#include <numbers>

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
  return owned++;
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
}

}  // namespace quern
