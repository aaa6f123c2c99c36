// A clock that trembles: each sample shows the body a little before or after its time, which shows as its speed, and where it bounces always upwards.
#include <catch2/catch.hpp>
#include <cmath>
#include <fmt/format.h>
#include "src/base/random.hpp"
#include "src/diagnose/diagnosis.hpp"
#include "tests/bounces.hpp"
#include "tests/folder.hpp"

using namespace quern;

namespace {

constexpr double g = 9.81, radius = 0.01, restitution = 0.8;

// A touch lasts 0.2 ms, in which the ball would fly half a millimetre.
const char* bouncing = R"(
duration = 1
gravity = [0, 0, -9.81]
[material.steel]
density = 7800
young = "50 GPa"
[pair.default]
restitution = 0.8
[species.ball]
material = "steel"
diameter = 0.02
[wall.plate]
type = "plane"
material = "steel"
[insert.one]
species = "ball"
positions = [[0, 0, 0.3]]
[diagnose]
initial_state = "case"
)";

double height(double drop, double t) { return radius + bounce_height(drop, restitution, t); }

}  // namespace

TEST_CASE("a trembling clock lifts a bounce by the mean speed about it, and shows a flight's speed", "[diagnose][trembling]") {
  constexpr double drop = 0.3, trembling = 2e-3;
  const double touch = std::sqrt(2 * drop / g), speed = g * touch;
  const double times[] = {0, 0.1, touch, touch + 0.05, touch + 0.15};
  std::string text = "run,t [s],z [m],drop_height [m]\n";
  for (const double t : times) text += fmt::format("0,{:.12g},{:.12g},{}\n", t, height(drop, t), drop);
  const Folder folder("trembling");
  const Recording recording = read_recordings({folder.write("r.csv", text)});
  const Experiment experiment(read_values(folder.write("case.toml", bouncing), {}), recording);
  ThreadTeam team(1);
  Comparison comparison(experiment, team);
  FitOptions given;
  given.noise_rounds = 0;
  Fit start;
  start.unknowns.resize(1);
  start.noise[static_cast<std::size_t>(Channel::z)].deviation = 1e-3;
  start.noise[static_cast<std::size_t>(Channel::z)].jitter = trembling / 1e-3;
  const Fit steady = comparison.fit({}, {}, {0}, &start, given);
  comparison.learn_trembling(steady);  // rates first
  comparison.learn_trembling(steady);
  const Fit shaken = comparison.fit({}, {}, {0}, &steady, given);
  const Eigen::VectorXd lifted = steady.linear[0].rest - shaken.linear[0].rest;
  const std::vector<double>& rates = comparison.recording().runs[0].series[0].rate;
  for (const int k : {1, 3, 4}) {
    INFO("t = " << times[k]);
    // A parabola seen half early, half late.
    CHECK(lifted[k] == Approx(-0.5 * g * trembling * trembling).margin(1e-6));
    const double slope = k == 1 ? -g * times[1] : restitution * speed - g * (times[k] - touch);
    CHECK(rates[static_cast<std::size_t>(k)] == Approx(std::hypot(slope, g * trembling / 2)).epsilon(0.01));
  }
  // Within what the touch itself takes.
  CHECK(lifted[2] == Approx(0.5 * (1 + restitution) * speed * trembling).epsilon(0.1));
  CHECK(rates[2] == Approx(speed * std::sqrt(0.5 * (1 + restitution * restitution))).epsilon(0.1));
}

TEST_CASE("a sample at the instant of first touch may show the dashpot's force or none yet", "[diagnose][trembling]") {
  // A linear contact, x = v/ω_d exp(−β ω t) sin ω_d t, F = k x + c dx/dt: at first touch F leaps by c v, twenty times the noise.
  constexpr double mass = 4.0e-3, stiffness = 1e5, kept = 0.6;
  const double log_kept = std::log(kept), beta = -log_kept / std::hypot(log_kept, M_PI), omega = std::sqrt(stiffness / mass), damped = omega * std::sqrt(1 - beta * beta);
  const std::string hitting = R"(
duration = 1e-3
time_step.value = 2e-6
gravity = [0, 0, 0]
[material.steel]
density = 7800
[pair.default]
law = "linear"
normal_stiffness = 1e5
restitution = 0.6
[species.ball]
material = "steel"
diameter = 0.01
[wall.plate]
type = "plane"
material = "steel"
[insert.one]
species = "ball"
positions = [[0, 0, 0.005]]
velocity = [0, 0, -1]
[diagnose]
initial_state = "case"
free = ["pair.default.restitution", "pair.default.normal_stiffness"]
)";
  for (const bool yet : {true, false}) {
    std::string text = "run,t [s],force [N],mass [kg],diameter [m],impact_speed [m/s]\n";
    RandomStream random(7);
    for (int run = 0; run < 6; ++run) {
      const double speed = 0.5 + 0.1 * run, damping = 2 * beta * mass * omega, noise = 0.05 * damping;
      for (int k = -5; k < 40; ++k) {
        const double t = 1e-5 * k, swing = speed / damped * std::exp(-beta * omega * t), x = swing * std::sin(damped * t), rate = swing * damped * std::cos(damped * t) - beta * omega * x;
        const double force = k > 0 || (k == 0 && yet) ? stiffness * x + damping * rate : 0;
        text += fmt::format("{},{:.9g},{:.9g},{},0.01,{}\n", run, t, force + noise * random.normal(), mass, speed);
      }
    }
    const Folder folder("trembling");
    const Recording recording = read_recordings({folder.write("r.csv", text)});
    const Experiment experiment(read_values(folder.write("case.toml", hitting), {}), recording);
    ThreadTeam team(1);
    const Diagnosis d = diagnose(experiment, team, {});
    INFO("shown at once: " << yet);
    CHECK(d.effects.empty());
    CHECK(d.adequacy_p > 0.05);
  }
}

TEST_CASE("nothing is missing where bounces are recorded by a clock that trembles", "[diagnose][trembling]") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::string text = "run,t [s],z [m],drop_height [m]\n";
    RandomStream random(seed);
    for (int run = 0; run < 6; ++run) {
      const double drop = 0.2 + 0.05 * run;
      for (int k = 0; k < 45; ++k) {
        const double t = 0.022 * k;
        text += fmt::format("{},{:.9g},{:.9g},{}\n", run, t, height(drop, std::max(0.0, t + 2.5e-3 * random.normal())) + 5e-4 * random.normal(), drop);
      }
    }
    const Folder folder("trembling");
    const Recording recording = read_recordings({folder.write("r.csv", text)});
    const Experiment experiment(read_values(folder.write("case.toml", bouncing), {}), recording);
    ThreadTeam team(1);
    const Diagnosis d = diagnose(experiment, team, {});
    INFO("seed " << seed << ", p = " << d.adequacy_p);
    CHECK(d.verdict == Verdict::nothing_missing);
  }
}
