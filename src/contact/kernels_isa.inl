// The inner loops for one instruction set; each kernels_*.cpp includes this with its own QUERN_ISA and compiler flags.
#include <cstring>
#include "src/contact/cell_grid.hpp"
#include "src/contact/batches_isa.inl"
#include "bonds/bond_forces.inl"

namespace quern::QUERN_ISA {
namespace {

// Bit k: rows[k] > after.
QUERN_INLINE unsigned later(const Index* rows, Index after) {
#if defined(__AVX2__)
  const __m256i r = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rows));
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(r, _mm256_set1_epi32(after)))));
#else
  unsigned r = 0;
  for (int k = 0; k < lanes; ++k) r |= static_cast<unsigned>(rows[k] > after) << k;
  return r;
#endif
}

// The chosen law and rolling model; updates the memory. Each value is made once and never copied as part of a struct: compilers put
// copied structs into memory.
template <class Law>
QUERN_INLINE void answer(const Law& law, const Rolling& rolling, const Bodies& bodies, Encounter& met, const Springs& springs, const Index* slot,
                         Answer& result) {
  const PackTriple normal = bodies.normal;
  const Pack zero(0.0);
  TangentialSpring<Pack> spring = met.spring;
  const ContactForce<Pack> contact = act(law, met.approach, spring);
  scatter_rows(QuadPack{spring.stretch.x, spring.stretch.y, spring.stretch.z, spring.energy},
               [&](int k) { return springs.sliding + 4 * static_cast<std::ptrdiff_t>(slot[k]); });
  result.force = contact.normal * normal + contact.tangential;
  result.moment = {zero, zero, zero};
  result.tangential = contact.tangential;
  result.normal = contact.normal;
  result.elastic_energy = contact.elastic_energy;
  result.normal_loss = contact.normal_loss;
  result.tangential_loss = contact.tangential_loss;
  result.rolling_loss = zero;
  if (rolling.model != RollingModel::none) roll(rolling, bodies, met, contact, springs, slot, result);
}

// A chunk of batches goes through each stage together: their square roots and divisions wait for nothing but their own batch, and
// a processor that looks some hundred instructions ahead works on several batches at a time.
template <class Law>
void pair_forces_of(const StepContext& context, const Law& chosen, const Rolling& chosen_rolling, bool rests, ContactBlock& block, Workspace& work) {
  // Copies that no store can touch stay in registers.
  const StepContext step = context;
  const Law law = chosen;
  const Rolling rolling = chosen_rolling;
  const Springs springs(block);
  const Index active = work.active;
  constexpr int chunk = 8;
  PairBatch batches[chunk];
  double* loads = &block.load[0].force.x;
  Sums sums;
  for (Index from = 0; from < active; from += chunk * lanes) {
    const Index to = active - from < chunk * lanes ? active : from + chunk * lanes;
    PairBatch* batch = batches;
    for (Index at = from; at < to; at += lanes) {
      for (int k = 0; k < lanes; ++k) __builtin_prefetch(springs.sliding + 4 * static_cast<std::ptrdiff_t>(work.slot[static_cast<std::size_t>(at + k)]), 1);
      if (rests)
        meet<true, false>(work, static_cast<std::size_t>(at), *batch++);
      else
        meet<false, false>(work, static_cast<std::size_t>(at), *batch++);
    }
    batch = batches;
    for (Index at = from; at < to; at += lanes, ++batch) carry(step, batch->bodies, springs, work.slot.data() + at, batch->met);
    batch = batches;
    for (Index at = from; at < to; at += lanes, ++batch) {
      answer(law, rolling, batch->bodies, batch->met, springs, work.slot.data() + at, batch->answer);
      sums.add(batch->answer, to - at < lanes ? to - at : lanes);
    }
    batch = batches;
    for (Index at = from; at < to; at += lanes) pull(*batch++, work.first.data() + at, work.second.data() + at, loads);
    if (!block.records) continue;
    batch = batches;
    for (Index at = from; at < to; at += lanes, ++batch)
      write_down(step, batch->met, batch->answer, block.record.data(), work.slot.data() + at, to - at < lanes ? to - at : lanes);
  }
  sums.flush(block.sums);
  block.sums.pair_contacts += active;
}

