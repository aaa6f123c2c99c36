#include "src/diagnose/experiment.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include "src/base/error.hpp"
#include "src/case/build.hpp"
#include "src/case/softening.hpp"
#include "src/diagnose/signal.hpp"
#include "src/engine/free_flight.hpp"

namespace quern {
namespace {

constexpr std::array softnesses = {1000.0, 300.0, 100.0, 30.0, 10.0, 3.0};  // that are tried for bodies that lie
constexpr double failed = std::numeric_limits<double>::quiet_NaN();

Path sorted_pair(Path path) {
  if (path.size() >= 3 && path[0] == "pair" && path[1] != "default" && path[1] > path[2]) std::swap(path[1], path[2]);
  return path;
}

// A line through the first samples of a series, at a time.
struct Line {
  double value, slope;
};
Line line_at(const Series& series, double time) {
  const std::size_t count = std::min<std::size_t>(series.t.size(), 6);
  double mean_t = 0, mean_y = 0;
  for (std::size_t k = 0; k < count; ++k) mean_t += series.t[k], mean_y += series.value[k];
  mean_t /= static_cast<double>(count), mean_y /= static_cast<double>(count);
  double above = 0, below = 0;
  for (std::size_t k = 0; k < count; ++k) above += (series.t[k] - mean_t) * (series.value[k] - mean_y), below += (series.t[k] - mean_t) * (series.t[k] - mean_t);
  const double slope = below > 0 ? above / below : 0;
  return {mean_y + slope * (time - mean_t), slope};
}

// The case where only walls and bodies count: its body may lie in a wall, and its step may be anything.
Case as_geometry(Case c) {
  c.inserts[0].allowed_overlap = no_bound;
  c.time_step = 1e-6;
  c.looked_at = true;
  return c;
}

// What is altered in one run.
Alteration in_run(const Alteration& altered, std::size_t run) {
  Alteration own{{}, altered.settings};
  for (const Change& change : altered.changes)
    if (const auto& runs = change.parameter->runs; runs.empty() || std::find(runs.begin(), runs.end(), run) != runs.end()) own.changes.push_back(change);
  return own;
}

// Gaps to a wall at which the force on a body jumps: touch, and where necks, bridges and films end [m].
std::vector<double> jumps_of(const Simulation& s, const Wall& wall) {
  std::vector<double> gaps{0};
  const std::uint8_t kind = s.pair_kind[s.particles.material[0] * s.materials.size() + wall.material];
  if (kind == no_law) return gaps;
  const Extras& x = s.pair_laws[kind].extras;
  const double radius = s.particles.radius(0);
  if (x.adhesion.work > 0) gaps.push_back(x.adhesion.reach(radius));
  if (x.bridge.volume > 0) gaps.push_back(x.bridge.reach(radius));
  if (x.lubrication.viscosity > 0) gaps.push_back(x.lubrication.thickness);
  return gaps;
}

// Until a body comes to the next of these gaps to a plane, under its present acceleration; no_bound where it does not.
double time_to_jump(const BodyState& body, const Wall& plane, const std::vector<double>& gaps) {
  const double acceleration = body.acceleration.dot(plane.pose.axes.col(2));
  double soonest = no_bound;
  for (const double gap : gaps) {
    const double way = body.gap - gap, root = body.gap_rate * body.gap_rate - 2 * acceleration * way;
    if (way * body.gap_rate < 0 && root > 0 && (gap > 0 || way > 0)) soonest = std::min(soonest, 2 * std::abs(way) / (std::sqrt(root) + std::abs(body.gap_rate)));
  }
  return soonest;
}

// Until the force between bodies that part has died away, as it fell in the last step; no_bound where it does not, or all but has.
double time_to_part(const BodyState& earlier, const BodyState& body) {
  if (!(body.gap < 0) || !(body.gap_rate > 0) || !(earlier.force > body.force) || !(body.force > 0)) return no_bound;
  const double time = body.force * (body.time - earlier.time) / (earlier.force - body.force);
  return time > 1e-3 * (body.time - earlier.time) ? time : no_bound;
}

double span_of(const Series& series) {
  const auto [least, most] = std::minmax_element(series.value.begin(), series.value.end());
  return *most - *least;
}

}  // namespace

void alter(Values& values, const Alteration& altered) {
  for (const Setting& setting : altered.settings) values.put(setting.key, setting.data, "fit");
  for (const auto& [parameter, value] : altered.changes) {
    const std::string key = join_path(parameter->path);
    if (parameter->component == -1) {
      values.put(key, value, "fit");
      continue;
    }
    std::vector<double> numbers = values.numbers(key);
    if (parameter->component == Parameter::all_components) {
      const double length = Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size())).norm();
      for (double& x : numbers) x *= value / length;
    } else {
      numbers[static_cast<std::size_t>(parameter->component)] = value;
    }
    values.put(key, numbers, "fit");
  }
}

