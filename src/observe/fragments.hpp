// What becomes of bodies of bonded grains: damage against time, the fragments at the end, every failure of a bond, and which way cracks face.
// Only where the simulation has bonds.
#pragma once
#include <map>
#include "bonds/fragments.hpp"
#include "src/base/vec.hpp"
#include "src/engine/simulation.hpp"
#include "src/grinding/schuhmann.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

// How broken everything is.
struct Damage {
  double time = 0;                       // [s]
  double ratio = 0;                      // bonds that failed over all that were made
  double tension = 0, shear = 0;         // failures so far, by mode
  double fragments = 0;                  // how many
  double largest = 0;                    // mass of each body's largest fragment, summed over the bodies, as a fraction of all
  double fines = 0;                      // mass of the single grains as a fraction of all
  double bond_energy = 0, released = 0;  // in intact bonds; in those that failed, when they did [J]
  double kinetic = 0;                    // of the grains, spin included [J]
};

// Sieve sizes that 80 and 50 % of the mass pass.
struct ProductSize {
  double time = 0;          // [s]
  double d80 = 0, d50 = 0;  // [m]
};

struct Fragmentation {
  std::vector<Damage> series;
  std::vector<ProductSize> sizes;     // with every twentieth row of the series: sieving takes its time
  std::map<Index, double> body_size;  // sieve size at the start, by body [m]
  Vec3 direction = Vec3::UnitZ();     // with which that of cracks is compared; unit
  std::string direction_name;
  double next = 0;                    // sample [s]
  bool began = false;

  void see(const Simulation& simulation, const ObserverSettings& settings);
  // Looks at the fragments of this instant; the run may go on.
  void finish(const Simulation& simulation);
  // As of the last finish(). Empty without bonds.
  const std::vector<Headline>& headlines() const { return headlines_; }
  const std::vector<Table>& tables() const { return tables_; }

  template <class Archive>
  void archive(Archive& a) {
    a(series, sizes, body_size, direction[0], direction[1], direction[2], direction_name, next, began);
  }

 private:
  void begin(const Simulation& simulation, const ObserverSettings& settings);
  Damage damage_of(const Simulation& simulation);

  Damage counted_;                 // how broken it was when so many bonds had failed
  std::size_t counted_failures_ = static_cast<std::size_t>(-1);
  std::vector<Headline> headlines_;
  std::vector<Table> tables_;
};

}  // namespace quern
