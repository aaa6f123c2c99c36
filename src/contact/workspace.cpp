#include "src/contact/workspace.hpp"
#include <algorithm>

namespace quern {

void Workspace::fit(const ContactBlock& block, bool oriented) {
  const std::size_t particles = static_cast<std::size_t>(block.size()) + block.halo.size();
  if (position.size() < particles + 2)
    for (std::vector<Quad>* rows : {&position, &velocity, &spin}) rows->resize(particles + particles / 4 + 2);
  // The idle pair overlaps a little and has mass, so that its arithmetic stays finite.
  position[particles] = {0, 0, 0, 1};
  position[particles + 1] = {1.9, 0, 0, 1};
  velocity[particles] = velocity[particles + 1] = {0, 0, 0, 1};
  spin[particles] = spin[particles + 1] = {0, 0, 0, 1};
  if (oriented) {
    if (orientation.size() < particles + 2) orientation.resize(particles + particles / 4 + 2);
    orientation[particles] = orientation[particles + 1] = {0, 0, 0, 1};
  }
  std::size_t candidates = 0;
  for (const CandidateList& list : block.candidates) candidates = std::max(candidates, list.first.size());
  if (first.size() < candidates + list_padding)
    for (std::vector<Index>* indices : {&first, &second, &slot}) indices->resize(candidates + candidates / 4 + list_padding);
  if (oriented && overlap_at_rest.size() < first.size()) overlap_at_rest.resize(first.size());
}

}  // namespace quern
