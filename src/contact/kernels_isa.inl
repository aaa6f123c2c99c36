// The inner loops for one instruction set; each kernels_*.cpp includes this with its own QUERN_ISA and compiler flags.
#include <cstring>
#include "src/base/pack.hpp"
#include "src/contact/cell_grid.hpp"
#include "src/contact/kernels.hpp"
#include "src/contact/workspace.hpp"
#include "bonds/bond_forces.inl"

namespace quern::QUERN_ISA {
namespace {

using PackTriple = Triple<Pack>;

// Bit k: slot[k] ≥ 0.
QUERN_INLINE unsigned touched_before(const Index* slot) {
#if defined(__AVX2__)
  const __m256i s = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(slot));
  return ~static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(s))) & 0xffu;
#else
  unsigned r = 0;
  for (int k = 0; k < lanes; ++k) r |= static_cast<unsigned>(slot[k] >= 0) << k;
  return r;
#endif
}

// Contacts that begin and contacts that end, among eight candidates.
[[gnu::noinline]] void change(const StepContext& step, ContactBlock& block, CandidateList& list, Index at, unsigned now, unsigned changed) {
  for (; changed != 0; changed &= changed - 1) {
    const auto k = static_cast<std::size_t>(at + __builtin_ctz(changed));
    Index& slot = list.slot[k];
    if (now >> __builtin_ctz(changed) & 1u) {
      slot = block.take_slot();
    } else {
      if (block.records) end_collision(step, block, block.row_of(list.first[k]), block.row_of(list.second[k]), -1, slot, false);
      block.release_slot(slot);
      slot = -1;
    }
  }
}

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

// Lists the candidates that overlap now in the workspace; where a contact begins at an overlap, by more than that.
template <bool rests>
void find_touching(const StepContext& step, CandidateList& list, ContactBlock& block, Workspace& work) {
  const double* position = &work.position[0].x;
  Index active = 0;
  for (Index at = 0; at < list.count; at += lanes) {
    const Index *first = list.first.data() + at, *second = list.second.data() + at, *slot = list.slot.data() + at;
    const QuadPack i = gather(position, first), j = gather(position, second);
    const PackTriple apart = i.xyz() - j.xyz();
    Pack reach = i.w + j.w;
    if (rests) reach -= load(list.overlap_at_rest.data() + at);
    const unsigned valid = list.count - at >= lanes ? 0xffu : (1u << (list.count - at)) - 1u;
    const unsigned now = bits(dot(apart, apart) < reach * reach) & valid;
    const unsigned changed = (now ^ touched_before(slot)) & valid;
    if (changed != 0) change(step, block, list, at, now, changed);
    pick(first, now, work.first.data() + active);
    pick(second, now, work.second.data() + active);
    pick(slot, now, work.slot.data() + active);
    if (rests) pick(list.overlap_at_rest.data() + at, now, work.overlap_at_rest.data() + active);
    active += __builtin_popcount(now);
  }
  const Index idle = 4 * (block.size() + static_cast<Index>(block.halo.size()));
  for (Index k = active; k < active + list_padding; ++k) {
    const auto at = static_cast<std::size_t>(k);
    work.first[at] = idle, work.second[at] = idle + 4, work.slot[at] = 0;
    if (rests) work.overlap_at_rest[at] = 0;
  }
  work.active = active;
}

// A spring carried along with its contact plane: turned with the normal and with the bodies' common twist about it. Its length
// changes a little on the way.
QUERN_INLINE PackTriple turned(const PackTriple& stretch, const PackTriple& normal, const Pack& twist) {
  const PackTriple flat = stretch - dot(stretch, normal) * normal;
  return flat + twist * cross(normal, flat);
}

// Two bodies that touch.
struct Bodies {
  PackTriple normal;
  PackTriple relative_velocity;  // at the contact point
  PackTriple spin_difference;    // ω_i − ω_j
  PackTriple spin_sum;           // ω_i + ω_j
  Pack overlap, effective_radius, contact_radius, effective_mass, inverse_mass;
};

// Where contacts remember.
struct Springs {
  double *sliding, *rolling;
  explicit Springs(ContactBlock& block) : sliding(&block.sliding[0].x), rolling(block.rolls ? &block.rolling[0].x : nullptr) {}
};

// What a contact does, and what is written down of it.
struct Answer {
  PackTriple force;       // on body i
  PackTriple moment;      // rolling moment on body i
  PackTriple tangential;  // part of `force`
  Pack normal, elastic_energy, normal_loss, tangential_loss, rolling_loss;
};

