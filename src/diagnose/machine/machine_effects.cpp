#include "src/diagnose/machine/machine_effects.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include "src/base/error.hpp"
#include "src/case/build.hpp"

namespace quern {
namespace {

constexpr double pi = std::numbers::pi;

// Tables of two names that the case gives: "pair.steel.steel", "bond.stone.stone".
std::vector<std::string> tables_of_two(const Values& base, const std::string& kind) {
  std::set<std::string> found;
  for (const auto& [path, place] : base.where)
    if (path.size() == 3 && path[0] == kind) found.insert(join_path(path));
  for (const auto& [path, value] : base.given)
    if (path.size() == 4 && path[0] == kind) found.insert(join_path({path[0], path[1], path[2]}));
  return {found.begin(), found.end()};
}

class Collector {
 public:
  explicit Collector(const MachineExperiment& experiment) : experiment_(experiment), base_(experiment.base()) {
    for (const MachineParameter& one : free_parameters(base_))
      for (const Parameter& p : one.moves) free_.insert(join_path(p.path));
    const std::size_t middle = experiment.recording().rows.size() / 2;
    const Case c = case_of(experiment.values_of(middle, {}));
    for (const SpeciesCase& s : c.species) radius_ = std::max(radius_, 0.5 * s.sizes.diameter.back()), density_ = std::max(density_, s.density);
    for (const std::string& name : base_.names("material"))
      if (base_.has("material." + name + ".young")) young_ = std::max(young_, 0.5 * base_.number("material." + name + ".young"));  // E*, nearly
    gravity_ = c.gravity.norm();
    if (c.mill) size_ = c.mill->diameter, turn_ = std::abs(c.mill->speed), lifters_ = c.mill->lifters.count > 0 ? c.mill->lifters.height : 0;
    if (c.stirred) size_ = c.stirred->diameter, turn_ = std::abs(c.stirred->speed);
    if (c.planetary) size_ = c.planetary->vial_diameter, turn_ = std::abs(c.planetary->speed), gravity_ = std::max(gravity_, 0.5 * c.planetary->disc_diameter * turn_ * turn_);
    losses_ = c.mill || c.stirred;
    mass_ = density_ * 4.0 / 3.0 * pi * radius_ * radius_ * radius_;
  }

  std::vector<MachineCandidate> all() {
    if (size_ > 0) contacts(), medium();
    machine();
    bonds();
    instruments();
    return std::move(found_);
  }

 private:
  bool records(const char* channel) const {
    return std::any_of(experiment_.channels().begin(), experiment_.channels().end(), [&](const RecordedChannel& c) { return c.name == channel; });
  }

  // All the keys at once; none where one is given or free already.
  MachineCandidate* add(const std::string& effect, const std::string& form, const std::vector<std::string>& keys, double null, double lower, double upper, double step, std::vector<Setting> settings = {}) {
    if (keys.empty() || !(step != 0) || !std::isfinite(step)) return nullptr;
    MachineParameter p;
    p.key = keys.front();
    for (const std::string& key : keys) {
      if (free_.count(key) > 0 || (base_.has(key) && base_.number(key) != null)) return nullptr;
      const Key* known = find_key(split_path(key));
      if (known == nullptr) return nullptr;
      Parameter one;
      one.name = key, one.path = split_path(key), one.value = null, one.lower = lower, one.upper = upper, one.scale = std::abs(step);
      p.moves.push_back(one);
      p.unit = known->unit;
    }
    p.null = null, p.lower = lower, p.upper = upper, p.scale = step, p.settings = std::move(settings);
    found_.push_back({effect, form, p});
    return &found_.back();
  }

  std::vector<std::string> of_pairs(const char* leaf) const {
    std::vector<std::string> keys;
    for (const std::string& pair : tables_of_two(base_, "pair")) keys.push_back(pair + "." + leaf);
    return keys;
  }

