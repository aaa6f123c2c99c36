// The simulation behind a recording: the same motion as a run of the case, its flights, what instruments show of it, and the noise about it.
#include "src/diagnose/experiment.hpp"
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include "src/base/archive.hpp"
#include "src/case/build.hpp"
#include "src/diagnose/comparison.hpp"
#include "src/observe/observers.hpp"
#include "tests/folder.hpp"
#include "tests/results.hpp"

using namespace quern;

namespace {

constexpr double g = 9.81;

// A spinning ball thrown onto a plate in air. Its instants are sums of powers of two, so that none is rounded.
const char* thrown = R"(
duration = 1
gravity = [0, 0, -9.81]
time_step.value = 0.00006103515625
[material.rubber]
density = 900
young = "10 MPa"
[pair.default]
restitution = 0.7
friction = 0.4
[species.ball]
material = "rubber"
diameter = "50 mm"
[wall.plate]
type = "plane"
material = "rubber"
[medium]
drag_coefficient = 0.5
magnus_coefficient = 1
[insert.one]
species = "ball"
positions = [[0, 0, 0.7]]
velocity = [1.5, 0.2, 0.5]
spin = [0, 60, 5]
[observe]
track = [0]
track_interval = 0.0078125
[diagnose]
initial_state = "case"
)";

// A light ball that meets nothing.
const char* alone = R"(
duration = 1
gravity = [0, 0, -9.81]
time_step.value = 1e-3
[material.foam]
density = 100
young = 1e7
[medium]
drag_coefficient = 0.47
[species.ball]
material = "foam"
diameter = 0.1
[insert.one]
species = "ball"
positions = [[0, 0, 0]]
)";

Values values_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Folder folder("experiment");
  return read_values(folder.write("case.toml", text), overrides);
}

// Stepped and watched as `quern run` does it.
Observers run_of(const Case& c) {
  Built built = build_case(c);
  Observers observers(built.observe);
  Simulation& s = built.simulation;
  s.start(observers.needs_collisions());
  observers.see(s);
  const auto steps = static_cast<std::int64_t>(std::ceil(c.duration / s.clock.time_step * (1 - 1e-12)));
  while (s.clock.step < steps) s.step(), observers.see(s);
  observers.finish(s);
  return observers;
}

std::vector<double> evenly(double from, double to, int count) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(from + (to - from) * k / (count - 1));
  return times;
}

Recording recording_at(const std::vector<Channel>& channels, const std::vector<double>& times) {
  Recording recording;
  RecordedRun run;
  run.label = "1", run.where = "here";
  for (const Channel channel : channels) run.series.push_back({channel, times, std::vector<double>(times.size(), 0.0), {}, {}});
  recording.runs.push_back(run);
  return recording;
}

}  // namespace

TEST_CASE("a comparison's trajectory is bit for bit the track of a run of the case", "[diagnose][experiment]") {
  const Values values = values_of(thrown);
  const double dt = values.number("time_step.value");
  const Folder folder("experiment");
  const std::vector<TrackPoint> track = run_of(read_case(folder.write("echo.toml", complete_case(values)))).track.points;
  REQUIRE(track.size() == 129);
  std::vector<double> times;
  for (const TrackPoint& point : track) times.push_back(point.time);
  using enum Channel;
  const Recording recording = recording_at({x, y, z, vx, vy, vz, wx, wy, wz}, times);
  Experiment experiment(values, recording);
  experiment.steps = Steps(experiment.runs(), {dt, dt});
  const Experiment::Prediction predicted = experiment.predict(0, {}, {});
  std::size_t differing = 0;
  for (std::size_t k = 0; k < track.size(); ++k) {
    const TrackPoint& p = track[k];
    const double told[] = {p.position.x, p.position.y, p.position.z, p.velocity.x, p.velocity.y, p.velocity.z, p.spin.x, p.spin.y, p.spin.z};
    for (std::size_t channel = 0; channel < 9; ++channel) differing += told[channel] != predicted[channel][k];
  }
  CHECK(differing == 0);
  // It bounced, and friction turned it.
  CHECK(track.back().spin.y != 60);
  CHECK(*std::min_element(predicted[2].begin(), predicted[2].end()) < 0.03);
}