// What the law sees of a contact.
struct Encounter {
  Approach<Pack> approach;
  TangentialSpring<Pack> spring;
  Pack twist;  // by which springs turned about the normal [rad]
};

// Carries the sliding spring along to where the bodies are now.
QUERN_INLINE void carry(const StepContext& step, const Bodies& bodies, const Springs& springs, const Index* slot, Encounter& result) {
  const PackTriple normal = bodies.normal;
  const Pack contact_overlap = bodies.overlap;
  const QuadPack sliding = gather(springs.sliding, slot, 4);
  const Pack one(1.0), zero(0.0), dt(step.time_step), tiny(1e-60);
  const Pack twist = Pack(0.5 * step.time_step) * dot(bodies.spin_sum, normal);
  const PackTriple stretch = turned(sliding.xyz(), normal, twist);

  const Pack normal_velocity = dot(bodies.relative_velocity, normal);
  const PackTriple tangential_velocity = bodies.relative_velocity - normal_velocity * normal;
  // One division for three reciprocals.
  const Pack closing = greater(-normal_velocity, tiny), overlap = greater(contact_overlap, tiny);
  const Pack turned_square = greater(dot(stretch, stretch), tiny);
  const Pack both = closing * overlap, reciprocal = one / (both * turned_square), of_both = reciprocal * turned_square;
  const Pack overlap_before = contact_overlap + normal_velocity * dt;
  const Pack since_touch = contact_overlap * (of_both * overlap);

  result.twist = twist;
  result.spring.stretch = stretch;
  result.spring.energy = sliding.w;
  result.spring.restoring = dot(sliding.xyz(), sliding.xyz()) * (reciprocal * both);
  result.approach.overlap = contact_overlap;
  result.approach.normal_velocity = normal_velocity;
  result.approach.tangential_velocity = tangential_velocity;
  result.approach.effective_radius = bodies.effective_radius;
  result.approach.contact_radius = bodies.contact_radius;
  result.approach.effective_mass = bodies.effective_mass;
  result.approach.inverse_mass = bodies.inverse_mass;
  result.approach.earlier = lesser(one, greater(zero, overlap_before) * (of_both * closing));
  result.approach.time_step = step.time_step;
  result.approach.lead = select(overlap_before < zero, since_touch, Pack(0.5 * step.time_step));
  result.approach.ahead = step.ahead;
}

// The chosen law and rolling model; updates the memory. Each value is made once and never copied as part of a struct: compilers put
// copied structs into memory.
template <class Law>
QUERN_INLINE void answer(const Law& law, const Rolling& rolling, const Bodies& bodies, Encounter& met, const Springs& springs, const Index* slot,
                         Answer& result) {
  const PackTriple normal = bodies.normal;
  const Pack zero(0.0);
  TangentialSpring<Pack> spring = met.spring;
  const ContactForce<Pack> contact = law(met.approach, spring);
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
  if (rolling.model == RollingModel::none) return;

  const QuadPack stored = gather(springs.rolling, slot, 4);
  const PackTriple angle = turned(stored.xyz(), normal, met.twist);
  TangentialSpring<Pack> roll{angle, stored.w, dot(stored.xyz(), stored.xyz()) / greater(dot(angle, angle), Pack(1e-60))};
  const PackTriple rolling_velocity = bodies.spin_difference - dot(bodies.spin_difference, normal) * normal;
  const HeldForce<Pack> held = rolling(met.approach, contact, rolling_velocity, roll);
  scatter_rows(QuadPack{roll.stretch.x, roll.stretch.y, roll.stretch.z, roll.energy},
               [&](int k) { return springs.rolling + 4 * static_cast<std::ptrdiff_t>(slot[k]); });
  result.moment = held.force;
  result.elastic_energy = contact.elastic_energy + roll.energy;
  result.rolling_loss = held.loss;
}

struct Sums {
  Pack elastic{0.0}, normal{0.0}, sliding{0.0}, rolling{0.0};
  QUERN_INLINE void add(const Answer& a, int count) {
    add_first(elastic, a.elastic_energy, count);
    add_first(normal, a.normal_loss, count);
    add_first(sliding, a.tangential_loss, count);
    add_first(rolling, a.rolling_loss, count);
  }
  void flush(StepSums& s) const {
    s.elastic_energy += sum(elastic);
    s.normal_loss += sum(normal);
    s.sliding_loss += sum(sliding);
    s.rolling_loss += sum(rolling);
  }
};