  void contacts() {
    const double weight = mass_ * gravity_, speed = std::max(std::sqrt(gravity_ * size_), 0.5 * turn_ * size_);
    add("rolling_resistance", "", of_pairs("rolling_friction"), 0, 0, 2, 0.1);
    // Friction over the spot of contact: μ_t ≤ (3π/16) μ a/R* (Johnson 1985, § 8.4), and spots are small.
    add("torsional_friction", "", of_pairs("torsional_friction"), 0, 0, 0.15, 0.05);
    add("adhesion", "", of_pairs("surface_energy"), 0, 0, 1e4, 3 * weight / (1.5 * pi * 0.5 * radius_));
    std::vector<Setting> film;
    for (const std::string& key : of_pairs("film_thickness")) film.push_back({key, 0.05 * radius_});
    for (const std::string& key : of_pairs("film_cutoff")) film.push_back({key, 5e-3 * radius_});
    const double reduced = 0.5 * radius_;
    add("lubrication", "", of_pairs("film_viscosity"), 0, 0, 1e4, 0.1 * mass_ * speed / (6 * pi * reduced * reduced * std::log(10.0)), film);
    constexpr double tension = 0.0728;
    if (2 * pi * reduced * tension > 0.02 * weight) add("liquid_bridge", "", of_pairs("bridge_volume"), 0, 0, 0.1 * radius_ * radius_ * radius_, 0.003 * radius_ * radius_ * radius_);
    std::vector<Setting> reference;
    for (const std::string& key : of_pairs("reference_speed")) reference.push_back({key, 0.3 * speed});
    const bool rebounds = std::all_of(reference.begin(), reference.end(), [&](const Setting& s) {
      const std::string pair = s.key.substr(0, s.key.rfind('.'));
      return base_.has(pair + ".restitution") && base_.number(pair + ".restitution") < 1 && (!base_.has(pair + ".law") || base_.text(pair + ".law") == "linear" || base_.text(pair + ".law") == "hertz_mindlin");
    });
    if (rebounds) add("velocity_dependent_restitution", "", of_pairs("restitution_exponent"), 0, 0, 1, 0.2, reference);
    if (rebounds && young_ > 0) {
      // A dashpot that takes a tenth of the time of a contact (Hertz 1882) at usual speed.
      const double contact = 2.87 * std::pow(0.25 * mass_ * mass_ / (reduced * young_ * young_ * 0.3 * speed), 0.2);
      add("velocity_dependent_restitution", "viscoelastic", of_pairs("viscoelastic_time"), 0, 0, contact, 0.1 * contact);
    }
    add("plastic_contact", "unloading stiffer than loading", of_pairs("unloading_ratio"), 1, 1, 20, 1);
    add("powder_layer", "", of_pairs("powder_layers"), 0, 0, 30, 1);
    known_quantity("friction", 0.2);
    known_quantity("restitution", -0.2);
    const std::vector<std::string> rebound = of_pairs("restitution");
    if (rebound.size() < 2 || std::any_of(rebound.begin(), rebound.end(), [&](const std::string& key) { return free_.count(key) > 0 || !base_.has(key) || base_.number(key) != base_.number(rebound.front()); })) return;
    const double value = base_.number(rebound.front());
    MachineParameter p;
    p.key = rebound.front(), p.unit = "1", p.null = value, p.lower = 0.01, p.upper = 1, p.scale = value > 0.25 ? -0.2 : 0.2;
    for (const std::string& key : rebound) {
      Parameter one;
      one.name = key, one.path = split_path(key), one.value = value, one.lower = p.lower, one.upper = p.upper, one.scale = 0.2;
      p.moves.push_back(one);
    }
    found_.push_back({"restitution", "of all pairs set free", p, true});
  }