Experiment::Experiment(Values base, const Recording& recording) : base_(std::move(base)), recording_(&recording) {
  const std::string file = base_.file;
  Case c = case_of(base_);
  if (c.inserts.size() != 1 || c.inserts[0].method != InsertCase::Method::list || c.inserts[0].balls.size() != 1 || c.inserts[0].agglomerate)
    throw InputError(file + ": a recording of one body needs a case that inserts one ball at one place (insert.<name>.positions); found another.");
  insert_ = c.inserts[0].name;
  species_ = c.species[c.inserts[0].species].name;
  if (c.species[c.inserts[0].species].sizes.smallest() != c.species[c.inserts[0].species].sizes.largest())
    throw InputError(file + ": a recording of one body needs a species of one diameter; found a distribution of sizes.");
  const Built built = build_case(as_geometry(c));
  double nearest = 1e300;
  const Vec3 centre = vec(built.simulation.particles.position[0]);
  for (std::size_t w = 0; w < built.simulation.walls.size(); ++w) {
    const double gap = std::abs(gap_to(built.simulation.walls[w], centre, built.simulation.particles.radius(0), 1e3 * built.simulation.particles.radius(0)));
    if (gap < nearest) nearest = gap, nearest_wall_ = w;
  }
  if (!built.simulation.walls.empty()) {
    std::string a = built.simulation.materials[c.species[c.inserts[0].species].material].name;
    std::string b = built.simulation.materials[built.simulation.walls[nearest_wall_].material].name;
    if (b < a) std::swap(a, b);
    pair_table_ = "pair." + a + "." + b;
    if (base_.where.count(split_path(pair_table_)) == 0) pair_table_ = "pair.default";
  }
  if (recording.kind != RecordingKind::trajectory && !has_wall())
    throw InputError(file + ": a recording of a contact or of impacts needs a wall in the case; found none.");
  estimates_start_ = base_.text("diagnose.initial_state") == "recording";
  prepared_.resize(recording.runs.size());
  for (std::size_t r = 0; r < recording.runs.size(); ++r) prepare(r);
  choose_steps();
}

Parameter Experiment::parameter(const std::string& key) const { return parameter_of(base_, key); }

Parameter parameter_of(const Values& base, const std::string& key) {
  Parameter p;
  p.name = key;
  p.path = sorted_pair(split_path(key));
  const Key* found = find_key(p.path);
  if (found == nullptr && p.path.size() > 1) {
    const std::string last = p.path.back();
    p.path.pop_back();
    found = find_key(p.path);
    if (found != nullptr && found->kind == KeyKind::vector && (last == "x" || last == "y" || last == "z")) p.component = last[0] - 'x';
    else found = nullptr;
  }
  if (found == nullptr || (found->kind != KeyKind::number && p.component < 0))
    base.refuse("diagnose.free", fmt::format("found \"{}\", which is no number of a case; the nearest known key is {}", key, nearest_key(split_path(key))));
  const std::string path = join_path(p.path);
  if (p.component >= 0) p.value = base.vector(path)[p.component];
  else if (base.has(path)) p.value = base.number(path);
  else if (found->fallback[0] != 0 && !found->required()) p.value = base.number(path);
  else base.refuse("diagnose.free", fmt::format("found \"{}\", which the case does not give; allowed are keys that it gives", key));
  const double size = std::abs(p.value);
  p.lower = std::max(found->range.least, p.value == 0 ? -no_bound : p.value - 0.9 * size);
  p.upper = std::min(found->range.most, p.value == 0 ? no_bound : p.value + 9 * size);
  if (found->range.least >= 0 && p.value > 0) p.lower = std::max(p.lower, 0.1 * p.value);
  const std::string bounds = "diagnose.bounds";
  for (const auto& [given, value] : base.given) {
    if (given.size() != 3 || given[0] != "diagnose" || given[1] != "bounds" || sorted_pair(split_path(given[2])) != sorted_pair(split_path(key))) continue;
    const auto& ends = std::get<std::vector<double>>(value.data);
    if (ends.size() != 2 || !(ends[0] < ends[1]))
      throw InputError(fmt::format("{}: diagnose.bounds.{}: allowed are two ascending numbers [least, greatest].", value.where, given[2]));
    p.lower = std::max(ends[0], found->range.least), p.upper = std::min(ends[1], found->range.most);
    if (!(p.lower <= p.value && p.value <= p.upper))
      throw InputError(fmt::format("{}: diagnose.bounds.{}: found [{}, {}], without the case's own value {}; allowed are bounds about it.", value.where, given[2], ends[0], ends[1], p.value));
  }
  p.scale = size > 0 ? 0.1 * size : std::isfinite(p.upper - p.lower) ? 0.1 * (p.upper - p.lower) : 1;
  return p;
}