template <class Law>
void wall_forces_of(const StepContext& step, const Law& law, const Rolling& rolling, const ActiveList& list, ContactBlock& block) {
  const Particles& p = *step.particles;
  const Springs springs(block);
  Sums sums;
  for (Index at = 0; at < list.size(); at += lanes) {
    const Batch batch(list, at);
    Bodies b;
    Pack arm;
    meet_walls<false>(p, block.wall_touches.data(), batch, b, arm);
    Encounter met;
    carry(step, b, springs, batch.slot, met);
    Answer a;
    answer(law, rolling, b, met, springs, batch.slot, a);
    sums.add(a, batch.count);
    push_walls(step, batch, b, arm, a, block);
    if (block.records) write_down(step, met, a, block.record.data(), batch.slot, batch.count);
  }
  sums.flush(block.sums);
  block.sums.wall_contacts += list.size();
}

void pair_forces(const StepContext& step, const PairLaw& pair, CandidateList& list, ContactBlock& block, Workspace& work) {
  if (pair.extras.any()) return pair_forces_with_effects(step, pair, list, block, work);
  const bool rests = !list.overlap_at_rest.empty();
  if (rests)
    find_touching<true, false>(step, 0, list, block, work);
  else
    find_touching<false, false>(step, 0, list, block, work);
  std::visit([&](const auto& law) { pair_forces_of(step, law, pair.rolling, rests, block, work); }, pair.law);
}

void wall_forces(const StepContext& step, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  if (pair.extras.any()) return wall_forces_with_effects(step, pair, list, block);
  std::visit([&](const auto& law) { wall_forces_of(step, law, pair.rolling, list, block); }, pair.law);
}

template <class Law>
void shape_forces_of(const StepContext& step, const Law& law, const Rolling& rolling, ShapeTouch* touches, Index count, ContactBlock& block) {
  const Springs springs(block);
  Sums sums;
  for (Index at = 0; at < count; at += lanes) {
    const int used = count - at < lanes ? count - at : lanes;
    // A short last batch repeats its last contact, with the scratch row for memory.
    const auto touch = [&](int k) -> ShapeTouch& { return touches[at + (k < used ? k : used - 1)]; };
    const auto rows = [&](Quad ShapeTouch::*part) { return gather_rows([&](int k) { return &(touch(k).*part).x; }); };
    alignas(32) Index slot[lanes];
    for (int k = 0; k < lanes; ++k) slot[k] = k < used ? touch(k).slot : 0;
    const QuadPack normal = rows(&ShapeTouch::normal);
    Bodies b;
    b.normal = normal.xyz();
    b.overlap = normal.w;
    b.effective_radius = rows(&ShapeTouch::arm_i).w;
    b.contact_radius = square_root(b.effective_radius * b.overlap);
    b.effective_mass = rows(&ShapeTouch::arm_j).w;
    b.inverse_mass = Pack(1.0) / b.effective_mass;
    b.relative_velocity = rows(&ShapeTouch::velocity).xyz();
    b.spin_difference = rows(&ShapeTouch::spin_difference).xyz();
    b.spin_sum = rows(&ShapeTouch::spin_sum).xyz();
    Encounter met;
    carry(step, b, springs, slot, met);
    Answer a;
    answer(law, rolling, b, met, springs, slot, a);
    sums.add(a, used);
    const Pack zero(0.0);
    alignas(64) Quad force[lanes], moment[lanes];
    scatter_rows({a.force.x, a.force.y, a.force.z, zero}, [&](int k) { return &force[k].x; });
    scatter_rows({a.moment.x, a.moment.y, a.moment.z, zero}, [&](int k) { return &moment[k].x; });
    for (int k = 0; k < used; ++k) touch(k).force = force[k], touch(k).moment = moment[k];
    if (block.records) write_down(step, met, a, block.record.data(), slot, used);
  }
  sums.flush(block.sums);
}

void shape_forces(const StepContext& step, const PairLaw& pair, ShapeTouch* touches, Index count, ContactBlock& block) {
  std::visit([&](const auto& law) { shape_forces_of(step, law, pair.rolling, touches, count, block); }, pair.law);
}

