#include "src/calibrate/specimen.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/observe/strain.hpp"

namespace quern {
namespace {

constexpr double grip = 0.08;       // of the length, at each end
constexpr double heavy = 1e30;      // mass of a gripped grain [kg]: nothing moves it but its velocity
constexpr double unbreakable = 1e300;

bool gripped(const Particles& p, std::size_t row) { return p.velocity[row].w >= heavy; }

// A specimen between grips that move apart at a given speed.
class Machine {
 public:
  Machine(const Specimen& specimen, const BondScale& scale, bool breaks) : length_(specimen.length), area_(specimen.area) {
    Case c = specimen.c;
    for (BondCase& bond : c.bonds) {
      bond.material = scaled(bond.material, scale);
      if (!breaks) bond.material.strength = {};
    }
    s_ = build_case(c).simulation;
    Particles& p = s_.particles;
    double stiffness = 0, mass = 0, spacing = 0;
    for (const Bond& bond : s_.bonds.list) {
      stiffness += bond.normal_stiffness * std::numbers::pi * bond.radius * bond.radius;
      spacing += bond.length;
      bond_strain_ += bond.tensile_strength / (bond.normal_stiffness * bond.length);
    }
    const auto bonds = static_cast<double>(s_.bonds.list.size());
    for (Index i = 0; i < p.owned; ++i) mass += p.mass(i) / p.owned;
    bond_strain_ /= bonds;
    transit_ = length_ / (spacing / bonds) * std::sqrt(mass / (stiffness / bonds));
    place_.resize(p.position.size());
    for (std::size_t k = 0; k < p.position.size(); ++k) {
      place_[static_cast<std::size_t>(p.id[k])] = vec(p.position[k]);
      if (std::abs(p.position[k].z) < (0.5 - grip) * length_) continue;
      p.velocity[k].w = p.spin[k].w = heavy;
      p.acceleration[k].w = p.angular_acceleration[k].w = 0;
    }
    s_.start(false);
  }

  double transit() const { return transit_; }            // of a pulse through the specimen, about [s]
  double bond_strain() const { return bond_strain_; }    // at which a bond fails, on average
  double time() const { return s_.clock.time(); }

  // One step in which the grips part at `speed` [m/s]. `drag` [1/s] slows what does not follow the mean strain.
  void step(double speed, double drag) {
    Particles& p = s_.particles;
    const double keep = 1 - drag * s_.clock.time_step;
    for (std::size_t k = 0; k < p.velocity.size(); ++k) {
      const double mean = speed * std::clamp(p.position[k].z / ((1 - 2 * grip) * length_), -0.5, 0.5);
      Quad &v = p.velocity[k], &w = p.spin[k];
      if (gripped(p, k)) {
        v.x = v.y = 0, v.z = p.position[k].z > 0 ? 0.5 * speed : -0.5 * speed;
      } else if (drag > 0) {
        v.x *= keep, v.y *= keep, v.z = mean + keep * (v.z - mean);
        w.x *= keep, w.y *= keep, w.z *= keep;
      }
    }
    s_.step();
    parted_ += speed * s_.clock.time_step;
  }

  double strain() const { return parted_ / ((1 - 2 * grip) * length_); }

  // That both grips bear, positive in tension [Pa].
  double stress() const {
    const Particles& p = s_.particles;
    double sum = 0;
    for (const ContactBlock& block : s_.contacts.blocks) {
      for (Index i = block.first; i < block.last; ++i) {
        const auto row = static_cast<std::size_t>(i);
        if (!gripped(p, row)) continue;
        const double pulled = block.load[static_cast<std::size_t>(i - block.first)].force.z;
        sum += p.position[row].z > 0 ? -pulled : pulled;
      }
    }
    return 0.5 * sum / area_;
  }

  // Strains of the middle half along and across.
  std::pair<double, double> middle_strain() const {
    std::vector<Vec3> place, moved;
    for (std::size_t k = 0; k < s_.particles.position.size(); ++k) {
      const Vec3& from = place_[static_cast<std::size_t>(s_.particles.id[k])];
      if (std::abs(from.z()) > 0.25 * length_) continue;
      place.push_back(from), moved.push_back(vec(s_.particles.position[k]) - from);
    }
    return {strain_of(place, moved, Vec3::UnitZ()), 0.5 * (strain_of(place, moved, Vec3::UnitX()) + strain_of(place, moved, Vec3::UnitY()))};
  }

  double kinetic_share() const {
    const Particles& p = s_.particles;
    double kinetic = 0;
    for (std::size_t k = 0; k < p.velocity.size(); ++k) {
      if (gripped(p, k)) continue;
      kinetic += 0.5 * (p.velocity[k].w * dot(xyz(p.velocity[k]), xyz(p.velocity[k])) + p.spin[k].w * dot(xyz(p.spin[k]), xyz(p.spin[k])));
    }
    return s_.ledger.bond_energy > 0 ? kinetic / s_.ledger.bond_energy : 0;
  }

