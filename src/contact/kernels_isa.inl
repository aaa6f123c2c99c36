// The inner loops for one instruction set; each kernels_*.cpp includes this with its own QUERN_ISA and compiler flags.
#include "src/base/pack.hpp"
#include "src/contact/kernels.hpp"

namespace quern::QUERN_ISA {
namespace {

using PackTriple = Triple<Pack>;

struct Space {
  Pack px, py, pz, ix, iy, iz;
  bool periodic;
  explicit Space(const Domain& d)
      : px(d.period[0]), py(d.period[1]), pz(d.period[2]), ix(d.inverse(0)), iy(d.inverse(1)), iz(d.inverse(2)), periodic(d.periodic()) {}
  QUERN_INLINE PackTriple nearest(PackTriple d) const {
    if (!periodic) return d;
    return {d.x - px * nearest_integer(d.x * ix), d.y - py * nearest_integer(d.y * iy), d.z - pz * nearest_integer(d.z * iz)};
  }
};

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

void find_touching(const StepContext& step, ContactBlock& block) {
  const Particles& particles = *step.particles;
  const Quad* position = particles.position.data();
  const std::uint8_t* material = particles.material.data();
  const Space space(*step.domain);
  for (ActiveList& list : block.pairs) list.clear();
  for (Index i = block.first; i < block.last; ++i) {
    const Index from = block.row_start[static_cast<std::size_t>(i - block.first)], to = block.row_start[static_cast<std::size_t>(i - block.first) + 1];
    const Quad& here = position[i];
    for (Index k = from; k < to; k += lanes) {
      const Index* js = block.neighbour.data() + k;
      Index* slots = block.slot.data() + k;
      // Neighbours lie all over the arrays: ask for those of some rows ahead, and below for all that the forces will want.
      for (int lane = 0; lane < lanes; ++lane) __builtin_prefetch(position + js[lane + candidates_ahead]);
      const unsigned valid = to - k >= lanes ? 0xffu : (1u << (to - k)) - 1u;
      const QuadPack other = gather(position, js);
      const PackTriple apart = space.nearest({Pack(here.x) - other.x, Pack(here.y) - other.y, Pack(here.z) - other.z});
      const Pack reach = Pack(here.w) + other.w;
      const unsigned now = bits(dot(apart, apart) < reach * reach) & valid;
      unsigned visit = (now | touched_before(slots)) & valid;
      while (visit != 0) {
        const int lane = __builtin_ctz(visit);
        visit &= visit - 1;
        const Index j = js[lane];
        if (now >> lane & 1u) {
          if (slots[lane] < 0) slots[lane] = block.take_slot();
          block.pairs[step.pair_kind[material[i] * step.material_count + material[j]]].push(i, j, slots[lane]);
          __builtin_prefetch(block.memory.data() + slots[lane], 1);
          __builtin_prefetch(particles.velocity.data() + j);
          __builtin_prefetch(particles.spin.data() + j);
          __builtin_prefetch(particles.force.data() + j, 1);
          __builtin_prefetch(particles.torque.data() + j, 1);
        } else {
          end_collision(step, block, i, j, -1, slots[lane], false);
          block.release_slot(slots[lane]);
          slots[lane] = -1;
        }
      }
    }
  }
}

// A spring carried along with its contact plane: turned with the normal and with the bodies' common twist about it, its
// length kept.
QUERN_INLINE PackTriple carry(const PackTriple& stretch, const PackTriple& normal, const Pack& twist) {
  const Pack length_squared = dot(stretch, stretch);
  const PackTriple flat = stretch - dot(stretch, normal) * normal;
  const PackTriple turned = flat + twist * cross(normal, flat);
  const Pack turned_squared = dot(turned, turned);
  return square_root(length_squared / greater(turned_squared, Pack(1e-300))) * turned;
}

struct Bodies {
  PackTriple normal;
  Approach<Pack> approach;
  PackTriple spin_difference;  // ω_i − ω_j
  PackTriple spin_sum;         // ω_i + ω_j
};

struct Answer {
  ContactForce<Pack> contact;
  PackTriple force;   // on body i
  PackTriple moment;  // rolling moment on body i
  Pack rolling_loss;
};

// The chosen law and rolling model on eight contacts; updates their memory.
template <class Law>
QUERN_INLINE Answer answer(const Law& law, const Rolling& rolling, const Bodies& b, ContactMemory* memory, const Index* slot) {
  const QuadPack sliding = gather_rows([&](int k) { return &memory[slot[k]].sliding.x; });
  const Pack twist = Pack(0.5 * b.approach.time_step) * dot(b.spin_sum, b.normal);
  TangentialSpring<Pack> spring{carry(sliding.xyz(), b.normal, twist), sliding.w};
  Answer result;
  result.contact = law(b.approach, spring);
  result.force = result.contact.normal * b.normal + result.contact.tangential;
  alignas(64) Quad rows[lanes];
  columns_to_rows({spring.stretch.x, spring.stretch.y, spring.stretch.z, spring.energy}, rows);
  for (int k = 0; k < lanes; ++k) memory[slot[k]].sliding = rows[k];
  result.moment = {Pack(0.0), Pack(0.0), Pack(0.0)};
  result.rolling_loss = Pack(0.0);
  if (rolling.model != RollingModel::none) {
    const QuadPack stored = gather_rows([&](int k) { return &memory[slot[k]].rolling.x; });
    TangentialSpring<Pack> roll{carry(stored.xyz(), b.normal, twist), stored.w};
    const PackTriple rolling_velocity = b.spin_difference - dot(b.spin_difference, b.normal) * b.normal;
    const HeldForce<Pack> held = rolling(b.approach, result.contact, rolling_velocity, roll);
    result.moment = held.force;
    result.rolling_loss = held.loss;
    result.contact.elastic_energy += roll.energy;
    columns_to_rows({roll.stretch.x, roll.stretch.y, roll.stretch.z, roll.energy}, rows);
    for (int k = 0; k < lanes; ++k) memory[slot[k]].rolling = rows[k];
  }
  return result;
}

struct Sums {
  Pack elastic{0.0}, normal{0.0}, sliding{0.0}, rolling{0.0};
  QUERN_INLINE void add(const Answer& a, const Mask& valid) {
    const Pack zero(0.0);
    elastic += select(valid, a.contact.elastic_energy, zero);
    normal += select(valid, a.contact.normal_loss, zero);
    sliding += select(valid, a.contact.tangential_loss, zero);
    rolling += select(valid, a.rolling_loss, zero);
  }
  void flush(StepSums& s) const {
    s.elastic_energy += sum(elastic);
    s.normal_loss += sum(normal);
    s.sliding_loss += sum(sliding);
    s.rolling_loss += sum(rolling);
  }
};

void write_down(const StepContext& step, const Bodies& b, const Answer& a, CollisionRecord* record, const Index* slot, int count) {
  alignas(64) double vn[lanes], vt[lanes], fn[lanes], overlap[lanes], ln[lanes], lt[lanes], mass[lanes];
  store(vn, b.approach.normal_velocity);
  store(vt, length(b.approach.tangential_velocity));
  store(fn, a.contact.normal);
  store(overlap, b.approach.overlap);
  store(ln, a.contact.normal_loss);
  store(lt, a.contact.tangential_loss + a.rolling_loss);
  store(mass, b.approach.effective_mass);
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

// Eight entries of an active list; a short last batch repeats its last contact in the lanes beyond `count`. Those lanes
// write to a scratch row of memory, so that a repeated contact is never advanced twice.
struct Batch {
  alignas(32) Index i[lanes], j[lanes], slot[lanes];
  int count;
  QUERN_INLINE Batch(const ActiveList& list, Index at, Index scratch) : count(list.size() - at < lanes ? list.size() - at : lanes) {
    for (int k = 0; k < lanes; ++k) {
      const auto from = static_cast<std::size_t>(at + (k < count ? k : count - 1));
      i[k] = list.first[from];
      j[k] = list.second[from];
      slot[k] = k < count ? list.slot[from] : scratch;
    }
  }
};

template <class Law>
void pair_forces_of(const StepContext& step, const Law& law, const Rolling& rolling, const ActiveList& list, ContactBlock& block) {
  Particles& p = *step.particles;
  const Space space(*step.domain);
  const Index scratch = 0;
  Sums sums;
  for (Index at = 0; at < list.size(); at += lanes) {
    const Batch batch(list, at, scratch);
    const QuadPack xi = gather(p.position.data(), batch.i), xj = gather(p.position.data(), batch.j);
    const QuadPack vi = gather(p.velocity.data(), batch.i), vj = gather(p.velocity.data(), batch.j);
    const QuadPack wi = gather(p.spin.data(), batch.i), wj = gather(p.spin.data(), batch.j);
    const PackTriple apart = space.nearest(xi.xyz() - xj.xyz());
    const Pack one(1.0), distance = square_root(dot(apart, apart));
    Bodies b;
    b.normal = (one / distance) * apart;
    const Pack overlap = xi.w + xj.w - distance;
    const Pack arm_i = xi.w - Pack(0.5) * overlap, arm_j = xj.w - Pack(0.5) * overlap;
    b.spin_difference = wi.xyz() - wj.xyz();
    b.spin_sum = wi.xyz() + wj.xyz();
    const PackTriple relative = vi.xyz() - vj.xyz() - cross(arm_i * wi.xyz() + arm_j * wj.xyz(), b.normal);
    const Pack normal_velocity = dot(relative, b.normal);
    b.approach = {greater(Pack(0.0), overlap),
                  normal_velocity,
                  relative - normal_velocity * b.normal,
                  xi.w * xj.w / (xi.w + xj.w),
                  vi.w * vj.w / (vi.w + vj.w),
                  step.time_step,
                  spring_lead(overlap, normal_velocity, step.time_step),
                  step.ahead};
    const Answer a = answer(law, rolling, b, block.memory.data(), batch.slot);
    sums.add(a, first_lanes(batch.count));

    const PackTriple twist = cross(b.normal, a.contact.tangential);
    const PackTriple on_i = a.moment - arm_i * twist, on_j = (-arm_j) * twist - a.moment;
    const Pack zero(0.0);
    alignas(64) Quad force[lanes], back[lanes], torque_i[lanes], torque_j[lanes];
    columns_to_rows({a.force.x, a.force.y, a.force.z, zero}, force);
    columns_to_rows({-a.force.x, -a.force.y, -a.force.z, zero}, back);
    columns_to_rows({on_i.x, on_i.y, on_i.z, zero}, torque_i);
    columns_to_rows({on_j.x, on_j.y, on_j.z, zero}, torque_j);
    for (int k = 0; k < batch.count; ++k) {
      const Index i = batch.i[k], j = batch.j[k];
      add_row(p.force[static_cast<std::size_t>(i)], force[k]);
      add_row(p.torque[static_cast<std::size_t>(i)], torque_i[k]);
      if (j < block.last) {
        add_row(p.force[static_cast<std::size_t>(j)], back[k]);
        add_row(p.torque[static_cast<std::size_t>(j)], torque_j[k]);
      } else {
        block.push_remote(static_cast<std::size_t>(j / step.block_size), {back[k], torque_j[k], j});
      }
    }
    if (block.records) write_down(step, b, a, block.record.data(), batch.slot, batch.count);
  }
  sums.flush(block.sums);
  block.sums.pair_contacts += list.size();
}

template <class Law>
void wall_forces_of(const StepContext& step, const Law& law, const Rolling& rolling, const ActiveList& list, ContactBlock& block) {
  Particles& p = *step.particles;
  const Index scratch = 0;
  Sums sums;
  for (Index at = 0; at < list.size(); at += lanes) {
    const Batch batch(list, at, scratch);
    const WallTouch* touch = block.wall_touches.data();
    const QuadPack xi = gather(p.position.data(), batch.i), vi = gather(p.velocity.data(), batch.i), wi = gather(p.spin.data(), batch.i);
    const QuadPack normal = gather_rows([&](int k) { return &touch[batch.j[k]].normal.x; });
    const QuadPack wall_velocity = gather_rows([&](int k) { return &touch[batch.j[k]].velocity.x; });
    const QuadPack wall_spin = gather_rows([&](int k) { return &touch[batch.j[k]].spin.x; });
    Bodies b;
    b.normal = normal.xyz();
    const Pack arm = xi.w - normal.w;
    b.spin_difference = wi.xyz() - wall_spin.xyz();
    b.spin_sum = wi.xyz() + wall_spin.xyz();
    const PackTriple relative = vi.xyz() - wall_velocity.xyz() - cross(arm * wi.xyz(), b.normal);
    const Pack normal_velocity = dot(relative, b.normal);
    b.approach = {normal.w, normal_velocity, relative - normal_velocity * b.normal, xi.w, vi.w, step.time_step,
                  spring_lead(normal.w, normal_velocity, step.time_step), step.ahead};
    const Answer a = answer(law, rolling, b, block.memory.data(), batch.slot);
    sums.add(a, first_lanes(batch.count));

    const PackTriple torque = a.moment - arm * cross(b.normal, a.contact.tangential);
    const Pack zero(0.0);
    alignas(64) Quad force[lanes], moment[lanes], torques[lanes];
    columns_to_rows({a.force.x, a.force.y, a.force.z, zero}, force);
    columns_to_rows({a.moment.x, a.moment.y, a.moment.z, zero}, moment);
    columns_to_rows({torque.x, torque.y, torque.z, zero}, torques);
    for (int k = 0; k < batch.count; ++k) {
      const auto i = static_cast<std::size_t>(batch.i[k]);
      add_row(p.force[i], force[k]);
      add_row(p.torque[i], torques[k]);
      const WallTouch& t = touch[batch.j[k]];
      WallSums& wall = block.wall_sums[static_cast<std::size_t>(t.point.w)];
      const Triple<double> f = xyz(force[k]), m = xyz(moment[k]);
      wall.force = wall.force - f;
      wall.torque = wall.torque - cross(xyz(t.point), f) - m;
      block.sums.wall_work += step.time_step * (dot(f, xyz(t.velocity)) + dot(m, xyz(t.spin)));
    }
    if (block.records) write_down(step, b, a, block.record.data(), batch.slot, batch.count);
  }
  sums.flush(block.sums);
  block.sums.wall_contacts += list.size();
}

void pair_forces(const StepContext& step, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  std::visit([&](const auto& law) { pair_forces_of(step, law, pair.rolling, list, block); }, pair.law);
}

void wall_forces(const StepContext& step, const PairLaw& pair, const ActiveList& list, ContactBlock& block) {
  std::visit([&](const auto& law) { wall_forces_of(step, law, pair.rolling, list, block); }, pair.law);
}

}  // namespace

#define QUERN_TEXT(x) #x
#define QUERN_NAME(x) QUERN_TEXT(x)
const Kernels kernels{QUERN_NAME(QUERN_ISA), find_touching, pair_forces, wall_forces};

}  // namespace quern::QUERN_ISA
