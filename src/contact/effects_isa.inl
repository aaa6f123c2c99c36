// The kernels of pairs with effects, for one instruction set; each effects_*.cpp includes this as kernels_*.cpp do theirs.
#include "src/contact/batches_isa.inl"
#include "src/contact/with_effects.hpp"

namespace quern::QUERN_ISA {
namespace {

// The law, its effects and the rolling model; updates the memory.
template <class Law>
QUERN_INLINE void answer_with_effects(const Law& law, const PairLaw& pair, const Bodies& bodies, const Encounter& met, const Springs& springs, double* effects,
                                      const Index* slot, Answer& result) {
  const PackTriple normal = bodies.normal;
  const QuadPack before = gather(effects, slot, 8), last = gather(effects + 4, slot, 8);
  Remembered<Pack> memory{before.x, before.y, before.z, before.w, last.x, last.y, last.z, last.w};
  TangentialSpring<Pack> spring = met.spring;
  EffectForce<Pack> force;
  act_with_effects(law, pair.extras, met.approach, dot(bodies.spin_difference, normal), memory, spring, force);
  const auto row = [&](double* of, int width) { return [=](int k) { return of + width * static_cast<std::ptrdiff_t>(slot[k]); }; };
  scatter_rows(QuadPack{spring.stretch.x, spring.stretch.y, spring.stretch.z, spring.energy}, row(springs.sliding, 4));
  scatter_rows(QuadPack{memory.touching, memory.greatest, memory.rod_end, memory.age}, row(effects, 8));
  scatter_rows(QuadPack{memory.energy, memory.force, memory.velocity, memory.torsion}, row(effects + 4, 8));
  ContactForce<Pack>& contact = force.contact;
  result.force = contact.normal * normal + contact.tangential;
  result.moment = {Pack(0.0), Pack(0.0), Pack(0.0)};
  result.tangential = contact.tangential;
  result.normal = contact.normal;
  result.elastic_energy = contact.elastic_energy;
  result.normal_loss = contact.normal_loss;
  result.tangential_loss = contact.tangential_loss;
  result.rolling_loss = Pack(0.0);
  contact.normal = force.pressing;
  if (pair.rolling.model != RollingModel::none) {
    Encounter rolling = met;
    rolling.approach.lead = force.lead;
    roll(pair.rolling, bodies, rolling, contact, springs, slot, result);
  }
  result.moment = result.moment + force.torsion * normal;
  result.rolling_loss += force.torsion_loss;
}

// Collisions begin where bodies touch, not where an effect reaches them.
void write_down_touching(const StepContext& step, const Encounter& met, const Answer& a, CollisionRecord* record, const Index* slot, int count) {
  alignas(64) double overlap[lanes];
  store(overlap, met.approach.overlap);
  alignas(32) Index place[lanes];
  for (int k = 0; k < lanes; ++k) place[k] = k < count && (overlap[k] > 0 || record[slot[k]].start_time >= 0) ? slot[k] : 0;
  write_down(step, met, a, record, place, count);
}

template <class Law>
void pair_forces_of(const StepContext& step, const Law& law, const PairLaw& pair, bool rests, ContactBlock& block, Workspace& work) {
  const Springs springs(block);
  double *loads = &block.load[0].force.x, *effects = &block.effects[0].x;
  Sums sums;
  for (Index at = 0; at < work.active; at += lanes) {
    const Index* slot = work.slot.data() + at;
    const int count = work.active - at < lanes ? work.active - at : lanes;
    PairBatch batch;
    if (rests)
      meet<true, true>(work, static_cast<std::size_t>(at), batch);
    else
      meet<false, true>(work, static_cast<std::size_t>(at), batch);
    carry(step, batch.bodies, springs, slot, batch.met);
    answer_with_effects(law, pair, batch.bodies, batch.met, springs, effects, slot, batch.answer);
    sums.add(batch.answer, count);
    pull(batch, work.first.data() + at, work.second.data() + at, loads);
    if (block.records) write_down_touching(step, batch.met, batch.answer, block.record.data(), slot, count);
  }
  sums.flush(block.sums);
  block.sums.pair_contacts += work.active;
}

template <class Law>
void wall_forces_of(const StepContext& step, const Law& law, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  const Springs springs(block);
  double* effects = &block.effects[0].x;
  Sums sums;
  for (Index at = 0; at < list.size(); at += lanes) {
    const Batch batch(list, at);
    Bodies b;
    Pack arm;
    meet_walls<true>(*step.particles, block.wall_touches.data(), batch, b, arm);
    Encounter met;
    carry(step, b, springs, batch.slot, met);
    Answer a;
    answer_with_effects(law, pair, b, met, springs, effects, batch.slot, a);
    sums.add(a, batch.count);
    push_walls(step, batch, b, arm, a, block);
    if (block.records) write_down_touching(step, met, a, block.record.data(), batch.slot, batch.count);
  }
  sums.flush(block.sums);
  block.sums.wall_contacts += list.size();
}

}  // namespace

void pair_forces_with_effects(const StepContext& step, const PairLaw& pair, CandidateList& list, ContactBlock& block, Workspace& work) {
  const bool rests = !list.overlap_at_rest.empty();
  if (rests)
    find_touching<true, true>(step, pair.reach, list, block, work);
  else
    find_touching<false, true>(step, pair.reach, list, block, work);
  std::visit([&](const auto& law) { pair_forces_of(step, law, pair, rests, block, work); }, pair.law);
}

void wall_forces_with_effects(const StepContext& step, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  std::visit([&](const auto& law) { wall_forces_of(step, law, pair, list, block); }, pair.law);
}

}  // namespace quern::QUERN_ISA
