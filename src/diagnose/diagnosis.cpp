#include "src/diagnose/investigation.hpp"
#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "src/diagnose/location.hpp"

namespace quern {
namespace {

using Eigen::VectorXd;

// By recording, never inside one: those that the recording holds out are sealed; otherwise a quarter of the runs, spread over them by chance.
Split split_runs(const Recording& recording, double sealed_part, std::uint64_t seed) {
  Split split;
  std::vector<std::size_t> open;
  const bool told = std::any_of(recording.runs.begin(), recording.runs.end(), [](const RecordedRun& run) { return run.held_out.has_value(); });
  for (std::size_t r = 0; r < recording.runs.size(); ++r) (told && recording.runs[r].held_out.value_or(false) ? split.sealed : open).push_back(r);
  RandomStream random(seed, 11);
  std::vector<std::size_t> order = open;
  for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[static_cast<std::size_t>(random.uniform() * static_cast<double>(k))]);
  std::size_t next = 0;
  if (!told && order.size() >= 4) {
    const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(sealed_part * static_cast<double>(order.size()))));
    for (; next < count; ++next) split.sealed.push_back(order[next]);
  }
  const std::size_t left = order.size() - next;
  const std::size_t selecting = left >= 2 ? std::max<std::size_t>(1, left / 3) : 0;
  for (std::size_t k = 0; k < selecting; ++k) split.select.push_back(order[next++]);
  for (; next < order.size(); ++next) split.fit.push_back(order[next]);
  for (std::vector<std::size_t>* part : {&split.fit, &split.select, &split.sealed}) std::sort(part->begin(), part->end());
  return split;
}

std::vector<std::string> labels_of(const Recording& recording, const std::vector<std::size_t>& runs) {
  std::vector<std::string> labels;
  for (const std::size_t r : runs) labels.push_back(recording.runs[r].label);
  return labels;
}

}  // namespace

Diagnosis Investigation::run() {
  const Recording& recording = experiment_.recording();
  split_ = split_runs(recording, experiment_.base().number("diagnose.held_out"), options_.seed);
  d_.fit_runs = labels_of(recording, split_.fit), d_.select_runs = labels_of(recording, split_.select), d_.sealed_runs = labels_of(recording, split_.sealed);
  train_ = split_.train();
  if (experiment_.base().has("diagnose.free"))
    for (const std::string& key : experiment_.base().texts("diagnose.free")) free_.push_back(experiment_.parameter(key));
  // Step 2 goes with step 4: the step is refined until it matters less than the noise, as far as time allows.
  constexpr int most_refinements = 2;
  for (int refinement = 0;; ++refinement) {
    calibrate();
    if (!enough_data()) return finish();
    // What steps err by depends on where the calibration leads, and the other way round.
    constexpr int most_turns = 4;
    for (int turn = 0; turn < most_turns && look_for_numerics(d_.baseline) > 0.3; ++turn) calibrate();
    if (d_.numerical_error < 0.5 || refinement == most_refinements || !affordable()) break;
    experiment_.steps = experiment_.steps.finer(2);
    comparison_.correct({});
  }
  if (d_.numerical_error > 3)
    d_.remarks.push_back(fmt::format("A finer time step would move the simulation by {:.2g} standard deviations of the noise over all samples; what looks like that was not counted.", d_.numerical_error));
  judge_baseline();
  if (d_.adequacy_p <= family_level && start_elsewhere()) judge_baseline();
  if (d_.adequacy_p > family_level) {
    nothing_more();
  } else {
    try_candidates();
    choose();
  }
  return finish();
}

FitOptions Investigation::options_of() const {
  FitOptions options;
  options.common = free_.size();
  return options;
}

FitOptions Investigation::noise_given() const {
  FitOptions options = options_of();
  options.noise_rounds = 0;
  return options;
}

void Investigation::note(const std::string& what, const Fit& fit) {
  d_.ledger.push_back({what, fmt::format("{:.3f}", fit.log_likelihood), fmt::format("{}", fit.iterations)});
}

void Investigation::calibrate() {
  FitOptions options = options_of();
  const bool again = d_.baseline.sound;  // with another step
  options.by_horizon = !again && experiment_.has_wall() && experiment_.recording().kind != RecordingKind::contact;
  const Fit before = d_.baseline;
  if (again) comparison_.learn_trembling(before);
  d_.baseline = comparison_.fit(free_, {}, train_, again ? &before : nullptr, options);
  note("calibrated", d_.baseline);
  if (!d_.baseline.sound) start_elsewhere();
  const auto trembles = [&] { return std::any_of(d_.baseline.noise.begin(), d_.baseline.noise.end(), [](const ChannelNoise& one) { return one.jitter > 0; }); };
  for (int turn = 0; !again && turn < 2 && d_.baseline.sound && (turn == 0 || trembles()); ++turn) {
    comparison_.learn_trembling(d_.baseline);
    d_.baseline = comparison_.fit(free_, {}, train_, &d_.baseline, options_of());
    note("calibrated, the rates of the signals being known", d_.baseline);
  }
  if (!d_.baseline.sound) throw RunError("the case cannot be simulated for these recordings: every start of the calibration failed. `quern run` of the case tells why.");
  d_.best = d_.baseline;
}