void load_block(const StepContext& step, ContactBlock& block, Workspace& work) {
  const Particles& p = *step.particles;
  const auto first = static_cast<std::size_t>(block.first), own = static_cast<std::size_t>(block.size());
  const std::size_t halo = block.halo.size();
  if (!p.orientation.empty()) {
    std::memcpy(work.orientation.data(), p.orientation.data() + first, own * sizeof(Quad));
    for (std::size_t k = 0; k < halo; ++k) work.orientation[own + k] = p.orientation[static_cast<std::size_t>(block.halo[k].row)];
  }
  std::memcpy(work.position.data(), p.position.data() + first, own * sizeof(Quad));
  std::memcpy(work.velocity.data(), p.velocity.data() + first, own * sizeof(Quad));
  std::memcpy(work.spin.data(), p.spin.data() + first, own * sizeof(Quad));
  for (std::size_t k = 0; k < halo; ++k) {
    const std::size_t ahead = static_cast<std::size_t>(block.halo[k + 8 < halo ? k + 8 : k].row);
    __builtin_prefetch(p.position.data() + ahead);
    __builtin_prefetch(p.velocity.data() + ahead);
    __builtin_prefetch(p.spin.data() + ahead);
    const auto [row, image] = block.halo[k];
    Quad& x = work.position[own + k];
    x = p.position[static_cast<std::size_t>(row)];
    work.velocity[own + k] = p.velocity[static_cast<std::size_t>(row)];
    work.spin[own + k] = p.spin[static_cast<std::size_t>(row)];
    if (image != Domain::itself) {
      const Triple<double> shift = step.domain->shift(image);
      x.x += shift.x, x.y += shift.y, x.z += shift.z;
    }
  }
  std::memset(static_cast<void*>(block.load.data()), 0, block.load.size() * sizeof(Load));
}

// Two particles to a register: lanes 3 and 7 are the companions and stay as they are.
alignas(64) constexpr double moving[lanes] = {1, 1, 1, 0, 1, 1, 1, 0};

double advance(Particles& p, Index first, Index last, double dt) {
  const Pack mask = load(moving), step = Pack(dt) * mask, half = Pack(0.5 * dt);
  double* x = &p.position[0].x;
  double* v = &p.velocity[0].x;
  double* w = &p.spin[0].x;
  const double *a = &p.acceleration[0].x, *b = &p.angular_acceleration[0].x;
  Pack largest(0.0), broken(0.0);
  const auto move = [&](std::size_t at, auto get, auto put) {
    const Pack va = get(v + at), aa = get(a + at);
    const Pack moved = step * (va + half * aa);
    put(x + at, get(x + at) + moved);
    put(v + at, va + step * aa);
    put(w + at, get(w + at) + step * get(b + at));
    const Pack squared = sum_of_four(moved * moved);
    largest = greater(largest, squared);
    broken += squared - squared;
  };
  const auto end = 4 * static_cast<std::size_t>(last);
  std::size_t at = 4 * static_cast<std::size_t>(first);
  for (; at + lanes <= end; at += lanes) move(at, [](const double* from) { return load(from); }, [](double* to, const Pack& q) { store(to, q); });
  if (at < end) move(at, [](const double* from) { return load_four(from); }, [](double* to, const Pack& q) { store_four(to, q); });
  alignas(64) double squares[lanes];
  store(squares, largest);
  const double wrong = sum(broken);
  const double most = quern::greater(squares[0], squares[4]);
  return wrong == 0 && most < 1e300 ? std::sqrt(most) : NAN;
}

