#include "src/diagnose/catalogue.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace quern {
namespace {

constexpr double pi = std::numbers::pi;

class Collector {
 public:
  Collector(const Comparison& comparison, const Fit& baseline, const Sizes& sizes) : experiment_(comparison.experiment()), baseline_(baseline), s_(sizes) {}

  std::vector<Candidate> candidates() {
    bodies();
    if (experiment_.has_wall()) contacts();
    instruments();
    rivals();
    return std::move(found_);
  }

  std::vector<Candidate> free_forms() {
    bool any_axis[3] = {false, false, false}, any_spin = false;
    for (const RecordedRun& run : experiment_.recording().runs)
      for (const Series& series : run.series) {
        if (series.channel < Channel::wx) any_axis[axis_of(series.channel)] = true;
        any_spin |= series.channel >= Channel::wx && series.channel <= Channel::wz;
      }
    const RecordingKind kind = experiment_.recording().kind;
    if (kind == RecordingKind::trajectory || kind == RecordingKind::impacts) {
      if (kind == RecordingKind::impacts) any_axis[2] = true;
      body_curve("speed", "against_velocity", "against the velocity, by speed");
      for (int axis = 0; axis < 3; ++axis) {
        if (!any_axis[axis]) continue;
        const std::string name(1, "xyz"[axis]);
        body_curve(name, name, fmt::format("along {0}, by {0}", name));
        body_curve("time", name, fmt::format("along {}, by time", name));
        body_curve("v" + name, name, fmt::format("along {}, by the velocity along it", name));
      }
      if (any_spin && kind == RecordingKind::trajectory && s_.spin > 0 && s_.duration > 0) {
        body_curve("spin", "against_spin", "a torque against the spin, by the spin");
        body_curve("time", "against_spin", "a torque against the spin, by time");
      }
    }
    if (s_.overlap > 0) {
      contact_curve("overlap", "both", "in the contact, by overlap");
      contact_curve("overlap", "loading", "while loading, by overlap");
      contact_curve("overlap", "unloading", "while unloading, by overlap");
      contact_curve("normal_velocity", "both", "in the contact, by the normal velocity");
      contact_curve("time", "both", "in the contact, by the time since first touch");
    }
    return std::move(found_);
  }

 private:
  static bool known(const std::string& key) { return find_key(split_path(key)) != nullptr; }
  bool given(const std::string& key) const { return experiment_.base().has(key); }
  double number(const std::string& key) const { return experiment_.base().number(key); }
  bool is_free(const std::string& key) const {
    return std::any_of(baseline_.moved.begin(), baseline_.moved.end(), [&](const Parameter& p) { return join_path(p.path) == key; });
  }

  static Parameter moving(const std::string& key, double null, double lower, double upper, double scale) {
    Parameter p;
    p.name = key;
    p.path = split_path(key);
    p.value = null;
    p.lower = lower, p.upper = upper;
    p.scale = scale;
    return p;
  }

  // One number that moves from where nothing happens. What the case gives already, or sets free, is not missing.
  Candidate* single(const std::string& effect, const std::string& form, const std::string& key, double null, double lower, double upper, std::vector<double> probes,
                    std::vector<Setting> settings = {}) {
    if (!known(key) || is_free(key) || (given(key) && number(key) != null)) return nullptr;
    std::erase_if(probes, [&](double x) { return !std::isfinite(x) || x < lower || x > upper || x == null; });
    if (probes.empty()) return nullptr;
    Candidate c;
    c.effect = effect, c.form = form;
    c.parameters = {moving(key, null, lower, upper, std::abs(probes.front() - null))};
    for (double probe : probes) c.probes.push_back({probe});
    c.settings = std::move(settings);
    found_.push_back(std::move(c));
    return &found_.back();
  }