bool Investigation::start_elsewhere() {
  Fit best = d_.baseline;
  for (std::size_t k = 0; k < free_.size() && free_.size() <= 4; ++k) {
    const Parameter& p = free_[k];
    if (!std::isfinite(p.lower) || !std::isfinite(p.upper)) continue;
    for (const double part : {0.25, 0.75}) {
      Fit start = d_.baseline;
      start.moved = free_;
      start.shared.clear();
      for (const Parameter& one : free_) start.shared.push_back(one.value);
      start.shared[k] = p.lower > 0 ? p.lower * std::pow(p.upper / p.lower, part) : p.lower + part * (p.upper - p.lower);
      for (std::size_t r = 0; r < experiment_.runs(); ++r)
        for (std::size_t u = 0; u < start.unknowns[r].size(); ++u) start.unknowns[r][u] = experiment_.unknowns(r)[u].guess;
      FitOptions options = options_of();
      options.by_horizon = experiment_.has_wall() && experiment_.recording().kind != RecordingKind::contact;
      const Fit other = comparison_.fit(free_, {}, train_, &start, options);
      note(fmt::format("calibrated, from {} = {:.4g}", p.name, start.shared[k]), other);
      if (other.sound && other.log_likelihood > best.log_likelihood + 0.1) best = other;
    }
  }
  const bool better = best.log_likelihood > d_.baseline.log_likelihood + 0.1;
  d_.baseline = d_.best = best;
  return better;
}

bool Investigation::enough_data() {
  double estimated = static_cast<double>(free_.size());
  for (const std::size_t r : train_) estimated += static_cast<double>(experiment_.unknowns(r).size());
  const double left = static_cast<double>(d_.baseline.samples) - estimated;
  if (left >= 6) return true;
  d_.verdict = Verdict::insufficient_data;
  d_.confidence = 0.9;
  d_.remarks.push_back(fmt::format("{} samples of {} runs stand against {:.0f} numbers that must be estimated; at least six more are needed to tell noise from physics.", d_.baseline.samples,
                                   train_.size(), estimated));
  return false;
}

double Investigation::look_for_numerics(const Fit& about) {
  const Steps stiff = experiment_.steps.stiff();
  Experiment plain = experiment_, halved = experiment_, quartered = experiment_;
  plain.steps = stiff, halved.steps = stiff.finer(2), quartered.steps = stiff.finer(4);
  std::vector<VectorXd> errors(experiment_.runs()), left(experiment_.runs());
  const Alteration altered = comparison_.alteration_of(about);
  comparison_.team().run(static_cast<int>(experiment_.runs()), [&](int place) {
    const auto run = static_cast<std::size_t>(place);
    const std::vector<double>& unknowns = about.unknowns[run];
    const VectorXd used = stacked(experiment_.predict(run, altered, unknowns));
    const VectorXd whole = experiment_.steps[run].softness > 1 ? stacked(plain.predict(run, altered, unknowns)) : used, half = stacked(halved.predict(run, altered, unknowns)),
                   quarter = stacked(quartered.predict(run, altered, unknowns));
    const VectorXd exact = (8 * quarter - 6 * half + whole) / 3;
    errors[run] = exact - used;
    left[run] = exact - (2 * quarter - half);
    if (!left[run].allFinite()) errors[run].setZero(), left[run].setZero();
  });
  double sum = 0, moved = 0;
  numerical_.clear();
  Noise normal = about.noise;
  for (ChannelNoise& one : normal) one.tail = 1e9;
  const auto size_of = [&](std::size_t run, const VectorXd& change) { return comparison_.whitened(run, without_slopes(change), normal).rest.squaredNorm(); };
  const std::vector<VectorXd>& before = comparison_.corrections();
  for (const std::size_t run : about.runs) {
    sum += size_of(run, left[run]);
    moved += size_of(run, before.empty() ? errors[run] : VectorXd(errors[run] - before[run]));
    numerical_.push_back(left[run]);
  }
  d_.numerical_error = std::sqrt(sum);
  comparison_.correct(std::move(errors));
  return std::sqrt(moved);
}