  // What the case says of contacts, set free: the worse answer, unless the case is wrong about what it calls known.
  void known_quantity(const char* leaf, double step) {
    for (const std::string& key : of_pairs(leaf)) {
      if (free_.count(key) > 0 || !base_.has(key)) continue;
      const double value = base_.number(key), most = std::string_view(leaf) == "restitution" ? 1.0 : 3.0;
      const double asked = value + step > 0.02 && value + step < most ? step : -step;
      if (value == 0 && std::string_view(leaf) == "friction") {
        add("sliding_friction", key, {key}, 0, 0, 3, asked);
        continue;
      }
      const Key* known = find_key(split_path(key));
      Parameter one;
      one.name = key, one.path = split_path(key), one.value = value, one.lower = 0.01, one.upper = most, one.scale = std::abs(asked);
      MachineParameter p;
      p.key = key, p.unit = known->unit, p.null = value, p.lower = one.lower, p.upper = most, p.scale = asked, p.moves = {one};
      found_.push_back({leaf, key + " set free", p, true});
    }
  }

  void medium() {
    const double speed = std::max(std::sqrt(gravity_ * size_), 0.5 * turn_ * size_), weight = mass_ * gravity_;
    if (base_.has("medium.drag_coefficient")) return;
    add("slurry_drag", "against the velocity", {"medium.viscous_drag"}, 0, 0, 1e6, 0.1 * weight / (6 * pi * radius_ * speed));
  }

  void machine() {
    if (lifters_ > 0) {
      const bool campaign = std::any_of(experiment_.recording().rows.begin(), experiment_.recording().rows.end(), [](const MachineRow& row) { return row.conditions.count("campaign_time") > 0; });
      double longest = 0;
      for (const MachineRow& row : experiment_.recording().rows)
        if (campaign) longest = std::max(longest, row.conditions.at("campaign_time"));
      if (campaign && longest > 0) add("lifter_wear", "with the time in use", {"mill.lifters.wear_rate"}, 0, 0, 0.9 * lifters_ / longest, 0.4 * lifters_ / longest);
      else add("lifter_wear", "alike at all times", {"mill.lifters.wear"}, 0, 0, 0.9 * lifters_, 0.4 * lifters_);
    }
    if (!losses_ || (!records("power") && !records("torque"))) return;
    double power = 0, torque = 0;
    for (const RecordedChannel& c : experiment_.channels())
      for (const auto& site : c.sites) {
        if (c.name == "power") power = std::max(power, std::abs(site.value));
        if (c.name == "torque") torque = std::max(torque, std::abs(site.value));
      }
    if (torque == 0 && turn_ > 0) torque = power / turn_;
    if (MachineCandidate* c = add("bearing_torque", "bearings", {"mill.bearing_torque"}, 0, 0, 10 * torque, 0.05 * torque)) c->parameter.acts = MachineParameter::Acts::bearing_torque;
    if (MachineCandidate* c = add("bearing_torque", "gears", {"mill.gear_loss"}, 0, 0, 1, 0.05)) c->parameter.acts = MachineParameter::Acts::gear_loss;
  }

  std::vector<std::string> bond_tables() const {
    std::vector<std::string> all = tables_of_two(base_, "bond");
    if (base_.has_table("bond.default")) all.push_back("bond.default");
    return all;
  }

  // About the middle of what was recorded, so that the strengths themselves need not move with the exponents.
  void size_effects() {
    std::vector<double> speeds, sizes;
    for (std::size_t r = 0; r < experiment_.recording().rows.size(); ++r) {
      const Case c = case_of(experiment_.values_of(r, {}));
      const Built built = build_case(c);
      const Particles& grains = built.simulation.particles;
      double fastest = 0, reach = 0;
      Vec3 centre = Vec3::Zero();
      for (Index i = 0; i < grains.owned; ++i) centre += vec(grains.position[static_cast<std::size_t>(i)]) / grains.owned;
      for (Index i = 0; i < grains.owned; ++i) {
        const auto row = static_cast<std::size_t>(i);
        fastest = std::max(fastest, vec(grains.velocity[row]).norm());
        reach = std::max(reach, (vec(grains.position[row]) - centre).norm() + grains.position[row].w);
      }
      speeds.push_back(fastest), sizes.push_back(2 * reach);
    }
    if (sizes.empty()) return;
    const auto middle = [](std::vector<double> all) { std::sort(all.begin(), all.end()); return all[all.size() / 2]; };
    const auto varies = [](const std::vector<double>& all) { return *std::max_element(all.begin(), all.end()) > 1.05 * *std::min_element(all.begin(), all.end()); };
    std::vector<std::string> rates, exponents;
    std::vector<Setting> slow, usual;
    for (const std::string& bond : bond_tables()) {
      rates.push_back(bond + ".rate_exponent"), exponents.push_back(bond + ".size_exponent");
      slow.push_back({bond + ".reference_rate", 0.1 * middle(speeds) / middle(sizes)});
      usual.push_back({bond + ".reference_size", middle(sizes)});
    }
    if (varies(speeds) && middle(speeds) > 0) add("rate_dependent_strength", "as a power of the rate of strain", rates, 0, 0, 1, 0.1, slow);
    if (varies(sizes)) add("size_effect", "as a power of the size", exponents, 0, -1, 3, 0.2, usual);
  }