void Experiment::prepare(std::size_t r) {
  const RecordedRun& run = recording_->runs[r];
  Prepared& p = prepared_[r];
  p.values = base_;
  const auto condition = [&](const char* name) -> std::optional<double> {
    const auto found = run.conditions.find(name);
    return found == run.conditions.end() ? std::nullopt : std::optional(found->second);
  };
  for (const auto& [name, value] : run.conditions)
    if (name.find('.') != name.npos) {
      const Parameter given = parameter(name);
      alter(p.values, {{{&given, value}}, {}});
    }
  if (const auto diameter = condition("diameter")) p.values.put("species." + species_ + ".diameter", *diameter, run.where);
  if (const auto density = condition("density")) p.values.put("species." + species_ + ".density", *density, run.where);
  const double diameter = p.values.number("species." + species_ + ".diameter");
  if (!(diameter > 0)) throw InputError(run.where + ": diameter: allowed is more than 0 m.");
  if (const auto mass = condition("mass")) {
    if (!(*mass > 0)) throw InputError(run.where + ": mass: allowed is more than 0 kg.");
    p.values.put("species." + species_ + ".density", *mass / (std::numbers::pi / 6 * diameter * diameter * diameter), run.where);
  }
  p.radius = 0.5 * diameter;
  const Case c = case_of(p.values);
  const InsertCase::Ball& ball = c.inserts[0].balls[0];
  p.position = ball.position, p.velocity = ball.velocity, p.spin = ball.spin;

  if (condition("impact_speed") || condition("drop_height")) {
    if (!has_wall()) throw InputError(fmt::format("{}: found impact_speed or drop_height, but the case has no wall to meet; allowed is a case with one.", run.where));
    const Built built = build_case(as_geometry(c));
    const Wall& wall = built.simulation.walls[nearest_wall_];
    if (!std::holds_alternative<Plane>(wall.surface)) throw InputError(run.where + ": impact_speed and drop_height are counted from a plane; the case's nearest wall is none.");
    const Vec3 normal = wall.pose.axes.col(2);
    const double height = condition("drop_height").value_or(0);
    p.position += (p.radius + height - (p.position - wall.pose.origin).dot(normal)) * normal;
    if (const auto speed = condition("impact_speed")) {
      const Vec3 along = (Vec3::UnitX() - Vec3::UnitX().dot(normal) * normal).normalized();
      const double angle = condition("impact_angle").value_or(0);
      p.velocity = *speed * (std::sin(angle) * along - std::cos(angle) * normal);
    } else {
      p.velocity.setZero();
    }
  }
  const char* states[3][3] = {{"x0", "y0", "z0"}, {"vx0", "vy0", "vz0"}, {"wx0", "wy0", "wz0"}};
  Vec3* parts[3] = {&p.position, &p.velocity, &p.spin};
  const bool trajectory = recording_->kind == RecordingKind::trajectory;
  const bool told = condition("impact_speed").has_value() || condition("drop_height").has_value();
  p.start = 0;
  bool estimated = false;
  for (int kind = 0; kind < 3; ++kind) {
    for (int axis = 0; axis < 3; ++axis) {
      if (const auto given = condition(states[kind][axis])) {
        (*parts[kind])[axis] = *given;
        continue;
      }
      if (!trajectory || !estimates_start_ || told) continue;
      const Series* place = run.find(static_cast<Channel>(axis));
      const Series* speed = run.find(static_cast<Channel>(3 + axis));
      const Series* spin = run.find(static_cast<Channel>(6 + axis));
      const Series* own = kind == 0 ? place : kind == 1 ? (speed ? speed : place) : spin;
      if (own == nullptr || (kind == 1 && own == place && place->t.size() < 2)) continue;
      if (!estimated) p.start = run.first_time();
      estimated = true;
      const Line line = line_at(*own, p.start);
      const double guess = kind == 1 && own == place ? line.slope : line.value;
      const double span = std::max(span_of(*own), 1e-3 * std::abs(guess));
      const double duration = std::max(run.last_time() - p.start, 1e-12);
      const double scale = 1e-3 * (kind == 1 && own == place ? span / duration : span);
      p.unknowns.push_back({static_cast<Unknown::Kind>(kind), axis, guess, scale > 0 ? scale : 1e-6});
      (*parts[kind])[axis] = guess;
    }
  }
  if (recording_->kind == RecordingKind::impacts) {
    const Series& series = run.series.front();
    p.unknowns.push_back({Unknown::Kind::clock, 0, 0, 1e-3 * std::max(series.value.back() - series.value.front(), 1e-3)});
    // Without a height to fall from, the first rebound tells it.
    if (estimates_start_ && !told && !condition("z0")) p.unknowns.push_back({Unknown::Kind::position, 2, p.position.z(), 1e-3 * std::abs(p.position.z())});
  }
}