  void bodies() {
    const double weight = s_.mass * std::max(s_.acceleration, 1e-9);
    const double area = pi * s_.radius * s_.radius, volume = 4.0 / 3.0 * area * s_.radius;
    const double fluid = known("medium.density") ? number("medium.density") : 1.2;
    const double viscosity = known("medium.viscosity") ? number("medium.viscosity") : 1.8e-5;
    if (s_.speed > 0) {
      const double quadratic = 0.5 * fluid * area * s_.speed * s_.speed, stokes = 6 * pi * s_.radius * s_.speed;
      single("air_drag", "constant coefficient", "medium.drag_coefficient", 0, 0, 1e4, {0.02 * weight / quadratic, 0.2 * weight / quadratic, 0.47, 0.002 * weight / quadratic});
      if (2 * s_.radius * s_.speed * fluid / viscosity < 1e4 && known("medium.drag"))
        single("air_drag", "Schiller and Naumann's curve", "medium.drag_coefficient", 0, 0, 1e3, {0.1, 1.0}, {{"medium.drag", std::string("schiller_naumann")}});
      single("viscous_drag", "", "medium.viscous_drag", 0, 0, 1e9, {0.02 * weight / stokes, 0.2 * weight / stokes, 0.002 * weight / stokes});
    }
    if (s_.gravity > 0) single("buoyancy", "", "medium.buoyancy", 0, 0, 0.98 * s_.density, {0.02 * s_.density, 0.2 * s_.density});
    single("added_mass", "", "medium.added_mass_coefficient", 0, 0, 5 * s_.density / fluid, {0.02 * s_.density / fluid, 0.2 * s_.density / fluid});
    if (s_.spin > 0 && s_.speed > 0) {
      const double lift = 0.75 * fluid * volume * s_.spin * s_.speed;
      single("magnus", "", "medium.magnus_coefficient", 0, 0, 1e4, {0.02 * weight / lift, 0.2 * weight / lift});
    }
  }