TEST_CASE("flights in longer steps have the error of the scheme, and bounces are the same", "[diagnose][experiment]") {
  const std::vector<double> times = evenly(0, 1, 41);
  using enum Channel;
  const Recording flying = recording_at({x, z, vz}, times);
  Experiment experiment(values_of(alone, {"diagnose.initial_state=case", "insert.one.velocity=[3, 0, 4]"}), flying);
  const double dt = 1.0 / 4096;
  const auto with = [&](int longest) {
    experiment.steps = Steps(experiment.runs(), {dt, longest * dt});
    return experiment.predict(0, {}, {});
  };
  const Experiment::Prediction exact = with(1);
  const auto error_of = [&](int longest) {
    const Experiment::Prediction found = with(longest);
    double error = 0;
    for (std::size_t s = 0; s < exact.size(); ++s)
      for (std::size_t k = 0; k < times.size(); ++k) error = std::max(error, std::abs(found[s][k] - exact[s][k]));
    return error;
  };
  const double coarse = error_of(64), middle = error_of(32), fine = error_of(16);
  CAPTURE(coarse, middle, fine);
  CHECK(coarse / middle == Approx(4).epsilon(0.1));
  CHECK(middle / fine == Approx(4).epsilon(0.1));
  CHECK(fine < 1e-5);

  // Onto the plate: steps shrink before it, and no touch is flown through. It falls elsewhere within a step, as with another step.
  const Recording bouncing = recording_at({x, z}, times);
  Experiment onto_plate(values_of(thrown), bouncing);
  const double step = onto_plate.base().number("time_step.value");
  onto_plate.steps = Steps(onto_plate.runs(), {step, step});
  const Experiment::Prediction shortest = onto_plate.predict(0, {}, {});
  onto_plate.steps = Steps(onto_plate.runs(), {step, 64 * step});
  const Experiment::Prediction longer = onto_plate.predict(0, {}, {});
  for (std::size_t k = 0; k < times.size(); ++k) CHECK(longer[1][k] == Approx(shortest[1][k]).margin(1e-3 * 0.7));
}

TEST_CASE("the signal of a run is what a comparison takes it for, through every instrument", "[diagnose][experiment][signal]") {
  const std::vector<std::vector<std::string>> instruments = {
      {},
      {"instrument.clock_shift=0.01"},
      {"instrument.clock_shift=-0.01"},
      {"instrument.clock_shift=0.002", "instrument.velocity.clock_shift=-0.007", "instrument.z.clock_shift=0.01"},
      {"instrument.position.gain=0.977", "instrument.z.offset=0.01", "instrument.z.curvature=0.02"},
      {"instrument.velocity.lag=3 ms", "instrument.position.lag=20 us", "instrument.vx.saturation=1.2"},
  };
  for (std::vector<std::string> overrides : instruments) {
    CAPTURE(overrides);
    overrides.push_back("observe.signal=true");
    const Values values = values_of(thrown, overrides);
    const Table table = table_of(run_of(case_of(values)).tables(), "signal");
    const std::vector<double>& t = column(table, "t").values;
    CHECK(t.size() >= 127);
    CHECK(t[2] == 0.015625);
    using enum Channel;
    const std::vector<Channel> channels = {x, z, vx, vz, wy};
    const Recording recording = recording_at(channels, t);
    Experiment experiment(values, recording);
    experiment.steps = Steps(experiment.runs(), {values.number("time_step.value"), values.number("time_step.value")});
    const Experiment::Prediction predicted = experiment.predict(0, {}, {});
    for (std::size_t s = 0; s < channels.size(); ++s) {
      CAPTURE(name_of(channels[s]));
      CHECK(column(table, name_of(channels[s])).values == predicted[s]);
    }
  }
}