Experiment::Start Experiment::start_of(std::size_t r, const std::vector<double>& unknowns) const {
  const Prepared& p = prepared_[r];
  Start start{p.position, p.velocity, p.spin};
  for (std::size_t k = 0; k < p.unknowns.size(); ++k) {
    const Unknown& u = p.unknowns[k];
    if (u.kind == Unknown::Kind::position) start.position[u.axis] = unknowns[k];
    if (u.kind == Unknown::Kind::velocity) start.velocity[u.axis] = unknowns[k];
    if (u.kind == Unknown::Kind::spin) start.spin[u.axis] = unknowns[k];
    if (u.kind == Unknown::Kind::clock) start.clock = unknowns[k];
  }
  return start;
}

Values Experiment::values_of(std::size_t r, const Alteration& altered, const std::vector<double>& unknowns) const {
  Values values = prepared_[r].values;
  alter(values, in_run(altered, r));
  const Start start = start_of(r, unknowns);
  const std::string t = "insert." + insert_;
  values.put(t + ".positions", std::vector<Vec3>{start.position}, "fit");
  values.put(t + ".velocity", std::vector<double>{start.velocity.x(), start.velocity.y(), start.velocity.z()}, "fit");
  values.put(t + ".spin", std::vector<double>{start.spin.x(), start.spin.y(), start.spin.z()}, "fit");
  values.given.erase(split_path(t + ".speed"));
  return values;
}

Case Experiment::case_for(std::size_t r, const Alteration& altered, const std::vector<double>& unknowns) const {
  Values values = prepared_[r].values;
  alter(values, in_run(altered, r));
  Case c = case_of(values);
  const Start start = start_of(r, unknowns);
  InsertCase::Ball& ball = c.inserts[0].balls[0];
  ball.position = start.position, ball.velocity = start.velocity, ball.spin = start.spin;
  c.inserts[0].allowed_overlap = 1;
  c.time_step = steps[r].time_step;
  c.looked_at = true;
  if (steps[r].softness > 1) soften(c, steps[r].softness);
  return c;
}

// How much softer contacts may be: a body that lies still sinks in by no more than some thousandths of its radius.
double Experiment::softness_at_rest(std::size_t r) const {
  constexpr double deepest = 3e-3;
  constexpr int settling = 600;  // steps
  for (const double softness : softnesses) {
    Case c = case_of(prepared_[r].values);
    c.inserts[0].balls[0] = {prepared_[r].position, Vec3::Zero(), Vec3::Zero()};
    c.inserts[0].allowed_overlap = 1;
    c.time_step.reset();
    soften(c, softness);
    Simulation s = build_case(c).simulation;
    s.start(false);
    double sum = 0;
    for (int k = 0; k < settling; ++k) {
      s.step();
      sum -= body_state(s, &s.walls[nearest_wall_]).gap;
    }
    if (sum / settling < deepest * prepared_[r].radius) return softness;
  }
  return 1;
}