  void contacts() {
    const std::string pair = experiment_.pair_table() + ".";
    const bool touches = s_.overlap > 0;
    if (!touches) return;
    const double contact_time = std::max(s_.contact_time, 1e-9);
    single("rolling_resistance", "", pair + "rolling_friction", 0, 0, 2, {0.002, 0.02, 0.2});
    single("torsional_friction", "", pair + "torsional_friction", 0, 0, 5, {0.005, 0.05, 0.5});
    single("sliding_friction", "", pair + "friction", 0, 0, 5, {0.01, 0.1, 0.4});
    const bool rubs = given(pair + "friction") && number(pair + "friction") > 0;
    // From a contact that sticks without a spring, or from the law's own spring.
    if (const std::string key = pair + "tangential_compliance"; rubs) {
      if (given(key) && number(key) == 0) single("tangential_compliance", "", key, 0, 1e-4, 30, {1.0, 3.0, 0.3, 0.03, 0.003});
      else single("tangential_compliance", "", key, 1, 1e-4, 30, {1.3, 0.7, 4.0, 0.1, 0.003});
    }
    if (!(s_.impact_speed > 0)) return;  // it only lies there
    const bool inelastic = given(pair + "restitution") && number(pair + "restitution") < 1;
    if (inelastic) {
      // Counted from the middle of the speeds, so that it and the restitution do not stand for one another.
      std::vector<Setting> reference;
      if (!given(pair + "reference_speed")) reference.push_back({pair + "reference_speed", s_.impact_speed});
      single("velocity_dependent_restitution", "1 − e as a power of the speed", pair + "restitution_exponent", 0, -2, 2, {0.1, -0.1, 0.4, -0.4}, reference);
    }
    single("velocity_dependent_restitution", "viscoelastic damping", pair + "viscoelastic_time", 0, 0, 10 * contact_time, {0.01 * contact_time, 0.1 * contact_time});
    single("plastic_contact", "unloading stiffer than loading", pair + "unloading_ratio", 1, 1, 100, {1.05, 1.5, 4});
    if (s_.force > 0) {
      // Hertz's greatest pressure, 3F/(2πa²), a² = R δ.
      const double pressure = 1.5 * s_.force / (pi * s_.radius * s_.overlap);
      const std::string law = experiment_.base().text(pair + "law");
      if (law == "hertz_mindlin" || law == "deresiewicz")
        if (Candidate* c = single("plastic_contact", "yielding at a pressure", pair + "yield_pressure", 2 * pressure, 0.01 * pressure, 2 * pressure, {0.8 * pressure, 0.5 * pressure, 0.2 * pressure}))
          c->parameters[0].scale = 0.1 * pressure;
      single("nonlinear_stiffness", "hardening", pair + "hardening", 0, -0.9 / s_.overlap, 50 / s_.overlap, {0.05 / s_.overlap, -0.05 / s_.overlap, 0.5 / s_.overlap});
      single("nonlinear_stiffness", "another exponent", pair + "stiffness_power", 0, -0.9, 3, {0.05, -0.05, 0.4}, {{pair + "reference_overlap", 0.5 * s_.overlap}});
      const double strongest = s_.force / (1.5 * pi * s_.radius);  // whose pull-off is the greatest force
      single("adhesion", "", pair + "surface_energy", 0, 0, strongest, {0.005 * strongest, 0.05 * strongest, 2e-4 * strongest});
      const double cube = s_.radius * s_.radius * s_.radius;
      if (known(pair + "bridge_volume") && !given(pair + "bridge_volume")) {
        Candidate c;
        c.effect = "liquid_bridge";
        constexpr double any_liquid = 1;  // twice mercury's [N/m]
        const double strongest_tension = std::min(any_liquid, s_.force / (2 * pi * s_.radius)), tension = std::min(0.2 * any_liquid, 0.02 * s_.force / (2 * pi * s_.radius));
        c.parameters = {moving(pair + "surface_tension", 1e-12, 1e-12, strongest_tension, tension),
                        moving(pair + "bridge_volume", 1e-3 * cube, 1e-7 * cube, 0.3 * cube, 1e-3 * cube)};
        c.probes = {{tension, 1e-3 * cube}, {5 * tension, 1e-3 * cube}, {tension, 3e-2 * cube}, {0.03 * tension, 3e-3 * cube}};
        found_.push_back(c);
      }
      const double film = 0.05 * s_.radius, speed = std::max(s_.impact_speed, 1e-9);
      const double viscosity = 0.02 * s_.force * 0.1 * film / (6 * pi * s_.radius * s_.radius * speed);
      if (known(pair + "film_viscosity") && !given(pair + "film_viscosity")) {
        // How near the bodies come to one another in the film tells what it takes on the way in from what it takes in the contact.
        Candidate c;
        c.effect = "lubrication";
        c.parameters = {moving(pair + "film_viscosity", 0, 0, 1e4 * viscosity, viscosity), moving(pair + "film_cutoff", 0.01 * film, 1e-4 * film, 0.9 * film, 0.01 * film)};
        c.settings = {{pair + "film_thickness", film}};
        c.probes = {{viscosity, 0.01 * film}, {10 * viscosity, 0.01 * film}, {viscosity, 0.1 * film}};
        found_.push_back(c);
      }
      single("wave_loss", "", pair + "wave_admittance", 0, 0, 10 * speed / s_.force, {0.01 * speed / s_.force, 0.1 * speed / s_.force});
    }
    single("powder_layer", "", pair + "powder_layers", 0, 0, 30, {0.2, 1, 4});
  }

  // Channels, and quantities of three, that were recorded, with the spread of their values.
  struct Shown {
    std::string target;
    double largest = 0, noise = 0, spacing = 0;
  };
  void note(std::vector<Shown>& list, const std::string& target, const Series& series) const {
    auto found = std::find_if(list.begin(), list.end(), [&](const Shown& one) { return one.target == target; });
    if (found == list.end()) found = list.insert(list.end(), Shown{target});
    for (double y : series.value) found->largest = std::max(found->largest, std::abs(y));
    const ChannelNoise& noise = baseline_.noise[static_cast<std::size_t>(series.channel)];
    found->noise = std::max(found->noise, noise.deviation * (series.deviation.empty() ? 1 : series.deviation.front()));
    found->spacing = std::max(found->spacing, noise.spacing);
  }