  void bonds() {
    if (bond_tables().empty()) return;
    std::vector<std::string> keys;
    std::vector<Setting> settings;
    for (const std::string& bond : bond_tables()) {
      if (base_.has(bond + ".strength") && base_.text(bond + ".strength") != "constant") return;
      keys.push_back(bond + ".deviation");
      settings.push_back({bond + ".strength", std::string("normal")});
    }
    size_effects();
    add("bond_strength_scatter", "normal about the mean", keys, 0, 0, 1, 0.3, settings);
  }

  void instruments() {
    for (const RecordedChannel& channel : experiment_.channels()) {
      double largest = 0;
      for (const auto& site : channel.sites) largest = std::max(largest, std::abs(site.value));
      MachineParameter p;
      p.channel = channel.label();
      if (channel.scale == Scale::linear) {
        p.acts = MachineParameter::Acts::offset;
        p.key = channel.label() + ".offset", p.unit = machine_channel(channel.name).unit;
        p.null = 0, p.scale = 0.02 * largest, p.lower = -largest, p.upper = largest;
        found_.push_back({"sensor_offset", channel.label(), p});
      }
      // A protractor has no gain, and shares are counted.
      if (channel.name == "shoulder" || channel.name == "toe" || channel.scale == Scale::share) continue;
      p.acts = MachineParameter::Acts::gain;
      p.key = channel.label() + ".gain", p.unit = "1";
      p.null = 1, p.scale = 0.03, p.lower = 0.3, p.upper = 3;
      found_.push_back({"sensor_gain", channel.label(), p});
    }
  }

  const MachineExperiment& experiment_;
  const Values& base_;
  std::set<std::string> free_;
  std::vector<MachineCandidate> found_;
  double radius_ = 0, density_ = 0, mass_ = 0, gravity_ = 0, young_ = 0, size_ = 0, turn_ = 0, lifters_ = 0;
  bool losses_ = false;
};

}  // namespace

std::vector<MachineParameter> free_parameters(const Values& base) {
  std::vector<MachineParameter> all;
  if (!base.has("diagnose.free")) return all;
  for (const std::string& key : base.texts("diagnose.free")) {
    const Parameter one = parameter_of(base, key);
    MachineParameter p;
    p.key = one.name, p.moves = {one};
    const Key* known = find_key(one.path);
    p.unit = known != nullptr ? known->unit : "1";
    p.null = one.value, p.lower = one.lower, p.upper = one.upper;
    // As far as the bounds let it, but no farther than a third of the value.
    const double room = std::max(one.upper - one.value, one.value - one.lower);
    p.scale = std::min(0.5 * room, one.value != 0 ? 0.3 * std::abs(one.value) : one.scale);
    if (!(p.scale > 0) || !std::isfinite(p.scale)) p.scale = one.scale;
    if (one.upper - one.value < p.scale) p.scale = -p.scale;  // towards where there is room
    all.push_back(p);
  }
  return all;
}

std::vector<MachineCandidate> machine_candidates(const MachineExperiment& experiment) { return Collector(experiment).all(); }

}  // namespace quern
