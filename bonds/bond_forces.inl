// The forces of bonds, eight at a time, and how particles turn; part of src/contact/kernels_isa.inl, compiled for each instruction set.
//
// A bond's elastic energy is a function of where its grains are and how they have turned since it was made:
//   U = ½ k_bn A (|D| − L_0)² + ½ k_bs A |u_s|² + ½ k_bn I θ_b² + ½ k_bs J θ_t²
// D: between the centres; u_s: what of the mean of the two grains' axes (of length L_0) lies across D; θ: of the relative rotation, as
// twice the vector part of its quaternion, split into twist about the grains' axes and bending across them. Forces and moments are its
// exact gradient: momentum, angular momentum and energy are kept, and rigid motion loads nothing.
#include "bonds/bond_list.hpp"
#include "src/base/pack.hpp"
#include "src/contact/kernels.hpp"
#include "src/contact/workspace.hpp"

namespace quern::QUERN_ISA {
namespace {

struct QuaternionPack {
  Triple<Pack> vector;
  Pack scalar;
};

QUERN_INLINE QuaternionPack product(const QuaternionPack& a, const QuaternionPack& b) {
  return {a.scalar * b.vector + b.scalar * a.vector + cross(a.vector, b.vector), a.scalar * b.scalar - dot(a.vector, b.vector)};
}

// A direction that a quaternion has turned.
QUERN_INLINE Triple<Pack> turned_by(const QuaternionPack& q, const Triple<Pack>& direction) {
  const Triple<Pack> half = cross(q.vector, direction);
  const Triple<Pack> whole = half + half;
  return direction + q.scalar * whole + cross(q.vector, whole);
}

QUERN_INLINE void set(Triple<Pack>& to, const Triple<Pack>& what) { to.x = what.x, to.y = what.y, to.z = what.z; }

QUERN_INLINE Pack magnitude(const Pack& a) { return greater(a, -a); }

// How eight bonds are deformed; lengths in units of L_0.
struct BondDeformation {
  Triple<Pack> apart, normal;        // D [m] and its direction, from the first grain to the second
  Triple<Pack> first_axis, second_axis;  // the grains' axes now
  Triple<Pack> slant;                // of their mean across the normal: −u_s
  Triple<Pack> rotation;             // vector part of the relative rotation
  Triple<Pack> twist_axis;           // by which the twist changes with the relative rotation
  Pack inverse_distance, strain, along;  // along: of the mean axis on the normal
  Pack cosine, twist, bending_square, slant_square;  // cosine and sine (twist, bending) of half the angles
};

struct BondLoad {
  Triple<Pack> force, on_first, on_second;  // force on the first grain; moments
};

QUERN_INLINE QuaternionPack quaternion(const QuadPack& q) { return {q.xyz(), q.w}; }

QUERN_INLINE void deform(const Workspace& work, const BondBatch& b, BondDeformation& d) {
  const QuadPack xi = gather(&work.position[0].x, b.first), xj = gather(&work.position[0].x, b.second);
  const QuaternionPack qi = quaternion(gather(&work.orientation[0].x, b.first)), qj = quaternion(gather(&work.orientation[0].x, b.second));
  const Triple<Pack> axis = {load(b.axis[0]), load(b.axis[1]), load(b.axis[2])};
  const QuaternionPack relation = {{load(b.relation[0]), load(b.relation[1]), load(b.relation[2])}, load(b.relation[3])};
  const Pack zero(0.0), one(1.0);
  const Triple<Pack> apart = xj.xyz() - xi.xyz();
  const Pack distance = square_root(dot(apart, apart)), inverse_distance = one / distance;
  const Triple<Pack> normal = inverse_distance * apart;
  const QuaternionPack back = {{zero - qi.vector.x, zero - qi.vector.y, zero - qi.vector.z}, qi.scalar};
  const QuaternionPack relative = product(product(qj, relation), back);
  const Triple<Pack> first_axis = turned_by(qi, axis), rotation = relative.vector;
  const Pack cosine = relative.scalar;
  const Triple<Pack> across = cross(rotation, first_axis);
  const Triple<Pack> half_turn = cosine * across + cross(rotation, across);
  const Triple<Pack> middle = first_axis + half_turn;
  const Triple<Pack> second_axis = middle + half_turn;
  const Triple<Pack> twist_axis = cosine * first_axis + across;
  const Pack twist = dot(rotation, first_axis);
  const Pack bending_square = greater(zero, dot(rotation, rotation) - twist * twist);
  const Pack along = dot(middle, normal);
  const Triple<Pack> slant = middle - along * normal;
  const Pack slant_square = dot(slant, slant), strain = distance * load(b.inverse_length) - one;
  set(d.apart, apart), set(d.normal, normal), set(d.first_axis, first_axis), set(d.second_axis, second_axis), set(d.slant, slant);
  set(d.rotation, rotation), set(d.twist_axis, twist_axis);
  d.inverse_distance = inverse_distance, d.strain = strain, d.along = along;
  d.cosine = cosine, d.twist = twist, d.bending_square = bending_square, d.slant_square = slant_square;
}

// Bit k: bond k fails. σ = F_n/A + |M_b| R_b/I and τ = |F_s|/A + |M_t| R_b/J, each over its limit, without a square root.
QUERN_INLINE unsigned failing(const BondBatch& b, const BondDeformation& d) {
  const Pack zero(0.0), slenderness = load(b.slenderness);
  const Pack tension_room = load(b.tension_limit) - d.strain;
  const Pack shear_room = load(b.shear_limit) - slenderness * magnitude(d.twist);
  const Mask tension = (zero < tension_room) & (slenderness * slenderness * d.bending_square < tension_room * tension_room);
  const Mask shear = (zero < shear_room) & (d.slant_square < shear_room * shear_room);
  return ~bits(tension & shear) & 0xffu;
}

QUERN_INLINE void pull_back(const BondBatch& b, const BondDeformation& d, BondLoad& on) {
  const Pack half(0.5), slenderness = load(b.slenderness), normal = load(b.normal), shear = load(b.shear);
  const Pack square = slenderness * slenderness;
  const Pack bending = Pack(0.125) * square * normal, twisting = Pack(0.25) * square * shear;
  on.force = (normal * d.strain * load(b.inverse_length)) * d.normal - (shear * d.along * d.inverse_distance) * d.slant;
  const Triple<Pack> moment = (bending * d.cosine) * d.rotation + ((twisting - bending) * d.twist) * d.twist_axis;
  const Triple<Pack> arm = (half * shear) * d.slant;
  on.on_first = moment - cross(d.first_axis, arm);
  on.on_second = Triple<Pack>{-moment.x, -moment.y, -moment.z} - cross(d.second_axis, arm);
}

QUERN_INLINE Pack elastic_energy(const BondBatch& b, const BondDeformation& d) {
  const Pack slenderness = load(b.slenderness), normal = load(b.normal), shear = load(b.shear), square = slenderness * slenderness;
  return Pack(0.5) * (normal * d.strain * d.strain + shear * d.slant_square) +
         square * (Pack(0.125) * normal * d.bending_square + Pack(0.25) * shear * d.twist * d.twist);
}

// Notes those of eight bonds that fail now. A bond that pulls no more leaves out the second half of this step's kick, as if it had
// failed half a step earlier: its energy is counted as of then.
[[gnu::noinline]] void fail_bonds(const StepContext& step, const Workspace& work, const BondDeformation& d, unsigned failed, BondList& bonds,
                                  BondBatch& batch) {
  BondLoad on;
  pull_back(batch, d, on);
  const auto rows = [&](const std::vector<Quad>& array, const Index* offset) { return gather(&array[0].x, offset).xyz(); };
  const Triple<Pack> velocity = rows(work.velocity, batch.first) - rows(work.velocity, batch.second);
  const Pack power = dot(on.force, velocity) + dot(on.on_first, rows(work.spin, batch.first)) +
                     dot(on.on_second, rows(work.spin, batch.second));
  const Pack slenderness = load(batch.slenderness);
  const Pack tension = (d.strain + slenderness * square_root(d.bending_square)) / load(batch.tension_limit);
  const Pack shear = (square_root(d.slant_square) + slenderness * magnitude(d.twist)) / load(batch.shear_limit);
  alignas(64) double energies[lanes], tensions[lanes], shears[lanes];
  store(energies, elastic_energy(batch, d) + Pack(0.5 * step.time_step) * power);
  store(tensions, tension);
  store(shears, shear);
  alignas(64) Quad places[lanes], normals[lanes];
  const Triple<Pack> place = rows(work.position, batch.first) + Pack(0.5) * d.apart;
  scatter_rows(QuadPack{place.x, place.y, place.z, Pack(0.0)}, [&](int k) { return &places[k].x; });
  scatter_rows(QuadPack{d.normal.x, d.normal.y, d.normal.z, Pack(0.0)}, [&](int k) { return &normals[k].x; });
  for (; failed != 0; failed &= failed - 1) {
    const int k = __builtin_ctz(failed);
    if (batch.bond[k] < 0) continue;
    const BondFailureMode mode = tensions[k] >= shears[k] ? BondFailureMode::tension : BondFailureMode::shear;
    bonds.fail(batch, k, {step.time, energies[k], xyz(places[k]), xyz(normals[k]), 0, 0, 0, mode});
  }
}

// The dashpots on the four springs of eight bonds, in velocities that rigid motion leaves at nothing: adds to their loads and returns
// the power that they take.
QUERN_INLINE Pack damp(const Workspace& work, const BondBatch& b, const BondDeformation& d, BondLoad& on) {
  const double *velocities = &work.velocity[0].x, *spins = &work.spin[0].x;
  const Triple<Pack> wi = gather(spins, b.first).xyz(), wj = gather(spins, b.second).xyz();
  const Triple<Pack> velocity = gather(velocities, b.second).xyz() - gather(velocities, b.first).xyz() - Pack(0.5) * cross(wi + wj, d.apart);
  const Triple<Pack> spin = wj - wi;
  const Pack stretching = dot(velocity, d.normal), twisting = dot(spin, d.normal);
  const Triple<Pack> sliding = velocity - stretching * d.normal;
  const Pack bending_damping = load(b.bending_damping), more_twisting = load(b.twisting_damping) - bending_damping;
  const Pack resisting = load(b.normal_damping) * stretching, more_resisting = more_twisting * twisting;
  const Triple<Pack> drag = load(b.shear_damping) * sliding;
  const Triple<Pack> arm = Pack(0.5) * cross(d.apart, drag);
  const Triple<Pack> moment = bending_damping * spin + more_resisting * d.normal;
  on.force = on.force + resisting * d.normal + drag;
  on.on_first = on.on_first + arm + moment;
  on.on_second = on.on_second + arm - moment;
  return resisting * stretching + dot(drag, sliding) + bending_damping * dot(spin, spin) + more_resisting * twisting;
}

QUERN_INLINE void add_loads(const BondBatch& b, const BondLoad& on, double* loads) {
  const Triple<Pack> force = on.force;
  const Pack zero(0.0);
  add_double_rows(QuadPack{force.x, force.y, force.z, zero}, QuadPack{on.on_first.x, on.on_first.y, on.on_first.z, zero},
                  [&](int k) { return loads + 2 * b.first[k]; });
  add_double_rows(QuadPack{-force.x, -force.y, -force.z, zero}, QuadPack{on.on_second.x, on.on_second.y, on.on_second.z, zero},
                  [&](int k) { return loads + 2 * b.second[k]; });
}

void bond_forces(const StepContext& context, ContactBlock& block, Workspace& work) {
  const StepContext step = context;
  double* loads = &block.load[0].force.x;
  Pack energy(0.0), power(0.0);
  for (BondBatch& batch : block.bonds.batches) {
    BondDeformation deformation;
    deform(work, batch, deformation);
    if (const unsigned failed = failing(batch, deformation); failed != 0) fail_bonds(step, work, deformation, failed, block.bonds, batch);
    BondLoad on;
    pull_back(batch, deformation, on);
    energy += elastic_energy(batch, deformation);
    power += damp(work, batch, deformation, on);
    add_loads(batch, on, loads);
  }
  block.sums.bond_energy += sum(energy);
  block.sums.bond_power += sum(power);
}

void turn(Particles& p, Index first, Index last, double dt) {
  const Pack one(1.0), half(0.5 * dt);
  for (Index from = first; from < last; from += lanes) {
    // A short last batch repeats its last particle, which is written alike each time.
    const auto row = [&](std::vector<Quad>& array) {
      return [&array, from, last](int k) { return &array[static_cast<std::size_t>(from + k < last ? from + k : last - 1)].x; };
    };
    const Triple<Pack> spin = gather_rows(row(p.spin)).xyz() + half * gather_rows(row(p.angular_acceleration)).xyz();
    const Triple<Pack> angle = half * spin;  // half of what it turns by
    const Pack s = dot(angle, angle);
    // Series of cosine and sine over its argument; what they lack at large angles is a little of the angle, not of the length.
    const Pack cosine = one - s * (Pack(1.0 / 2) - s * (Pack(1.0 / 24) - s * (Pack(1.0 / 720) - s * Pack(1.0 / 40320))));
    const Pack sine = one - s * (Pack(1.0 / 6) - s * (Pack(1.0 / 120) - s * (Pack(1.0 / 5040) - s * Pack(1.0 / 362880))));
    const QuaternionPack turned = product({sine * angle, cosine}, quaternion(gather_rows(row(p.orientation))));
    const Pack scale = one / square_root(dot(turned.vector, turned.vector) + turned.scalar * turned.scalar);
    scatter_rows(QuadPack{scale * turned.vector.x, scale * turned.vector.y, scale * turned.vector.z, scale * turned.scalar}, row(p.orientation));
  }
}

}  // namespace
}  // namespace quern::QUERN_ISA