void correct(Particles& p, const ContactBlock& block, double dt, const Triple<double>& gravity) {
  alignas(64) const double g[lanes] = {gravity.x, gravity.y, gravity.z, 0, gravity.x, gravity.y, gravity.z, 0};
  const Pack mask = load(moving), half = Pack(0.5 * dt) * mask, field = load(g);
  double* v = &p.velocity[0].x;
  double* w = &p.spin[0].x;
  double *a = &p.acceleration[0].x, *b = &p.angular_acceleration[0].x;
  const double* loads = &block.load[0].force.x;
  // Force and torque of a particle lie in one row: two rows of them make one of forces and one of torques.
  const auto complete = [&](std::size_t at, const Pack& force, const Pack& torque, auto get, auto put) {
    const Pack a_old = get(a + at), b_old = get(b + at);
    const Pack a_new = force * companion(a_old) + field, b_new = torque * companion(b_old);
    put(v + at, get(v + at) + half * (a_new - a_old));
    put(w + at, get(w + at) + half * (b_new - b_old));
    put(a + at, keep_companion(a_new, a_old));
    put(b + at, keep_companion(b_new, b_old));
  };
  const auto begin = 4 * static_cast<std::size_t>(block.first), end = 4 * static_cast<std::size_t>(block.last);
  std::size_t at = begin;
  for (; at + lanes <= end; at += lanes) {
    const double* row = loads + 2 * (at - begin);
    complete(at, load_two_fours(row, row + 8), load_two_fours(row + 4, row + 12), [](const double* from) { return load(from); },
             [](double* to, const Pack& q) { store(to, q); });
  }
  if (at < end) {
    const double* row = loads + 2 * (at - begin);
    complete(at, load_four(row), load_four(row + 4), [](const double* from) { return load_four(from); },
             [](double* to, const Pack& q) { store_four(to, q); });
  }
}

template <bool periodic>
void find_near_in(const Domain& domain, const CellGrid& grid, const Quad& centre, double skin, Index i, Found& found) {
  const double *x = grid.x.data(), *y = grid.y.data(), *z = grid.z.data(), *radius = grid.radius.data();
  const Index* rows = grid.row.data();
  const PackTriple period = {Pack(domain.period[0]), Pack(domain.period[1]), Pack(domain.period[2])};
  const PackTriple inverse = {Pack(domain.inverse(0)), Pack(domain.inverse(1)), Pack(domain.inverse(2))};
  const PackTriple here = {Pack(centre.x), Pack(centre.y), Pack(centre.z)};
  const Pack base(centre.w + skin);
  for_runs_near(grid, centre, centre.w + grid.largest_radius + skin, [&](Index from, Index to) {
    if (found.row.size() < static_cast<std::size_t>(found.count + (to - from) + lanes)) found.reserve(to - from + lanes);
    Index* row = found.row.data() + found.count;
    Index* image = found.image.data() + found.count;
    for (Index at = from; at < to; at += lanes) {
      PackTriple apart = {here.x - load(x + at), here.y - load(y + at), here.z - load(z + at)};
      PackTriple turns;
      if (periodic) {
        turns = {nearest_integer(apart.x * inverse.x), nearest_integer(apart.y * inverse.y), nearest_integer(apart.z * inverse.z)};
        apart = {apart.x - period.x * turns.x, apart.y - period.y * turns.y, apart.z - period.z * turns.z};
      }
      const Pack reach = base + load(radius + at);
      unsigned near = bits(dot(apart, apart) < reach * reach) & later(rows + at, i);
      if (to - at < lanes) near &= (1u << (to - at)) - 1u;
      pick(rows + at, near, row);
      if (periodic) {
        const Pack number = Pack(Domain::itself) + turns.x + Pack(3.0) * turns.y + Pack(9.0) * turns.z;
        alignas(64) Index numbers[lanes];
        store_integers(numbers, number);
        pick(numbers, near, image);
      } else {
        for (int k = 0; k < lanes; ++k) image[k] = Domain::itself;
      }
      const int count = __builtin_popcount(near);
      row += count;
      image += count;
    }
    found.count = static_cast<Index>(row - found.row.data());
  });
}

void find_near(const Domain& domain, const CellGrid& grid, const Quad& centre, double skin, Index i, Found& found) {
  if (domain.periodic())
    find_near_in<true>(domain, grid, centre, skin, i, found);
  else
    find_near_in<false>(domain, grid, centre, skin, i, found);
}

}  // namespace

#define QUERN_TEXT(x) #x
#define QUERN_NAME(x) QUERN_TEXT(x)
const Kernels kernels{QUERN_NAME(QUERN_ISA), advance, turn, correct, load_block, pair_forces, wall_forces, shape_forces, bond_forces, find_near};

}  // namespace quern::QUERN_ISA
