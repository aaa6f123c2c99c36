// The tables and headline numbers of fragments, failures and cracks, from the state at one instant.
#pragma once
#include <utility>
#include "src/observe/fragments.hpp"

namespace quern {

struct FragmentView {
  const Simulation& simulation;
  const std::vector<Damage>& series;          // up to this instant
  const std::vector<ProductSize>& sieved;     // until now; what is missing at this instant is added
  const std::map<Index, double>& body_size;   // sieve size at the start, by body [m]
  const Vec3& direction;                      // unit
  const std::string& direction_name;
};

// As the fragments are now.
ProductSize product_size(const Simulation& simulation);

std::pair<std::vector<Headline>, std::vector<Table>> fragment_results(const FragmentView& view);

}  // namespace quern