// The step is a part of what the law's own collision allows, or the case's own where that is longer: a fit needs thousands of runs, and the difference that
// finer steps make is taken off and held against the noise. Where the recording is not of the contact itself, a step near the limit serves, and a longer one
// where the body lies in its contact; if all do, contacts are softer too, as far as they stay shallow. Each run has its own: light bodies need short steps.
void Experiment::choose_steps() {
  constexpr double of_limit_lying = 1.8, of_limit = 0.6, of_recommended = 0.1;
  steps = Steps(runs(), {});
  bool all_lie = true;
  for (std::size_t r = 0; r < runs(); ++r) {
    Case c = case_of(prepared_[r].values);
    InsertCase::Ball& ball = c.inserts[0].balls[0];
    ball.position = prepared_[r].position, ball.velocity = prepared_[r].velocity, ball.spin = prepared_[r].spin;
    c.inserts[0].allowed_overlap = 1;
    const std::optional<double> asked = c.time_step;
    c.time_step.reset();
    const Built built = build_case(c);
    const double duration = recording_->runs[r].last_time() - prepared_[r].start;
    bool lies = false;
    for (const Wall& wall : built.simulation.walls) {
      const double gap = gap_to(wall, prepared_[r].position, prepared_[r].radius, prepared_[r].radius);
      const double normal_speed = std::abs(prepared_[r].velocity.dot(wall.pose.axes.col(2)));
      lies |= std::holds_alternative<Plane>(wall.surface) && std::abs(gap) < 0.02 * prepared_[r].radius && normal_speed < 0.02 * built.expected_speed &&
              duration > 50 * built.limit.limit;
    }
    all_lie &= lies;
    const bool one_impact = recording_->kind == RecordingKind::contact || recording_->runs[r].conditions.count("impact_speed") > 0;
    const double sound = lies ? of_limit_lying * built.limit.limit : one_impact ? of_recommended * built.limit.recommended : of_limit * built.limit.limit;
    const double step = std::min(one_impact ? sound : std::max(asked.value_or(0), sound), duration / 50);
    steps[r] = {step, std::max(step, duration / 100)};
  }
  for (std::size_t r = 0; r < runs() && all_lie; ++r) {
    const double softness = softness_at_rest(r);
    if (!(softness > 1)) continue;
    Case c = case_of(prepared_[r].values);
    c.inserts[0].allowed_overlap = 1;
    c.time_step.reset();
    soften(c, softness);
    const double step = steps[r].time_step;
    const double soft_step = std::min({step * std::sqrt(softness), of_limit_lying * build_case(c).limit.limit, (recording_->runs[r].last_time() - prepared_[r].start) / 200});
    if (soft_step > step) steps[r] = {soft_step, std::max(soft_step, steps[r].longest_flight_step), softness, step};
  }
}

template <class Watcher>
bool Experiment::go(std::size_t r, const Case& c, double until, Watcher&& watch) const {
  Simulation s = build_case(c).simulation;
  s.start(false);
  const Wall* wall = s.walls.empty() ? nullptr : &s.walls[nearest_wall_];
  const Wall* plane = wall != nullptr && std::holds_alternative<Plane>(wall->surface) ? wall : nullptr;
  const std::vector<double> jumps = plane != nullptr ? jumps_of(s, *plane) : std::vector<double>();
  BodyState now = body_state(s, wall), earlier = now;
  const double time_step = steps[r].time_step;
  const auto most = static_cast<std::int64_t>(steps[r].longest_flight_step / time_step * (1 + 1e-9));
  constexpr std::int64_t most_steps = 20'000'000;
  std::int64_t taken = 0;
  while (now.time < until && taken++ < most_steps) {
    const BodyState before = now;
    const std::int64_t free = most > 1 ? free_steps(s, most) : 1;
    try {
      // Contacts begin and end on a step: what steps err by is then a smooth function of their length and of what a fit moves.
      // The last bit of the way is a step of its own, since a dashpot's force jumps at first touch and would act on all of the step that ends there.
      const bool watches = most > 1 && free == 1 && plane;
      const double jump = watches ? time_to_jump(now, *plane, jumps) : no_bound, part = watches ? time_to_part(earlier, now) : no_bound, bit = 1e-6 * time_step;
      earlier = before;
      if (free > 1) s.fly(free);
      else if (jump < time_step) s.fly_for(jump > 10 * bit ? jump - 5 * bit : jump + bit);
      else if (part < time_step) s.fly_for(part);
      else s.step();
    } catch (const RunError&) {
      return false;
    }
    now = body_state(s, wall);
    if (!watch(before, now)) return true;
  }
  return now.time >= until;
}