 private:
  Simulation s_;
  double length_, area_, transit_ = 0, bond_strain_ = 0, parted_ = 0;
  std::vector<Vec3> place_;  // at the start, by id
};

}  // namespace

Specimen make_specimen(const Case& given, std::size_t agglomerate, std::int64_t grains, std::uint64_t seed) {
  Specimen specimen;
  const AgglomerateCase& body = given.agglomerates[agglomerate];
  if (!body.grains.empty())
    throw InputError(fmt::format("{}: agglomerate.{}: found an assembly from a file, of which no specimen can be packed; allowed is an agglomerate with a shape.", given.file, body.name));
  double volumes = 0, numbers = 0;
  for (const GrainPortion& portion : body.request.portions) volumes += portion.share, numbers += portion.share / portion.sizes.mean_volume();
  const double solid = body.request.solid_fraction.value_or(0.54);
  const double radius = std::cbrt(static_cast<double>(grains) * volumes / numbers / solid / (4 * std::numbers::pi));
  specimen.length = 4 * radius;
  specimen.area = std::numbers::pi * radius * radius;

  Case& c = specimen.c;
  c.file = given.file, c.name = given.name;
  c.duration = 1;
  c.seed = seed;
  c.gravity = Vec3::Zero();
  c.time_step_fraction = given.time_step_fraction;
  c.materials = given.materials, c.pairs = given.pairs, c.species = given.species, c.bonds = given.bonds;
  c.agglomerates = {body};
  AgglomerateCase& packed = c.agglomerates.front();
  packed.mesh = {};
  packed.request.shape = CylinderRegion{radius, -2 * radius, 2 * radius};
  packed.request.seed = seed;
  try {
    try {
      packed.grains = pack_body(packed.request);
    } catch (const InputError&) {
      // A specimen of few grains packs less densely than the body.
      packed.request.solid_fraction.reset();
      packed.grains = pack_body(packed.request);
    }
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: agglomerate.{}: a specimen of {} grains: {}", given.file, body.name, grains, e.what()));
  }
  specimen.grains = static_cast<std::int64_t>(packed.grains.size());
  for (const Grain& grain : packed.grains) specimen.solid_fraction += std::numbers::pi / 6 * std::pow(grain.diameter, 3) / (specimen.area * specimen.length);
  InsertCase insert;
  insert.name = body.name, insert.where = body.where;
  insert.agglomerate = 0;
  insert.method = InsertCase::Method::list;
  insert.balls = {{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0}};
  c.inserts = {insert};
  return specimen;
}

BondMaterial scaled(const BondMaterial& material, const BondScale& scale) {
  BondMaterial m = material;
  const double ratio = scale.stiffness_ratio.value_or(m.young > 0 ? m.young / m.shear_modulus : m.normal_stiffness / m.shear_stiffness);
  m.young *= scale.young, m.normal_stiffness *= scale.young;
  m.shear_modulus = m.young / ratio, m.shear_stiffness = m.normal_stiffness / ratio;
  if (m.strength.tensile < unbreakable) m.strength.tensile *= scale.tensile;
  if (m.strength.shear < unbreakable) m.strength.shear *= scale.shear;
  return m;
}

Elasticity measure_elasticity(const Specimen& specimen, const BondScale& scale) {
  Machine machine(specimen, scale, false);
  constexpr double strain = 1e-4;
  const double transit = machine.transit(), rise = 16 * transit, end = rise + 12 * transit;
  const double mean_speed = strain * (1 - 2 * grip) * specimen.length / rise;
  double stress = 0, along = 0, across = 0, next = end - 4 * transit;
  int samples = 0;
  while (machine.time() < end) {
    const double phase = 2 * std::numbers::pi * machine.time() / rise;
    machine.step(machine.time() < rise ? -mean_speed * (1 - std::cos(phase)) : 0, 1 / transit);
    if (machine.time() < next) continue;
    next += 0.1 * transit;
    const auto [z, xy] = machine.middle_strain();
    stress += machine.stress(), along += z, across += xy, ++samples;
  }
  if (samples == 0 || along == 0) throw RunError("a specimen could not be pressed: it has no middle part; more grains are the cure.");
  return {stress / along, -across / along};
}

Strength measure_strength(const Specimen& specimen, const BondScale& scale, Pull pull) {
  Machine machine(specimen, scale, true);
  const double sign = pull == Pull::tension ? 1 : -1, transit = machine.transit();
  // Bonds fail one by one from about the strain on at which a bond alone would; in compression from several times that on.
  const double transits = pull == Pull::tension ? 40 : 20, most = (pull == Pull::tension ? 3 : 15) * machine.bond_strain();
  const double speed = machine.bond_strain() * (1 - 2 * grip) * specimen.length / (transits * transit), ramp = 8 * transit;
  struct Row {
    double stress, share;
  };
  std::vector<Row> rows;
  Strength found;
  double next = 0, sum = 0;
  int steps = 0;
  while (std::abs(machine.strain()) < most) {
    machine.step(sign * speed * std::min(1.0, machine.time() / ramp), 0);
    sum += sign * machine.stress(), ++steps;
    if (machine.time() < next) continue;
    next = machine.time() + 0.1 * transit;
    rows.push_back({sum / steps, machine.kinetic_share()});
    sum = 0, steps = 0;
    if (rows.back().stress > found.stress) found.stress = rows.back().stress, found.strain = std::abs(machine.strain());
    found.failed = rows.back().stress < 0.7 * found.stress && machine.time() > ramp;
    if (found.failed) break;
  }
  bool began = false;
  for (const Row& row : rows) {
    began |= row.stress >= 0.2 * found.stress;
    if (began) found.kinetic_share = std::max(found.kinetic_share, row.share);
    if (row.stress == found.stress) break;
  }
  return found;
}

}  // namespace quern
