#include "src/contact/kernels.hpp"
#include <cstring>
#include "src/base/instruction_set.hpp"

namespace quern {

const Kernels* find_kernels(const char* name) {
#if defined(__x86_64__)
  if (std::strcmp(name, "avx512") == 0 && supports(InstructionSet::avx512)) return &avx512::kernels;
  if (std::strcmp(name, "avx2") == 0 && supports(InstructionSet::avx2)) return &avx2::kernels;
#endif
  return std::strcmp(name, "portable") == 0 ? &portable::kernels : nullptr;
}

const Kernels& best_kernels() {
  for (const char* name : {"avx512", "avx2"})
    if (const Kernels* found = find_kernels(name)) return *found;
  return portable::kernels;
}

void Found::reserve(Index room) {
  const auto wanted = static_cast<std::size_t>(count) + static_cast<std::size_t>(room);
  if (row.size() < wanted) row.resize(2 * wanted), image.resize(2 * wanted);
}

void end_contact(const StepContext& step, ContactBlock& block, Index i, Index j, Index wall, Index slot) {
  if (block.remembers) {
    const Quad& last = block.effects[2 * static_cast<std::size_t>(slot) + 1];  // energy, force and velocity along the normal
    const double normal = last.x - 0.5 * step.time_step * last.y * last.z, tangential = block.sliding[static_cast<std::size_t>(slot)].w;
    block.sums.normal_loss += normal;
    block.sums.sliding_loss += tangential;
    if (block.records) {
      CollisionRecord& record = block.record[static_cast<std::size_t>(slot)];
      record.normal_loss += normal, record.tangential_loss += tangential;
    }
  }
  end_collision(step, block, i, j, wall, slot, false);
  block.release_slot(slot);
}

void end_collision(const StepContext& step, ContactBlock& block, Index i, Index j, Index wall, Index slot, bool lasting) {
  if (!block.records) return;
  const CollisionRecord& record = block.record[static_cast<std::size_t>(slot)];
  if (record.start_time < 0) return;
  const Particles& p = *step.particles;
  const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
  Collision c;
  c.first_id = p.id[a];
  c.second_id = wall < 0 ? p.id[b] : -1 - wall;
  c.first_species = p.species[a];
  c.second_species = wall < 0 ? p.species[b] : 255;
  c.lasting = lasting;
  c.end_time = step.time;
  c.first_mass = p.velocity[a].w;
  c.force = block.remembers ? block.effects[2 * static_cast<std::size_t>(slot) + 1].y : 0;
  c.place = xyz(p.position[a]);
  if (wall < 0) {
    const Triple<double> apart = step.domain->nearest(xyz(p.position[b]) - xyz(p.position[a]));
    c.place = c.place + p.position[a].w / (p.position[a].w + p.position[b].w) * apart;
  }
  c.record = record;
  block.collisions.push_back(c);
}

}  // namespace quern