  void instruments() {
    std::vector<Shown> channels, quantities;
    double spacing = 0;
    for (const RecordedRun& run : experiment_.recording().runs) {
      for (const Series& series : run.series) {
        if (series.channel == Channel::impact) continue;
        note(channels, name_of(series.channel), series);
        note(quantities, quantity_of(series.channel), series);
        spacing = std::max(spacing, baseline_.noise[static_cast<std::size_t>(series.channel)].spacing);
      }
    }
    for (const Shown& one : channels) {
      const std::string t = "instrument." + one.target + ".";
      single("sensor_offset", one.target, t + "offset", 0, -one.largest, one.largest, {std::max(one.noise, 1e-4 * one.largest)});
    }
    for (const Shown& one : quantities) {
      const std::string t = "instrument." + one.target + ".";
      single("sensor_gain", one.target, t + "gain", 1, 0.3, 3, {1.01, 0.95});
      single("sensor_lag", one.target, t + "lag", 0, 0, 0.3 * s_.duration, {0.5 * one.spacing, 3 * one.spacing});
      if (quantities.size() > 1)
        single("clock_shift", one.target, t + "clock_shift", 0, -0.3 * s_.duration, 0.3 * s_.duration, {0.3 * one.spacing, 2 * one.spacing, -2 * one.spacing});
      if (Candidate* c = single("saturation", one.target, t + "saturation", one.largest * 1.5, 0.1 * one.largest, 1.5 * one.largest,
                                {0.97 * one.largest, one.largest - 3 * one.noise, one.largest - 12 * one.noise, 0.85 * one.largest, 0.6 * one.largest}))
        c->parameters[0].scale = 0.05 * one.largest;
    }
    if (spacing > 0) single("clock_shift", "", "instrument.clock_shift", 0, -0.3 * s_.duration, 0.3 * s_.duration, {0.3 * spacing, 2 * spacing, -2 * spacing});
  }

  void rivals() {
    if (s_.gravity > 0 && !std::any_of(baseline_.moved.begin(), baseline_.moved.end(), [](const Parameter& p) { return p.path == Path{"gravity"}; })) {
      Candidate c;
      c.effect = "gravity", c.form = "set free", c.rival = true;
      c.parameters = {moving("gravity", s_.gravity, 0.2 * s_.gravity, 5 * s_.gravity, 0.01 * s_.gravity)};
      c.parameters[0].component = Parameter::all_components;
      c.probes = {{1.02 * s_.gravity}};
      found_.push_back(c);
    }
    bool positions = false;
    double largest = 0;
    for (const RecordedRun& run : experiment_.recording().runs)
      for (const Series& series : run.series)
        if (series.channel < Channel::vx) {
          positions = true;
          for (double y : series.value) largest = std::max(largest, std::abs(y));
        }
    if (positions && largest > 0)
      if (Candidate* c = single("camera_distortion", "a scale that bends", "instrument.position.curvature", 0, -0.4 / largest, 0.4 / largest, {0.01 / largest})) c->rival = true;
  }

  // Places, velocities, speeds and spins that were recorded: least and most. Of a speed or spin, where all components were that the body has.
  std::pair<double, double> recorded_range(const std::string& variable) const {
    double least = 1e300, most = -1e300;
    const bool size = variable == "speed" || variable == "spin";
    for (const std::size_t run : baseline_.runs) {
      std::vector<double> squares;
      bool whole = true;
      for (const Series& series : experiment_.recording().runs[run].series) {
        const std::string name = name_of(series.channel);
        if (name == variable)
          for (const double value : series.value) least = std::min(least, value), most = std::max(most, value);
        if (!size || name.size() != 2 || name[0] != (variable == "spin" ? 'w' : 'v')) continue;
        whole &= squares.empty() || squares.size() == series.value.size();
        squares.resize(series.value.size());
        for (std::size_t k = 0; k < squares.size(); ++k) squares[k] += series.value[k] * series.value[k];
      }
      for (const double square : squares)
        if (whole) least = std::min(least, std::sqrt(square)), most = std::max(most, std::sqrt(square));
    }
    return {least, most};
  }

