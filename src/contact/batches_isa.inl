// What the kernels of contacts share: batches of touching pairs and walls on their way from the positions to the forces.
#include "src/base/pack.hpp"
#include "src/contact/kernels.hpp"
#include "src/contact/workspace.hpp"

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
      end_contact(step, block, block.row_of(list.first[k]), block.row_of(list.second[k]), -1, slot);
      slot = -1;
    }
  }
}

// Lists the candidates that overlap now in the workspace; where a contact begins at an overlap, by more than that, and where it
// reaches beyond touch, those within reach.
template <bool rests, bool reaches>
void find_touching(const StepContext& step, double beyond, CandidateList& list, ContactBlock& block, Workspace& work) {
  const double* position = &work.position[0].x;
  Index active = 0;
  for (Index at = 0; at < list.count; at += lanes) {
    const Index *first = list.first.data() + at, *second = list.second.data() + at, *slot = list.slot.data() + at;
    const QuadPack i = gather(position, first), j = gather(position, second);
    const PackTriple apart = i.xyz() - j.xyz();
    Pack reach = i.w + j.w;
    if (rests) reach -= load(list.overlap_at_rest.data() + at);
    if (reaches) reach += Pack(beyond);
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

// Rolling resistance under that force; updates the memory.
QUERN_INLINE void roll(const Rolling& rolling, const Bodies& bodies, const Encounter& met, const ContactForce<Pack>& contact, const Springs& springs,
                       const Index* slot, Answer& result) {
  const PackTriple normal = bodies.normal;
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

// `reaches`: bodies with a gap between them have a negative overlap.
template <bool rests, bool reaches>
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
  Pack overlap = radii - distance;
  if (!reaches) overlap = greater(Pack(0.0), overlap);
  const Pack arm_i = xi.w - Pack(0.5) * overlap, arm_j = xj.w - Pack(0.5) * overlap;
  if (rests) overlap -= load(work.overlap_at_rest.data() + at);
  if (rests && !reaches) overlap = greater(Pack(0.0), overlap);
  batch.bodies.normal = normal;
  batch.bodies.overlap = overlap;
  const Pack effective_radius = xi.w * xj.w * (of_lengths * distance);
  batch.bodies.effective_radius = effective_radius;
  batch.bodies.contact_radius = square_root(effective_radius * (reaches ? greater(Pack(0.0), overlap) : overlap));
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

// A batch of touches with walls.
template <bool reaches>
QUERN_INLINE void meet_walls(const Particles& p, const WallTouch* touch, const Batch& batch, Bodies& b, Pack& arm) {
  const auto rows_of_i = [&](const std::vector<Quad>& array) { return gather_rows([&](int k) { return &array[static_cast<std::size_t>(batch.i[k])].x; }); };
  const QuadPack xi = rows_of_i(p.position), vi = rows_of_i(p.velocity), wi = rows_of_i(p.spin);
  const QuadPack normal = gather_rows([&](int k) { return &touch[batch.j[k]].normal.x; });
  const QuadPack wall_velocity = gather_rows([&](int k) { return &touch[batch.j[k]].velocity.x; });
  const QuadPack wall_spin = gather_rows([&](int k) { return &touch[batch.j[k]].spin.x; });
  b.normal = normal.xyz();
  arm = xi.w - normal.w;
  b.spin_difference = wi.xyz() - wall_spin.xyz();
  b.spin_sum = wi.xyz() + wall_spin.xyz();
  b.relative_velocity = vi.xyz() - wall_velocity.xyz() - cross(arm * wi.xyz(), b.normal);
  b.overlap = normal.w;
  b.effective_radius = xi.w;
  b.contact_radius = square_root(xi.w * (reaches ? greater(Pack(0.0), normal.w) : normal.w));
  b.effective_mass = vi.w;
  b.inverse_mass = Pack(1.0) / vi.w;
}

QUERN_INLINE void push_walls(const StepContext& step, const Batch& batch, const Bodies& b, const Pack& arm, const Answer& a, ContactBlock& block) {
  const WallTouch* touch = block.wall_touches.data();
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
}

}  // namespace
}  // namespace quern::QUERN_ISA