TEST_CASE("instruments show what their formulas say", "[diagnose][experiment][signal]") {
  // x = 2 t: a lag τ that began at the first instant shown, t₀, makes 2 (t − τ + τ exp(−(t − t₀)/τ)) of it, whatever the step.
  const Values values = values_of(alone, {"gravity=[0, 0, 0]", "medium.drag_coefficient=0", "insert.one.velocity=[2, 0, 0]", "observe.signal=true", "observe.track_interval=0.01",
                                          "instrument.x.lag=0.05", "instrument.vx.saturation=1.5", "instrument.clock_shift=0.1", "instrument.y.offset=-3", "instrument.position.gain=7"});
  const Table table = table_of(run_of(case_of(values)).tables(), "signal");
  CHECK(table.columns.size() == 10);  // no wall: no force
  const std::vector<double>& t = column(table, "t").values;
  REQUIRE(t.size() >= 100);
  for (std::size_t k = 0; k < t.size(); ++k) {
    // A channel's own settings stand for those of all three.
    const double since = t[k] - 0.1;
    if (since >= 0) CHECK(column(table, "x").values[k] == Approx(2 * (since - 0.05 * (1 - std::exp(-t[k] / 0.05)))).margin(1e-9));
    CHECK(column(table, "y").values[k] == -3);
    CHECK(column(table, "vx").values[k] == 1.5);
    CHECK(column(table, "z").values[k] == 0);
  }
}

TEST_CASE("force and displacement in signal.csv are the wall's force and the overlap of a contact", "[diagnose][experiment][signal]") {
  const std::string impact = R"(
duration = 2e-3
gravity = [0, 0, 0]
[material.steel]
density = 7800
young = "20 GPa"
[pair.default]
law = "linear"
normal_stiffness = 1e6
restitution = 1
[species.ball]
material = "steel"
diameter = "20 mm"
[wall.plate]
type = "plane"
material = "steel"
axis = [0, 1, 0]
[insert.one]
species = "ball"
positions = [[0, "10.1 mm", 0]]
velocity = [0, -1, 0]
[observe]
signal = true
track_interval = 1e-5
)";
  const Case c = case_of(values_of(impact, {"instrument.force.gain=2"}));
  const Table table = table_of(run_of(c).tables(), "signal");
  const std::vector<double>&t = column(table, "t").values, &force = column(table, "force").values, &displacement = column(table, "displacement").values;
  // δ = v/ω sin ω(t − t₀) while it touches. Tolerance: that of the scheme at its automatic step.
  const double mass = 7800 * M_PI / 6 * 8e-6, omega = std::sqrt(1e6 / mass), touch = 1e-4, peak = 2e6 / omega;
  CHECK(displacement[0] == Approx(-1e-4));
  double highest = 0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double phase = omega * (t[k] - touch);
    if (phase < 0) {
      CHECK(force[k] == Approx(0).margin(0.02 * peak));
      CHECK(displacement[k] == Approx(t[k] - touch).margin(1e-9));
    } else if (phase < M_PI) {
      CHECK(displacement[k] == Approx(std::sin(phase) / omega).margin(0.005 / omega));
      CHECK(force[k] == Approx(peak * std::sin(phase)).margin(0.03 * peak));
      highest = std::max(highest, force[k]);
    }
  }
  CHECK(highest == Approx(peak).epsilon(0.01));
}

TEST_CASE("a run that goes on from its checkpoint shows the same signal", "[diagnose][experiment][signal][checkpoint]") {
  const Values values = values_of(thrown, {"observe.signal=true", "instrument.velocity.lag=0.02"});
  const Case c = case_of(values);
  const Table whole = table_of(run_of(c).tables(), "signal");
  // The observers' state in the midst, as checkpoints keep it.
  Built built = build_case(c);
  Simulation& s = built.simulation;
  Observers first(built.observe), second(built.observe);
  s.start(first.needs_collisions());
  first.see(s);
  while (s.clock.time() < 0.4004) s.step(), first.see(s);
  const std::string bytes = ArchiveWriter::written_by([&](ArchiveWriter& a) { a(first); });
  ArchiveReader reader(bytes);
  reader(second);
  CHECK(reader.at_end());
  while (s.clock.time() < 1) s.step(), second.see(s);
  const Table resumed = table_of(second.tables(), "signal");
  REQUIRE(resumed.columns.size() == 12);
  for (std::size_t k = 0; k < whole.columns.size(); ++k) CHECK(resumed.columns[k].values == whole.columns[k].values);
}