  // Knots evenly over what the body went through, in the calibrated case or as recorded.
  std::vector<double> knots(const std::function<double(const Experiment::Point&)>& of, bool in_contact, const std::string& variable = "") const {
    auto [least, most] = recorded_range(variable);
    for (std::size_t k = 0; k < baseline_.runs.size(); ++k) {
      const std::size_t run = baseline_.runs[k];
      Alteration altered{{}, baseline_.settings};
      for (std::size_t p = 0; p < baseline_.moved.size(); ++p) altered.changes.push_back({&baseline_.moved[p], baseline_.shared[p]});
      for (const Experiment::Point& point : experiment_.path(run, altered, baseline_.unknowns[run])) {
        if (in_contact && !(point.overlap > 0)) continue;
        least = std::min(least, of(point)), most = std::max(most, of(point));
      }
    }
    std::vector<double> all;
    constexpr int count = 5;
    if (most > least)
      for (int k = 0; k < count; ++k) all.push_back(least + (most - least) * k / (count - 1));
    return all;
  }

  void curve(const std::string& words, const std::string& value_key, std::vector<Setting> settings, std::size_t knots, double scale) {
    Candidate c;
    c.effect = "unknown", c.form = words, c.free_form = true;
    c.settings = std::move(settings);
    for (std::size_t k = 0; k < knots; ++k) {
      Parameter p = moving(fmt::format("{}[{}]", value_key, k), 0, -1e3 * scale, 1e3 * scale, scale);
      p.path = split_path(value_key);
      p.component = static_cast<int>(k);
      c.parameters.push_back(p);
    }
    c.probes.push_back(std::vector<double>(knots, 0.0));
    found_.push_back(std::move(c));
  }

  void body_curve(const std::string& variable, const std::string& direction, const std::string& words) {
    const std::string t = "force.learnt.";
    if (!known(t + "variable")) return;
    const std::vector<double> at = knots(
        [&](const Experiment::Point& p) {
          const Eigen::Map<const Vec3> v(p.velocity), w(p.spin);
          if (variable == "speed") return v.norm();
          if (variable == "spin") return w.norm();
          if (variable == "time") return p.time;
          return variable.size() == 1 ? p.position[variable[0] - 'x'] : p.velocity[variable[1] - 'x'];
        },
        false, variable);
    if (at.empty()) return;
    const std::vector<double> zeros(at.size(), 0.0);
    const double force = 0.02 * s_.mass * std::max(s_.acceleration, 1e-9), torque = 0.02 * 0.4 * s_.mass * s_.radius * s_.radius * s_.spin / s_.duration;
    curve(words, t + "values", {{t + "variable", variable}, {t + "direction", direction}, {t + "at", at}, {t + "values", zeros}}, at.size(), direction == "against_spin" ? torque : force);
  }

  void contact_curve(const std::string& variable, const std::string& phase, const std::string& words) {
    const std::string t = experiment_.pair_table() + ".extra_force";
    if (!known(t)) return;
    const std::vector<double> at = variable == "time" ? std::vector<double>{0, 0.25 * s_.contact_time, 0.5 * s_.contact_time, 0.75 * s_.contact_time, s_.contact_time}
                                                      : knots([&](const Experiment::Point& p) { return variable == "overlap" ? p.overlap : -p.overlap_rate; }, true);
    if (at.empty()) return;
    const std::vector<double> zeros(at.size(), 0.0);
    curve(words, t, {{t + "_variable", variable}, {t + "_phase", phase}, {t + "_at", at}, {t, zeros}}, at.size(), 0.02 * s_.force);
  }

  const Experiment& experiment_;
  const Fit& baseline_;
  const Sizes& s_;
  std::vector<Candidate> found_;
};

}  // namespace