VectorXd Investigation::stacked(const Experiment::Prediction& prediction) {
  std::vector<double> all;
  for (const std::vector<double>& series : prediction) all.insert(all.end(), series.begin(), series.end());
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

bool Investigation::affordable() const {
  constexpr double most_steps = 2e5;  // of all runs of a set
  double steps = 0;
  for (const std::size_t run : train_) {
    std::size_t taken = experiment_.path(run, comparison_.alteration_of(d_.baseline), d_.baseline.unknowns[run]).size();
    steps += 2 * static_cast<double>(taken);
  }
  return steps < most_steps;
}

void Investigation::nothing_more() {
  // Calibration may have moved what the case says.
  const Fit& b = d_.baseline;
  double distance = 0;
  if (!free_.empty()) {
    const auto n = static_cast<Eigen::Index>(free_.size());
    VectorXd moved(n);
    for (Eigen::Index k = 0; k < n; ++k) moved[k] = b.shared[static_cast<std::size_t>(k)] - free_[static_cast<std::size_t>(k)].value;
    distance = moved.dot(b.covariance.ldlt().solve(moved));
  }
  const double p = chi_squared_above(distance, static_cast<int>(free_.size()));
  d_.verdict = !free_.empty() && p < family_level ? Verdict::parameters_only : Verdict::nothing_missing;
  // As development trials have it, weak effects among them: what nearly showed is there more often.
  constexpr double nearly = 0.25;
  const double far = std::min(1.0, d_.adequacy_p / nearly);
  d_.confidence = d_.verdict == Verdict::nothing_missing ? 0.6 + 0.33 * far : 0.5 + 0.4 * far;
  // Whether even a strong effect would have shown.
  bool blind = !d_.detectable.empty() || candidates_.empty();
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    const Candidate& c = candidates_[static_cast<std::size_t>(directions_[k].candidate)];
    if (!c.rival && directions_[k].probe + 1 == c.probes.size() && scores_[k].visible > 3 * least_visible) blind = false;
  }
  if (blind) {
    d_.verdict = Verdict::insufficient_data;
    d_.remarks.push_back("Even strong effects would not show in these recordings; the list of the least strengths tells how strong they would have to be.");
  }
}

Diagnosis Investigation::finish() {
  if (d_.verdict == Verdict::omitted_physics || d_.verdict == Verdict::unexplained) d_.confidence = as_experienced(d_.confidence, d_.effects.size() > 1);
  d_.steps = experiment_.steps.stiff();
  const Fit& b = d_.baseline;
  const Noise& noise = d_.best.noise;
  d_.train = {comparison_.misfit(b, noise), comparison_.misfit(d_.best, noise)};
  if (!split_.sealed.empty()) {
    comparison_.learn_trembling(comparison_.carry_over(b, split_.sealed));
    d_.sealed_baseline = comparison_.carry_over(b, split_.sealed);
    d_.sealed_best = d_.verdict == Verdict::omitted_physics || d_.verdict == Verdict::unexplained ? comparison_.carry_over(d_.best, split_.sealed) : d_.sealed_baseline;
    if (d_.sealed_baseline.sound && d_.sealed_best.sound) {
      d_.sealed = Before{comparison_.misfit(d_.sealed_baseline, noise), comparison_.misfit(d_.sealed_best, noise)};
      const double excess = d_.sealed->before * d_.sealed->before - 1, left = std::max(0.0, d_.sealed->after * d_.sealed->after - 1);
      d_.excess_removed = excess > 0 ? 1 - left / excess : 0;
    }
  }
  if (d_.verdict == Verdict::omitted_physics || d_.verdict == Verdict::unexplained) {
    d_.where = locate(comparison_, b, d_.best);
    d_.where.p_value = d_.adequacy_p;
  }
  for (std::size_t k = 0; k < d_.best.moved.size(); ++k) {
    const Parameter& p = d_.best.moved[k];
    Estimate e;
    e.key = p.name;
    const Key* key = find_key(p.path);
    e.unit = key != nullptr ? key->unit : "1";
    if (d_.learns_torque() && p.path.front() == "force") e.unit = "N m";
    e.value = d_.best.shared[k], e.deviation = d_.best.deviation(k);
    e.of_effect = k >= free_.size();
    if (!e.of_effect) e.nominal = p.value;
    d_.parameters.push_back(e);
  }
  std::stable_sort(d_.parameters.begin(), d_.parameters.end(), [](const Estimate& x, const Estimate& y) { return x.of_effect > y.of_effect; });
  if (d_.verdict == Verdict::omitted_physics)
    if (const EffectEntry* entry = find_effect(d_.effects.front())) d_.signature = entry->signature;
  if (d_.verdict == Verdict::unexplained && !d_.form.empty()) d_.signature = (d_.learns_torque() ? "" : "a force ") + d_.form;
  return std::move(d_);
}

Diagnosis diagnose(const Experiment& experiment, ThreadTeam& team, const DiagnoseOptions& options) { return Investigation(experiment, team, options).run(); }

}  // namespace quern