QUERN_INLINE void write_down(const StepContext& step, const Encounter& met, const Answer& a, CollisionRecord* record, const Index* slot, int count) {
  alignas(64) double vn[lanes], vt[lanes], fn[lanes], overlap[lanes], ln[lanes], lt[lanes], mass[lanes];
  store(vn, met.approach.normal_velocity);
  store(vt, length(met.approach.tangential_velocity));
  store(fn, a.normal);
  store(overlap, met.approach.overlap);
  store(ln, a.normal_loss);
  store(lt, a.tangential_loss + a.rolling_loss);
  store(mass, met.approach.effective_mass);
  for (int k = 0; k < count; ++k) {
    CollisionRecord& r = record[slot[k]];
    if (r.start_time < 0) {
      r.start_time = step.time;
      r.normal_speed = quern::greater(0.0, -vn[k]);
      r.tangential_speed = vt[k];
      r.effective_mass = mass[k];
    }
    r.peak_force = quern::greater(r.peak_force, fn[k]);
    r.peak_overlap = quern::greater(r.peak_overlap, overlap[k]);
    r.normal_loss += ln[k];
    r.tangential_loss += lt[k];
  }
}

// A batch of pairs on its way from the positions to the forces.
struct PairBatch {
  Bodies bodies;
  Pack arm_i, arm_j;  // from the centres to the contact point
  Encounter met;
  Answer answer;
};

template <bool rests>
QUERN_INLINE void meet(const Workspace& work, std::size_t at, PairBatch& batch) {
  const Index *i = work.first.data() + at, *j = work.second.data() + at;
  const double *position = &work.position[0].x, *velocity = &work.velocity[0].x, *spin = &work.spin[0].x;
  const QuadPack xi = gather(position, i), xj = gather(position, j);
  const QuadPack vi = gather(velocity, i), vj = gather(velocity, j);
  const QuadPack wi = gather(spin, i), wj = gather(spin, j);
  const PackTriple apart = xi.xyz() - xj.xyz();
  // One division for four reciprocals.
  const Pack distance = square_root(dot(apart, apart)), radii = xi.w + xj.w, masses = vi.w + vj.w, product = vi.w * vj.w;
  const Pack lengths = distance * radii, weights = masses * product, reciprocal = Pack(1.0) / (lengths * weights);
  const Pack of_lengths = reciprocal * weights, of_weights = reciprocal * lengths;
  const PackTriple normal = (of_lengths * radii) * apart;
  Pack overlap = greater(Pack(0.0), radii - distance);
  const Pack arm_i = xi.w - Pack(0.5) * overlap, arm_j = xj.w - Pack(0.5) * overlap;
  if (rests) overlap = greater(Pack(0.0), overlap - load(work.overlap_at_rest.data() + at));
  batch.bodies.normal = normal;
  batch.bodies.overlap = overlap;
  const Pack effective_radius = xi.w * xj.w * (of_lengths * distance);
  batch.bodies.effective_radius = effective_radius;
  batch.bodies.contact_radius = square_root(effective_radius * overlap);
  batch.bodies.effective_mass = product * (of_weights * product);
  batch.bodies.inverse_mass = masses * (of_weights * masses);
  batch.bodies.spin_difference = wi.xyz() - wj.xyz();
  batch.bodies.spin_sum = wi.xyz() + wj.xyz();
  batch.bodies.relative_velocity = vi.xyz() - vj.xyz() - cross(arm_i * wi.xyz() + arm_j * wj.xyz(), normal);
  batch.arm_i = arm_i;
  batch.arm_j = arm_j;
}