TEST_CASE("noise that follows itself and has tails is recovered, with gaps too", "[diagnose][noise]") {
  // e_i = φ e_{i−1} + σ √(1 − φ²) u_i, u Student's t with ν degrees of freedom; a fifth of the samples is then lost.
  constexpr double phi = 0.7, sigma = 2e-3, tail = 4, spacing = 0.01;
  std::mt19937_64 random(5);
  std::student_t_distribution<double> student(tail);
  Recording recording;
  std::size_t samples = 0;
  for (int r = 0; r < 6; ++r) {
    RecordedRun run;
    run.label = std::to_string(r), run.where = "here";
    run.series = {Series{Channel::z, {}, {}, {}, {}, {}}};
    double e = sigma * student(random);
    for (int k = 0; k < 250; ++k) {
      const double t = spacing * k;
      if (k > 0) e = phi * e + sigma * std::sqrt(1 - phi * phi) * student(random);
      if (random() % 5 == 0) continue;
      run.series[0].t.push_back(t), run.series[0].value.push_back(10 + 3 * t - 0.5 * g * t * t + e);
      ++samples;
    }
    recording.runs.push_back(run);
  }
  const Experiment experiment(values_of(alone, {"medium.drag_coefficient=0"}), recording);
  ThreadTeam team(1);
  const Comparison comparison(experiment, team);
  const Fit fit = comparison.fit({}, {}, {0, 1, 2, 3, 4, 5}, nullptr, FitOptions{});
  REQUIRE(fit.sound);
  const ChannelNoise& found = fit.noise[static_cast<std::size_t>(Channel::z)];
  const auto n = static_cast<double>(samples);
  CAPTURE(found.correlation, found.tail, found.deviation, found.white, found.jitter);
  CHECK(found.spacing == Approx(spacing));
  CHECK(found.correlation == Approx(phi).margin(4 * std::sqrt((1 - phi * phi) / n)));
  CHECK(found.tail >= 3);
  CHECK(found.tail <= 6);
  // A wrong tail by one of those steps costs a few parts in a hundred of the scale.
  CHECK(found.deviation == Approx(sigma).epsilon(4 * std::sqrt(1 / n) + 0.06));
}

TEST_CASE("whitened noise is what the noise was made of", "[diagnose][noise]") {
  const double phi = 0.8, sigma = 0.3, spacing = 0.02;
  Series series{Channel::z, {}, {}, {}, {}};
  Eigen::VectorXd made(50), e(50), by_sample(50);
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  double t = 0;
  for (int k = 0; k < 50; ++k) {
    const double gap = k % 7 == 0 ? 5 * spacing : spacing;
    t += gap;
    series.t.push_back(t), series.value.push_back(0);
    made[k] = normal(random);
    const double carried = k > 0 ? std::pow(phi, gap / spacing) : 0;
    e[k] = (k > 0 ? carried * e[k - 1] : 0) + sigma * std::sqrt(1 - carried * carried) * made[k];
    by_sample[k] = (k > 0 ? phi * by_sample[k - 1] : 0) + sigma * (k > 0 ? std::sqrt(1 - phi * phi) : 1) * made[k];
  }
  ChannelNoise noise;
  noise.deviation = sigma, noise.correlation = phi, noise.spacing = spacing;
  whiten(whitening_of(series, noise), e);
  CHECK((e - made).cwiseAbs().maxCoeff() < 1e-10);
  noise.by_sample = true;
  whiten(whitening_of(series, noise), by_sample);
  CHECK((by_sample - made).cwiseAbs().maxCoeff() < 1e-10);
}