Experiment::Prediction Experiment::predict(std::size_t r, const Alteration& altered, const std::vector<double>& unknowns, double part, double late) const {
  const RecordedRun& run = recording_->runs[r];
  Prediction result;
  const double end = part >= 1 ? no_bound : run.first_time() + part * (run.last_time() - run.first_time());
  const auto beyond = [&](const Series& series, std::size_t k) { return (series.channel == Channel::impact ? series.value[k] : series.t[k]) > end; };
  for (const Series& series : run.series) result.emplace_back(series.value.size(), failed);
  Case c;
  try {
    c = case_for(r, altered, unknowns);
    c.instrument.clock_shift += late;
    const double start = prepared_[r].start;
    if (recording_->kind == RecordingKind::impacts) {
      const Series& series = run.series.front();
      const double clock = start_of(r, unknowns).clock;
      std::vector<double>& predicted = result.front();
      double count = 0;
      std::size_t next = 0;
      const double patience = 3 * (run.last_time() - series.value.front()) + 3 * std::abs(run.last_time());
      const bool ran = go(r, c, patience, [&](const BodyState& before, const BodyState& now) {
        if (!(before.gap >= 0 && now.gap < 0)) return true;
        ++count;
        if (count == series.t[next]) predicted[next++] = clock + c.instrument.clock_shift + touch_time(before, now);
        return next < predicted.size() && !beyond(series, next);
      });
      if (!ran) std::fill(predicted.begin() + static_cast<std::ptrdiff_t>(next), predicted.end(), failed);
      for (; next < predicted.size() && beyond(series, next); ++next) predicted[next] = series.value[next];
      return result;
    }
    SignalReader reader(run, c.instrument, start);
    const double until = std::min(run.last_time(), end) - start - c.instrument.earliest_shift() + steps[r].time_step;
    bool first = true;
    const bool ran = go(r, c, until, [&](const BodyState& before, const BodyState& now) {
      if (first) reader.begin(before);
      first = false;
      return reader.see(before, now);
    });
    if (ran) result = reader.values();
    for (std::size_t s = 0; ran && s < run.series.size(); ++s)
      for (std::size_t k = 0; k < run.series[s].value.size(); ++k)
        if (beyond(run.series[s], k)) result[s][k] = run.series[s].value[k];
  } catch (const std::exception&) {  // a law that cannot be, a body beyond all bounds: a fit that strays there comes back
  }
  return result;
}

std::vector<Experiment::Point> Experiment::path(std::size_t r, const Alteration& altered, const std::vector<double>& unknowns) const {
  std::vector<Point> points;
  const RecordedRun& run = recording_->runs[r];
  const Case c = case_for(r, altered, unknowns);
  const double start = prepared_[r].start;
  std::int64_t impacts = 0;
  const auto add = [&](const BodyState& s) {
    Point p;
    p.time = s.time + start;
    for (int a = 0; a < 3; ++a) {
      p.position[a] = s.position[a], p.velocity[a] = s.velocity[a], p.spin[a] = s.spin[a], p.acceleration[a] = s.acceleration[a];
    }
    p.overlap = -s.gap, p.overlap_rate = -s.gap_rate, p.force = s.force, p.impacts = impacts;
    points.push_back(p);
  };
  go(r, c, run.last_time() - start, [&](const BodyState& before, const BodyState& now) {
    if (points.empty()) add(before);
    if (before.gap >= 0 && now.gap < 0) ++impacts;
    add(now);
    return true;
  });
  return points;
}

}  // namespace quern