QUERN_INLINE void pull(const PairBatch& batch, const Index* i, const Index* j, double* loads) {
  const PackTriple force = batch.answer.force, moment = batch.answer.moment;
  const PackTriple twist = cross(batch.bodies.normal, batch.answer.tangential);
  const PackTriple on_i = moment - batch.arm_i * twist, on_j = (-batch.arm_j) * twist - moment;
  const Pack zero(0.0);
  add_double_rows(QuadPack{force.x, force.y, force.z, zero}, QuadPack{on_i.x, on_i.y, on_i.z, zero}, [&](int k) { return loads + 2 * i[k]; });
  add_double_rows(QuadPack{-force.x, -force.y, -force.z, zero}, QuadPack{on_j.x, on_j.y, on_j.z, zero},
                  [&](int k) { return loads + 2 * j[k]; });
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
        meet<true>(work, static_cast<std::size_t>(at), *batch++);
      else
        meet<false>(work, static_cast<std::size_t>(at), *batch++);
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

// Eight entries of an active list; a short last batch repeats its last contact in the lanes beyond `count`. Those lanes
// write to the scratch row of memory, so that a repeated contact is never advanced twice.
struct Batch {
  alignas(32) Index i[lanes], j[lanes], slot[lanes];
  int count;
  QUERN_INLINE Batch(const ActiveList& list, Index at) : count(list.size() - at < lanes ? list.size() - at : lanes) {
    for (int k = 0; k < lanes; ++k) {
      const auto from = static_cast<std::size_t>(at + (k < count ? k : count - 1));
      i[k] = list.first[from];
      j[k] = list.second[from];
      slot[k] = k < count ? list.slot[from] : 0;
    }
  }
};

template <class Law>
void wall_forces_of(const StepContext& step, const Law& law, const Rolling& rolling, const ActiveList& list, ContactBlock& block) {
  const Particles& p = *step.particles;
  const Springs springs(block);
  Sums sums;
  for (Index at = 0; at < list.size(); at += lanes) {
    const Batch batch(list, at);
    const WallTouch* touch = block.wall_touches.data();
    const auto rows_of_i = [&](const std::vector<Quad>& array) { return gather_rows([&](int k) { return &array[static_cast<std::size_t>(batch.i[k])].x; }); };
    const QuadPack xi = rows_of_i(p.position), vi = rows_of_i(p.velocity), wi = rows_of_i(p.spin);
    const QuadPack normal = gather_rows([&](int k) { return &touch[batch.j[k]].normal.x; });
    const QuadPack wall_velocity = gather_rows([&](int k) { return &touch[batch.j[k]].velocity.x; });
    const QuadPack wall_spin = gather_rows([&](int k) { return &touch[batch.j[k]].spin.x; });
    Bodies b;
    b.normal = normal.xyz();
    const Pack arm = xi.w - normal.w;
    b.spin_difference = wi.xyz() - wall_spin.xyz();
    b.spin_sum = wi.xyz() + wall_spin.xyz();
    b.relative_velocity = vi.xyz() - wall_velocity.xyz() - cross(arm * wi.xyz(), b.normal);
    b.overlap = normal.w;
    b.effective_radius = xi.w;
    b.contact_radius = square_root(xi.w * normal.w);
    b.effective_mass = vi.w;
    b.inverse_mass = Pack(1.0) / vi.w;
    Encounter met;
    carry(step, b, springs, batch.slot, met);
    Answer a;
    answer(law, rolling, b, met, springs, batch.slot, a);
    sums.add(a, batch.count);

    const PackTriple torque = a.moment - arm * cross(b.normal, a.tangential);
    const Pack zero(0.0);
    alignas(64) Quad force[lanes], moment[lanes], torques[lanes];
    scatter_rows({a.force.x, a.force.y, a.force.z, zero}, [&](int k) { return &force[k].x; });
    scatter_rows({a.moment.x, a.moment.y, a.moment.z, zero}, [&](int k) { return &moment[k].x; });
    scatter_rows({torque.x, torque.y, torque.z, zero}, [&](int k) { return &torques[k].x; });
    for (int k = 0; k < batch.count; ++k) {
      add(block.load[static_cast<std::size_t>(batch.i[k] - block.first)], {force[k], torques[k]});
      const WallTouch& t = touch[batch.j[k]];
      WallSums& wall = block.wall_sums[static_cast<std::size_t>(t.point.w)];
      const Triple<double> f = xyz(force[k]), m = xyz(moment[k]);
      wall.force = wall.force - f;
      wall.torque = wall.torque - cross(xyz(t.point), f) - m;
      block.sums.wall_work += step.time_step * (dot(f, xyz(t.velocity)) + dot(m, xyz(t.spin)));
    }
    if (block.records) write_down(step, met, a, block.record.data(), batch.slot, batch.count);
  }
  sums.flush(block.sums);
  block.sums.wall_contacts += list.size();
}

void pair_forces(const StepContext& step, const PairLaw& pair, CandidateList& list, ContactBlock& block, Workspace& work) {
  const bool rests = !list.overlap_at_rest.empty();
  if (rests)
    find_touching<true>(step, list, block, work);
  else
    find_touching<false>(step, list, block, work);
  std::visit([&](const auto& law) { pair_forces_of(step, law, pair.rolling, rests, block, work); }, pair.law);
}

void wall_forces(const StepContext& step, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  std::visit([&](const auto& law) { wall_forces_of(step, law, pair.rolling, list, block); }, pair.law);
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
const Kernels kernels{QUERN_NAME(QUERN_ISA), advance, turn, correct, load_block, pair_forces, wall_forces, bond_forces, find_near};

}  // namespace quern::QUERN_ISA