Sizes sizes_of(const Comparison& comparison, const Fit& baseline) {
  const Experiment& e = comparison.experiment();
  Sizes sizes;
  std::vector<double> masses, radii, speeds, spins, impacts, accelerations, durations, contact_times;
  const Alteration altered = comparison.alteration_of(baseline);
  std::size_t lying = 0;
  for (const std::size_t run : baseline.runs) {
    const Values values = e.values_of(run, altered, baseline.unknowns[run]);
    const double radius = e.radius(run);
    const Case c = case_of(values);
    const double density = c.species[c.inserts[0].species].density;
    masses.push_back(density * 4.0 / 3.0 * pi * radius * radius * radius);
    radii.push_back(radius);
    sizes.density = std::max(sizes.density, density);
    sizes.gravity = c.gravity.norm();
    double first = 0, last = 0, touched = -1, together = 0, squares = 0;  // of the speed, by time: steps are short in contacts
    for (const Experiment::Point& p : e.path(run, altered, baseline.unknowns[run])) {
      const Eigen::Map<const Vec3> v(p.velocity), w(p.spin), a(p.acceleration);
      if (last == 0) first = last = p.time;
      squares += v.squaredNorm() * (p.time - last);
      if (p.overlap > 0) together += p.time - last;
      last = p.time;
      spins.push_back(w.norm());
      if (p.overlap > 0) {
        sizes.overlap = std::max(sizes.overlap, p.overlap);
        sizes.force = std::max(sizes.force, p.force);
        if (touched < 0) touched = p.time, impacts.push_back(std::abs(p.overlap_rate));
      } else {
        accelerations.push_back(a.norm());
        if (touched >= 0) contact_times.push_back(p.time - touched);
        touched = -1;
      }
    }
    durations.push_back(last - first);
    if (last > first) speeds.push_back(std::sqrt(squares / (last - first)));
    lying += together > 0.6 * (last - first);
  }
  sizes.mass = middle_of(masses), sizes.radius = middle_of(radii), sizes.speed = middle_of(speeds);
  sizes.spin = spins.empty() ? 0 : *std::max_element(spins.begin(), spins.end());
  // What lies on its wall does not hit it.
  const bool lies = e.recording().kind == RecordingKind::trajectory && 2 * lying > baseline.runs.size();
  sizes.impact_speed = lies ? 0 : middle_of(impacts);
  sizes.duration = middle_of(durations);
  sizes.contact_time = contact_times.empty() ? sizes.duration : middle_of(contact_times);
  sizes.acceleration = std::max(middle_of(accelerations), sizes.gravity);
  if (!(sizes.acceleration > 0) && sizes.mass > 0) sizes.acceleration = sizes.force / sizes.mass;
  return sizes;
}

std::vector<Candidate> candidates_for(const Comparison& comparison, const Fit& baseline, const Sizes& sizes) { return Collector(comparison, baseline, sizes).candidates(); }

std::vector<Candidate> free_forms_for(const Comparison& comparison, const Fit& baseline, const Sizes& sizes) { return Collector(comparison, baseline, sizes).free_forms(); }

std::vector<EffectEntry> all_effects() {
  return {
      {"air_drag", "medium.drag_coefficient (medium.density, medium.drag)", "against the velocity, growing as v² A/m; nothing at rest", "a lighter ball of the same size", "Newton; Schiller & Naumann 1933"},
      {"viscous_drag", "medium.viscous_drag", "against the velocity, growing as v d/m", "another size at one mass, or another speed", "Stokes 1851"},
      {"buoyancy", "medium.buoyancy", "constant, upward, as fluid over body density; there at rest too", "a denser ball; weighing it in the fluid", "Archimedes"},
      {"added_mass", "medium.added_mass_coefficient (medium.density)", "every acceleration smaller by one factor, those of contacts too", "a bounce: buoyancy leaves it alone", "Lamb 1932, § 92"},
      {"magnus", "medium.magnus_coefficient (medium.density)", "across the velocity, turns with the spin", "the same throw with the spin reversed", "Rubinow & Keller 1961"},
      {"rolling_resistance", "pair.<a>.<b>.rolling_friction", "slows rolling by a constant, also as v → 0", "a slower start", "Ai et al. 2011"},
      {"torsional_friction", "pair.<a>.<b>.torsional_friction", "slows the spin about the normal by a constant", "a spin about the normal alone", "Johnson 1985, § 7"},
      {"sliding_friction", "pair.<a>.<b>.friction", "slows sliding, ends when rolling begins", "an impact at another angle", "Coulomb"},
      {"tangential_compliance", "pair.<a>.<b>.tangential_compliance", "steep impacts rebound with the spin of a spring, not of a stick", "angles below 30° from the normal", "Mindlin 1949; Maw et al. 1976"},
      {"velocity_dependent_restitution", "pair.<a>.<b>.restitution_exponent, pair.<a>.<b>.viscoelastic_time", "each rebound keeps another part than the one before; nothing between rebounds", "drops from another height", "Kuwabara & Kono 1987; Brilliantov et al. 1996"},
      {"plastic_contact", "pair.<a>.<b>.unloading_ratio, pair.<a>.<b>.yield_pressure", "unloading is steeper than loading, whatever the rate; e falls as v^(−1/4)", "a second hit on the same spot", "Walton & Braun 1986; Thornton 1997"},
      {"nonlinear_stiffness", "pair.<a>.<b>.hardening, pair.<a>.<b>.stiffness_power", "the same on loading and unloading; peak and duration scale otherwise with the speed", "another speed", "Hertz 1882"},
      {"adhesion", "pair.<a>.<b>.surface_energy", "the force is below zero at parting; 1 − e² grows as v^(−2)", "a slower impact", "Johnson, Kendall & Roberts 1971"},
      {"liquid_bridge", "pair.<a>.<b>.bridge_volume, .surface_tension", "a pull that goes on after parting, to a rupture", "a dry repeat", "Willett et al. 2000"},
      {"lubrication", "pair.<a>.<b>.film_viscosity, .film_thickness", "slows the approach before touch", "a dry repeat", "Reynolds; Davis et al. 1986"},
      {"wave_loss", "pair.<a>.<b>.wave_admittance", "the wall gives way in proportion to the force: loss grows with mass", "another mass at one speed", "Goldsmith 1960"},
      {"powder_layer", "pair.<a>.<b>.powder_layers", "softer and more damped than clean bodies", "a clean repeat", "Mishra & Murty 2001, fig. 6"},
      {"slurry_drag", "medium.viscous_drag", "slows what flies and slides; moves toe and pool", "the same charge dry", "Stokes 1851"},
      {"bearing_torque", "mill.bearing_torque, mill.gear_loss", "power in proportion to the speed (gears: to the power), and no angle moves", "the empty mill", ""},
      {"lifter_wear", "mill.lifters.wear, mill.lifters.wear_rate", "less lift; grows with the time in use", "the height of the lifters, measured", ""},
      {"bond_strength_scatter", "bond.<a>.<b>.strength, .deviation, .modulus", "the curve of breakage rises over a wider range of energies, about the same middle", "repeats of one impact", "Weibull 1951"},
      {"rate_dependent_strength", "bond.<a>.<b>.rate_exponent, .reference_rate", "fast impacts break less than slow ones foretell; at one energy light and fast differs from heavy and slow", "the same energy by another mass", "Kipp, Grady & Chen 1980"},
      {"size_effect", "bond.<a>.<b>.size_exponent, .reference_size", "the curve of breakage shifts with the size of the body", "another size at one speed", "Weibull 1939"},
      {"sensor_offset", "instrument.<channel>.offset", "there before anything happens", "the reading at rest", ""},
      {"sensor_gain", "instrument.<channel>.gain", "all of a channel by one factor", "a known length or load", ""},
      {"sensor_lag", "instrument.<channel>.lag", "behind in proportion to the rate", "a step", ""},
      {"clock_shift", "instrument.clock_shift, instrument.<channel>.clock_shift", "in proportion to the rate; mostly in all channels alike", "a mark in both records", ""},
      {"saturation", "instrument.<channel>.saturation", "cut flat above one level", "a weaker signal", ""},
  };
}

const EffectEntry* find_effect(const std::string& name) {
  static const std::vector<EffectEntry> all = all_effects();
  const auto found = std::find_if(all.begin(), all.end(), [&](const EffectEntry& one) { return name == one.name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace quern
