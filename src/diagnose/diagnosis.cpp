#include "src/diagnose/diagnosis.hpp"
#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "src/diagnose/location.hpp"

namespace quern {
namespace {

using Eigen::VectorXd;

constexpr double family_level = 0.01;       // of the test whether anything is left
constexpr double second_look = 0.05;        // what is left of the winner asks whether a second effect acts
constexpr double left_level = 0.001;        // what is left of it refutes it
constexpr double least_visible = 3.4;       // standard deviations: 80 % power of a test at 1 %
constexpr double alike = 0.95;              // coherence beyond which two effects look alike
constexpr double alike_odds = 3.0;          // ln of odds within which a rival is not ruled out
// Before any data: that nothing is missing, that one known effect is, that something unknown is, that two are.
constexpr double prior_none = 0.45, prior_one = 0.40, prior_unknown = 0.12, prior_two = 0.03;

struct Split {
  std::vector<std::size_t> fit, select, sealed;
  std::vector<std::size_t> train() const {
    std::vector<std::size_t> all = fit;
    all.insert(all.end(), select.begin(), select.end());
    std::sort(all.begin(), all.end());
    return all;
  }
};

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

class Investigation {
 public:
  Investigation(const Experiment& experiment, ThreadTeam& team, const DiagnoseOptions& options)
      : experiment_(experiment), comparison_(experiment_, team), options_(options) {}

  Diagnosis run() {
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
      for (int turn = 0; turn < most_turns && look_for_numerics() > 0.3; ++turn) calibrate();
      if (d_.numerical_error < 0.5 || refinement == most_refinements || !affordable()) break;
      experiment_.steps.time_step *= 0.5;
      experiment_.steps.longest_flight_step *= 0.5;
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

 private:
  FitOptions options_of() const {
    FitOptions options;
    options.common = free_.size();
    return options;
  }

  // With the noise of the start.
  FitOptions noise_given() const {
    FitOptions options = options_of();
    options.noise_rounds = 0;
    return options;
  }

  // Step 3: the noise about a fit, whatever of the catalogue the fit may lack.
  Noise noise_about(const Fit& fit, const std::vector<Direction>& directions) const {
    std::vector<std::vector<VectorXd>> columns;
    for (const Direction& direction : directions) {
      const auto& column = direction.columns[0];
      if (is_finite(column)) columns.push_back(column);
    }
    return comparison_.settled_noise(fit, columns);
  }

  static double change_between(const Noise& a, const Noise& b) {
    double change = 0;
    for (std::size_t c = 0; c < channel_count; ++c)
      change = std::max({change, std::abs(std::log(a[c].deviation / b[c].deviation)), std::abs(std::atanh(a[c].correlation) - std::atanh(b[c].correlation)), std::abs(1 / a[c].tail - 1 / b[c].tail), a[c].jitter == b[c].jitter ? 0.0 : 1.0});
    return change;
  }

  void note(const std::string& what, const Fit& fit) {
    d_.ledger.push_back({what, fmt::format("{:.3f}", fit.log_likelihood), fmt::format("{}", fit.iterations)});
  }

  // Step 4: the baseline as the case has it, and with what may be calibrated.
  void calibrate() {
    FitOptions options = options_of();
    const bool again = d_.baseline.sound;  // with another step
    options.by_horizon = !again && experiment_.has_wall() && experiment_.recording().kind != RecordingKind::contact;
    const Fit before = d_.baseline;
    d_.baseline = comparison_.fit(free_, {}, train_, again ? &before : nullptr, options);
    note("calibrated", d_.baseline);
    if (!d_.baseline.sound) start_elsewhere();
    if (!d_.baseline.sound) throw RunError("the case cannot be simulated for these recordings: every start of the calibration failed. `quern run` of the case tells why.");
    d_.best = d_.baseline;
  }

  // Other starts of the calibration, where it may have stopped in a valley of its own. Whether one was better.
  bool start_elsewhere() {
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

  bool enough_data() {
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

  // Step 2: what finite steps err by at the baseline, of first and second order in them, is told from a half and a quarter of the step and taken off all
  // predictions; what the second order was is taken for what is left (Richardson 1911).
  // Returns by how much that moved the predictions, in standard deviations of all samples together.
  double look_for_numerics() {
    Experiment halved = experiment_, quartered = experiment_;
    halved.steps.time_step *= 0.5, halved.steps.longest_flight_step *= 0.5;
    quartered.steps.time_step *= 0.25, quartered.steps.longest_flight_step *= 0.25;
    std::vector<VectorXd> errors(experiment_.runs()), left(experiment_.runs());
    const Alteration altered = comparison_.alteration_of(d_.baseline);
    comparison_.team().run(static_cast<int>(experiment_.runs()), [&](int place) {
      const auto run = static_cast<std::size_t>(place);
      const std::vector<double>& unknowns = d_.baseline.unknowns[run];
      const VectorXd whole = stacked(experiment_.predict(run, altered, unknowns)), half = stacked(halved.predict(run, altered, unknowns)),
                     quarter = stacked(quartered.predict(run, altered, unknowns));
      errors[run] = (8 * quarter - 6 * half + whole) / 3 - whole;
      left[run] = whole + errors[run] - (2 * quarter - half);
      if (!left[run].allFinite()) errors[run].setZero(), left[run].setZero();
    });
    double sum = 0, moved = 0;
    numerical_.clear();
    Noise normal = d_.baseline.noise;
    for (ChannelNoise& one : normal) one.tail = 1e9;
    const auto size_of = [&](std::size_t run, const VectorXd& change) { return comparison_.whitened(run, without_slopes(change), normal).rest.squaredNorm(); };
    const std::vector<VectorXd>& before = comparison_.corrections();
    for (const std::size_t run : d_.baseline.runs) {
      sum += size_of(run, left[run]);
      moved += size_of(run, before.empty() ? errors[run] : VectorXd(errors[run] - before[run]));
      numerical_.push_back(left[run]);
    }
    d_.numerical_error = std::sqrt(sum);
    comparison_.correct(std::move(errors));
    return std::sqrt(moved);
  }

  static VectorXd stacked(const Experiment::Prediction& prediction) {
    std::vector<double> all;
    for (const std::vector<double>& series : prediction) all.insert(all.end(), series.begin(), series.end());
    return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  // Whether runs of half the step would still take but milliseconds.
  bool affordable() const {
    constexpr double most_steps = 2e5;  // of all runs of a set
    double steps = 0;
    for (const std::size_t run : train_) {
      std::size_t taken = experiment_.path(run, comparison_.alteration_of(d_.baseline), d_.baseline.unknowns[run]).size();
      steps += 2 * static_cast<double>(taken);
    }
    return steps < most_steps;
  }

  std::vector<VectorXd> response_of(const Fit& fit, const Candidate& c, const std::vector<double>& values) const {
    Alteration more{{}, c.settings};
    for (std::size_t k = 0; k < c.parameters.size(); ++k) more.changes.push_back({&c.parameters[k], values[k]});
    return comparison_.response(fit, more);
  }

  // The directions of all candidates about a fit.
  std::vector<Direction> directions_about(const Fit& fit, const std::vector<std::string>& without) const {
    std::vector<Direction> all;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const Candidate& c = candidates_[k];
      if (std::find(without.begin(), without.end(), c.effect) != without.end()) continue;
      for (std::size_t probe = 0; probe < c.probes.size(); ++probe) {
        Direction direction{c.effect + (c.form.empty() ? "" : " (" + c.form + ")"), {response_of(fit, c, c.probes[probe])}, false, static_cast<int>(k), probe};
        const Parameter& p = c.parameters[0];
        direction.one_sided = p.value <= p.lower || p.value >= p.upper;
        all.push_back(std::move(direction));
      }
    }
    return all;
  }

  // Directions of no cause in particular: smooth curves over each run, common to all of them, by channel; and the strength of an effect that differs
  // between runs, which no cause should (step 10).
  std::vector<Direction> plain_directions(const Fit& fit) const {
    std::vector<Direction> all;
    const Recording& recording = experiment_.recording();
    std::set<Channel> channels;
    for (const std::size_t r : fit.runs)
      for (const Series& series : recording.runs[r].series) channels.insert(series.channel);
    for (const Channel channel : channels) {
      Direction curve{fmt::format("a smooth course of {}", name_of(channel)), {}, false, -1, 0};
      constexpr int waves = 5;
      for (int wave = 0; wave < waves; ++wave) {
        std::vector<VectorXd> column;
        for (std::size_t place = 0; place < fit.runs.size(); ++place) {
          const RecordedRun& run = recording.runs[fit.runs[place]];
          VectorXd values = VectorXd::Zero(fit.linear[place].rest.size());
          Eigen::Index row = 0;
          for (const Series& series : run.series) {
            const double length = std::max(series.t.back() - series.t.front(), 1e-300);
            for (const double t : series.t) {
              if (series.channel == channel) values[row] = std::cos(M_PI * wave * (t - series.t.front()) / length);
              ++row;
            }
          }
          column.push_back(values);
        }
        curve.columns.push_back(std::move(column));
      }
      all.push_back(curve);
      // And by each run alone.
      for (std::size_t only = 0; only < fit.runs.size() && fit.runs.size() > 1; ++only) {
        Direction own = curve;
        own.name += " in one run";
        for (auto& column : own.columns)
          for (std::size_t place = 0; place < fit.runs.size(); ++place)
            if (place != only) column[place].setZero();
        all.push_back(std::move(own));
      }
    }
    return all;
  }

  // Whether the strength that a fit found is one and the same in all runs, and along each condition.
  std::vector<Direction> scaling_directions(const Fit& fit, const Candidate& c) const {
    std::vector<Direction> all;
    if (fit.runs.size() < 2) return all;
    std::size_t at = fit.moved.size();
    for (std::size_t k = 0; k < fit.moved.size(); ++k)
      if (fit.moved[k].name == c.parameters[0].name) at = k;
    if (at == fit.moved.size()) return all;
    const auto column = static_cast<Eigen::Index>(at);
    const auto weighted = [&](auto&& weight) {
      std::vector<VectorXd> runs;
      for (std::size_t place = 0; place < fit.runs.size(); ++place) runs.push_back(weight(fit.runs[place]) * fit.linear[place].shared.col(column));
      return runs;
    };
    Direction apart{"its strength by run", {}, false, -1, 0};
    for (const std::size_t run : fit.runs)
      if (run != fit.runs.front()) apart.columns.push_back(weighted([&](std::size_t r) { return r == run ? 1.0 : 0.0; }));
    all.push_back(std::move(apart));
    const Recording& recording = experiment_.recording();
    std::set<std::string> names;
    for (const std::size_t r : fit.runs)
      for (const auto& [name, value] : recording.runs[r].conditions) names.insert(name);
    for (const std::string& name : names) {
      bool whole = true;
      std::set<double> values;
      for (const std::size_t r : fit.runs) {
        const auto found = recording.runs[r].conditions.find(name);
        whole &= found != recording.runs[r].conditions.end() && found->second > 0;
        if (whole) values.insert(found->second);
      }
      if (!whole || values.size() < 2) continue;
      all.push_back({"its strength by " + name, {weighted([&](std::size_t r) { return std::log(recording.runs[r].conditions.at(name)); })}, false, -1, 0});
    }
    return all;
  }

  static bool is_finite(const std::vector<VectorXd>& runs) {
    return std::all_of(runs.begin(), runs.end(), [](const VectorXd& run) { return run.allFinite(); });
  }

  // A first probe that is too strong to be simulated is brought nearer to nothing.
  void soften(Direction& direction) {
    if (direction.probe != 0) return;
    Candidate& c = candidates_[static_cast<std::size_t>(direction.candidate)];
    for (int tries = 0; tries < 3 && !is_finite(direction.columns[0]); ++tries) {
      const double nothing = c.parameters[0].value;
      c.probes[0][0] = nothing + 0.1 * (c.probes[0][0] - nothing);
      direction.columns[0] = response_of(d_.baseline, c, c.probes[0]);
    }
  }

  // Steps 5 and 7: is anything left, and how each candidate would show.
  void judge_baseline() {
    sizes_ = sizes_of(comparison_, d_.baseline);
    candidates_ = candidates_for(comparison_, d_.baseline, sizes_);
    reynolds_ = 2 * sizes_.radius * sizes_.speed * experiment_.base().number("medium.density") / experiment_.base().number("medium.viscosity");
    directions_ = directions_about(d_.baseline, {});
    for (Direction& direction : directions_) soften(direction);
    d_.baseline.noise = noise_about(d_.baseline, directions_);
    d_.baseline = d_.best = comparison_.fit(free_, {}, train_, &d_.baseline, noise_given());
    note("calibrated, under that noise", d_.baseline);
    Residuals residuals(comparison_, d_.baseline, numerical_);
    scores_.clear(), d_.detectable.clear();
    for (const Direction& direction : directions_) scores_.push_back(residuals.score(direction));
    for (const Direction& direction : plain_directions(d_.baseline)) residuals.score(direction);
    d_.adequacy_p = residuals.family_p(options_.seed);
    independent_ = 0;
    for (const std::size_t r : train_)
      for (const Series& series : experiment_.recording().runs[r].series) {
        const double phi = d_.baseline.noise[static_cast<std::size_t>(series.channel)].correlation;
        independent_ += static_cast<double>(series.value.size()) * (1 - phi) / (1 + phi);
      }
    independent_ = std::max(independent_, 4.0);
    std::map<std::string, Detectable> least;
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const Candidate& c = candidates_[static_cast<std::size_t>(directions_[k].candidate)];
      if (c.rival || directions_[k].probe != 0 || !(scores_[k].visible > 0)) continue;
      const double change = std::abs(c.probes[0][0] - c.parameters[0].value) * least_visible / scores_[k].visible;
      const Detectable found{c.effect, c.parameters[0].name, find_key(c.parameters[0].path)->unit, change};
      if (const auto [old, fresh] = least.emplace(c.effect, found); !fresh && change < old->second.strength && found.key == old->second.key) old->second = found;
    }
    for (const auto& [name, one] : least) d_.detectable.push_back(one);
  }

  void nothing_more() {
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
    d_.confidence = std::clamp(0.85 + 0.13 * d_.adequacy_p, 0.5, 0.98);
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

  double effects_count() const {
    std::set<std::string> names;
    for (const Candidate& c : candidates_) names.insert(c.effect);
    return std::max<double>(1, static_cast<double>(names.size()));
  }

  double log_prior(const Candidate& c) const {
    if (c.free_form) return std::log(prior_unknown / std::max<double>(1, static_cast<double>(free_forms_)));
    double forms = 0;
    for (const Candidate& other : candidates_) forms += other.effect == c.effect ? 1 : 0;
    // Stokes' law far beyond its Reynolds numbers would be a wonder.
    const double wonder = c.effect != "viscous_drag" ? 0 : reynolds_ > 5e4 ? 15 : reynolds_ > 1e3 ? 2 : 0;
    return std::log(prior_one / effects_count() / std::max(1.0, forms)) - wonder;
  }

  // Fits a candidate with every free parameter, from each start given; the best is kept.
  std::optional<Tried> attempt(const Candidate& c, const std::vector<std::vector<double>>& starts, const Fit& about, double promised = 0) {
    std::vector<Parameter> moved = free_;
    std::vector<Setting> settings = about.settings;
    for (std::size_t k = free_.size(); k < about.moved.size(); ++k) moved.push_back(about.moved[k]);
    moved.insert(moved.end(), c.parameters.begin(), c.parameters.end());
    settings.insert(settings.end(), c.settings.begin(), c.settings.end());
    std::optional<Tried> best;
    for (const std::vector<double>& at : starts) {
      Fit start = about;
      for (std::size_t k = 0; k < at.size(); ++k) {
        start.moved.push_back(c.parameters[k]);
        start.shared.push_back(at[k]);
      }
      FitOptions options = noise_given();
      // Many numbers at once need true slopes on their way.
      options.thorough = c.parameters.size() > 2 && !c.free_form;
      options.most_iterations = options.thorough ? 30 : 15;
      Fit fit = comparison_.fit(moved, settings, train_, &start, options);
      const std::string words = c.effect + (c.form.empty() ? "" : " (" + c.form + ")");
      note(fmt::format("{}, from {:.4g}", words, at[0]), fit);
      if (!fit.sound) continue;
      const double gain = gain_of(fit);
      if (best && gain < best->gain + 0.01) continue;
      Tried tried;
      tried.candidate = c;
      tried.effects = {c.effect};
      tried.gain = gain;
      tried.fit = std::move(fit);
      rate(tried);
      best = std::move(tried);
      // The score promised half its statistic; a fit that keeps the promise needs no other start.
      if (starts.size() > 1 && gain > 0.4 * promised) break;
    }
    return best;
  }

  double gain_of(const Fit& fit) const { return comparison_.log_likelihood(fit, d_.baseline.noise) - comparison_.log_likelihood(d_.baseline, d_.baseline.noise); }

  void rate(Tried& tried) const {
    tried.gain = gain_of(tried.fit);
    tried.bic = -2 * tried.gain + static_cast<double>(tried.fit.moved.size() - free_.size()) * std::log(independent_);
  }

  // The noise once more, about the best explanation; what was tried is weighed anew under it.
  void settle_noise() {
    const Tried* best = nullptr;
    for (const Tried& t : d_.ranking)
      if (best == nullptr || t.bic < best->bic) best = &t;
    if (best == nullptr) return;
    const Noise noise = noise_about(best->fit, directions_about(best->fit, best->effects));
    if (change_between(noise, d_.baseline.noise) < 0.03) return;
    d_.baseline.noise = noise;
    d_.baseline = comparison_.fit(free_, {}, train_, &d_.baseline, noise_given());
    note("calibrated, under the noise about the best explanation", d_.baseline);
    constexpr std::size_t most = 8;
    for (std::size_t k = 0; k < d_.ranking.size(); ++k) {
      Tried& t = d_.ranking[k];
      t.fit.noise = noise;
      if (k < most) {
        t.fit = comparison_.fit(t.fit.moved, t.fit.settings, train_, &t.fit, noise_given());
        note("again: " + std::string(fmt::format("{}", fmt::join(t.effects, " + "))), t.fit);
      }
      rate(t);
    }
    weigh();
  }

  // Where a fit of a candidate begins: at the strength that its response asks for, and at its probes.
  std::vector<std::vector<double>> starts_of(const Candidate& c, const std::vector<Direction>& directions, const std::vector<Score>& scores) const {
    std::vector<std::vector<double>> starts;
    std::size_t best = directions.size();
    for (std::size_t k = 0; k < directions.size(); ++k) {
      if (&candidates_[static_cast<std::size_t>(directions[k].candidate)] != &c) continue;
      if (best == directions.size() || scores[k].statistic > scores[best].statistic) best = k;
    }
    if (best < directions.size()) {
      std::vector<double> at = c.probes[directions[best].probe];
      const Parameter& p = c.parameters[0];
      const double asked = p.value + scores[best].amplitude * (at[0] - p.value);
      starts.push_back(at);
      at[0] = std::clamp(asked, p.lower + 1e-6 * p.scale, p.upper - 1e-6 * p.scale);
      starts.insert(starts.begin(), at);
    }
    return starts;
  }

  // Step 8: the candidates that the residual asks for, and the free forms.
  void try_candidates() {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      double strongest = 0;
      for (std::size_t k = 0; k < directions_.size(); ++k)
        if (directions_[k].candidate == static_cast<int>(c)) strongest = std::max(strongest, scores_[k].statistic);
      order.push_back({-strongest, c});
    }
    std::sort(order.begin(), order.end());
    constexpr std::size_t most = 12;
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Candidate& c = candidates_[order[k].second];
      if (k >= most && !c.rival) continue;
      if (-order[k].first < 2 && k > 3) continue;
      if (auto tried = attempt(c, starts_of(c, directions_, scores_), d_.baseline, -order[k].first)) d_.ranking.push_back(std::move(*tried));
    }
    const std::vector<Candidate> curves = free_forms_for(comparison_, d_.baseline, sizes_);
    free_forms_ = curves.size();
    // Free forms that the residual asks for at least a little.
    Residuals residuals(comparison_, d_.baseline, numerical_);
    std::vector<std::pair<double, std::size_t>> asked;
    for (std::size_t k = 0; k < curves.size(); ++k) {
      Direction direction{curves[k].form, {}, false, -1, 0};
      for (std::size_t knot = 0; knot < curves[k].parameters.size(); ++knot) {
        std::vector<double> values(curves[k].parameters.size(), 0.0);
        values[knot] = curves[k].parameters[knot].scale;
        direction.columns.push_back(response_of(d_.baseline, curves[k], values));
      }
      const Score score = residuals.score(direction);
      asked.push_back({score.p, k});
    }
    std::sort(asked.begin(), asked.end());
    for (std::size_t k = 0; k < std::min<std::size_t>(4, asked.size()); ++k)
      if (auto tried = attempt(curves[asked[k].second], curves[asked[k].second].probes, d_.baseline)) d_.ranking.push_back(std::move(*tried));
    weigh();
    refine();
    settle_noise();
  }

  // The best fits once more, with slopes that are true where they are.
  void refine() {
    constexpr std::size_t most = 5;
    for (std::size_t k = 0; k < std::min(most, d_.ranking.size()); ++k) {
      Tried& t = d_.ranking[k];
      t.fit = comparison_.fit(t.fit.moved, t.fit.settings, train_, &t.fit, noise_given());
      note("again: " + std::string(fmt::format("{}", fmt::join(t.effects, " + "))), t.fit);
      rate(t);
    }
    weigh();
  }

  // Instruments are calibrated: a scale is wrong by some hundredths, not by half.
  static double strangeness(const Fit& fit) {
    constexpr double usual = 0.05;
    double sum = 0;
    for (std::size_t k = 0; k < fit.moved.size(); ++k)
      if (fit.moved[k].path.front() == "instrument" && fit.moved[k].path.back() == "gain") {
        const double off = std::log(fit.shared[k]) / usual;
        sum += 0.5 * off * off;
      }
    return sum;
  }

  void weigh() {
    double most = std::log(prior_none);
    const auto weight = [&](const Tried& t) { return -0.5 * t.bic - strangeness(t.fit) + (t.effects.size() > 1 ? std::log(prior_two / effects_count()) : log_prior(t.candidate)); };
    for (const Tried& t : d_.ranking) most = std::max(most, weight(t));
    double sum = prior_none * std::exp(-most);
    for (Tried& t : d_.ranking) t.probability = std::exp(weight(t) - most), sum += t.probability;
    for (Tried& t : d_.ranking) t.probability /= sum;
    std::stable_sort(d_.ranking.begin(), d_.ranking.end(), [](const Tried& a, const Tried& b) { return a.probability > b.probability; });
  }

  // Step 9: what a model that was fitted on the fit part tells of the select part, against the baseline treated likewise.
  void hold_out(Tried& tried) {
    if (split_.select.empty() || split_.fit.empty() || !tried.held_out_runs.empty()) return;
    const FitOptions options = noise_given();
    if (!select_baseline_) {
      const Fit part = comparison_.fit(free_, {}, split_.fit, &d_.baseline, options);
      select_baseline_ = comparison_.carry_over(part, split_.select);
    }
    const Fit part = comparison_.fit(tried.fit.moved, tried.fit.settings, split_.fit, &tried.fit, options);
    const Fit there = comparison_.carry_over(part, split_.select);
    note("held out: " + tried.effects.front(), there);
    tried.held_out = comparison_.misfit(there, there.noise);
    tried.held_out_runs = comparison_.log_likelihoods(there, there.noise);
    tried.held_out_gain = std::accumulate(tried.held_out_runs.begin(), tried.held_out_runs.end(), 0.0) - comparison_.log_likelihood(*select_baseline_, there.noise);
  }

  // Whether one explanation tells the select part better than another, by more than the chance of its runs.
  bool tells_more(Tried& more, Tried& less) {
    hold_out(more), hold_out(less);
    const std::size_t runs = more.held_out_runs.size();
    if (runs == 0 || less.held_out_runs.size() != runs) return more.bic < less.bic - 6;
    double sum = 0, square = 0;
    for (std::size_t r = 0; r < runs; ++r) {
      const double one = more.held_out_runs[r] - less.held_out_runs[r];
      sum += one, square += one * one;
    }
    const double n = static_cast<double>(runs), spread = runs > 2 ? std::sqrt(std::max(0.0, square - sum * sum / n) * n / (n - 1)) : 0;
    return sum > std::max(2.0, 2 * spread);
  }

  Tried* best_single() {
    for (Tried& t : d_.ranking)
      if (!t.candidate.free_form && !t.candidate.rival && t.effects.size() == 1) return &t;
    return nullptr;
  }

  double remaining_of(const Tried& tried) {
    Residuals residuals(comparison_, tried.fit, numerical_);
    for (const Direction& direction : directions_about(tried.fit, tried.effects)) residuals.score(direction);
    for (const Direction& direction : plain_directions(tried.fit)) residuals.score(direction);
    for (const Direction& direction : scaling_directions(tried.fit, tried.candidate)) residuals.score(direction);
    return residuals.family_p(options_.seed + 1);
  }

  // Runs of one body: alike in mass, diameter and density.
  std::map<std::array<double, 3>, std::vector<std::size_t>> bodies() const {
    std::map<std::array<double, 3>, std::vector<std::size_t>> found;
    const Recording& recording = experiment_.recording();
    for (std::size_t r = 0; r < recording.runs.size(); ++r) {
      std::array<double, 3> body{};
      std::size_t at = 0;
      for (const char* name : {"mass", "diameter", "density"}) {
        const auto condition = recording.runs[r].conditions.find(name);
        body[at++] = condition == recording.runs[r].conditions.end() ? 0 : condition->second;
      }
      found[body].push_back(r);
    }
    return found;
  }

  // What the labels of some runs begin with alike.
  std::string common_label(const std::vector<std::size_t>& runs) const {
    std::string label = experiment_.recording().runs[runs.front()].label;
    for (const std::size_t r : runs) {
      const std::string& other = experiment_.recording().runs[r].label;
      std::size_t same = 0;
      while (same < std::min(label.size(), other.size()) && label[same] == other[same]) ++same;
      label.resize(same);
    }
    while (!label.empty() && std::string("/ -_.#").find(label.back()) != std::string::npos) label.pop_back();
    return label.empty() ? experiment_.recording().runs[runs.front()].label : label;
  }

  // A coefficient that belongs to the body (its skin, its shape) may differ from body to body, where each was recorded at least twice.
  void try_by_body() {
    const auto groups = bodies();
    if (groups.size() < 2 || std::any_of(groups.begin(), groups.end(), [](const auto& group) { return group.second.size() < 2; })) return;
    std::vector<Tried> of_bodies;
    for (const Tried& t : d_.ranking) {
      const std::set<std::string> names = {"air_drag", "viscous_drag", "magnus", "rolling_resistance", "sliding_friction"};
      const bool seen = std::any_of(of_bodies.begin(), of_bodies.end(), [&](const Tried& other) { return other.effects == t.effects; });
      if (t.effects.size() == 1 && names.count(t.effects.front()) > 0 && t.candidate.parameters.size() == 1 && !seen) of_bodies.push_back(t);
    }
    for (const Tried& t : of_bodies) try_by_body(t, groups);
    weigh();
  }

  void try_by_body(const Tried& winner, const std::map<std::array<double, 3>, std::vector<std::size_t>>& groups) {
    Candidate c = winner.candidate;
    const Parameter whole = c.parameters[0];
    c.parameters.clear();
    c.form = c.form.empty() ? "each body its own" : c.form + ", each body its own";
    std::vector<double> start;
    for (const auto& [body, runs] : groups) {
      Parameter own = whole;
      own.name = whole.name + "@" + common_label(runs);
      own.runs = runs;
      c.parameters.push_back(own);
      start.push_back(winner.fit.shared.back());
    }
    auto tried = attempt(c, {start}, d_.baseline);
    if (!tried) return;
    for (const Candidate& distortion : candidates_) {
      if (distortion.effect != "camera_distortion") continue;
      if (auto both = attempt(distortion, distortion.probes, tried->fit)) add_beside(*tried, distortion, std::move(*both));
    }
    d_.ranking.push_back(std::move(*tried));
  }

  // A scale that bends is not physics, but it may stand beside it.
  void add_beside(const Tried& first, const Candidate& distortion, Tried both) {
    both.effects = first.effects;
    both.candidate = first.candidate;
    both.candidate.settings.insert(both.candidate.settings.end(), distortion.settings.begin(), distortion.settings.end());
    both.candidate.form += (first.candidate.form.empty() ? "" : ", ") + ("beside " + distortion.form);
    d_.ranking.push_back(std::move(both));
  }

  // Two effects: the best ones, each with what its residual asks for.
  void try_pairs() {
    std::vector<Tried> firsts;
    std::set<std::string> seen;
    for (const Tried& t : d_.ranking) {
      if (t.candidate.free_form || t.candidate.rival || t.effects.size() > 1 || !seen.insert(t.candidate.effect).second) continue;
      if (firsts.size() < 3) firsts.push_back(t);
    }
    for (const Tried& first : firsts) {
      Residuals residuals(comparison_, first.fit, numerical_);
      std::vector<Direction> directions = directions_about(first.fit, first.effects);
      std::vector<Score> scores;
      for (const Direction& direction : directions) scores.push_back(residuals.score(direction));
      std::vector<std::pair<double, std::size_t>> order;
      for (std::size_t c = 0; c < candidates_.size(); ++c) {
        double strongest = 0;
        for (std::size_t k = 0; k < directions.size(); ++k)
          if (directions[k].candidate == static_cast<int>(c)) strongest = std::max(strongest, scores[k].statistic);
        if (strongest > 8 && (!candidates_[c].rival || candidates_[c].effect == "camera_distortion")) order.push_back({-strongest, c});
      }
      std::sort(order.begin(), order.end());
      for (std::size_t k = 0; k < std::min<std::size_t>(3, order.size()); ++k) {
        const Candidate& second = candidates_[order[k].second];
        std::vector<std::vector<double>> starts = starts_of(second, directions, scores);
        if (starts.size() > 1) starts.resize(1);
        auto tried = attempt(second, starts, first.fit);
        if (!tried) continue;
        tried->effects = {first.candidate.effect, second.effect};
        if (second.rival) {
          if (first.candidate.form.find("beside") == std::string::npos) add_beside(first, second, std::move(*tried));
          continue;
        }
        tried->candidate.settings.insert(tried->candidate.settings.begin(), first.candidate.settings.begin(), first.candidate.settings.end());
        d_.ranking.push_back(std::move(*tried));
      }
    }
    weigh();
  }

  const Tried* best_named() const {
    for (const Tried& t : d_.ranking)
      if (!t.candidate.free_form && !t.candidate.rival) return &t;
    return nullptr;
  }
  const Tried* best_free() const {
    for (const Tried& t : d_.ranking)
      if (t.candidate.free_form) return &t;
    return nullptr;
  }

  // Of all learnt curves, or of all names.
  double probability_of(bool free_form) const {
    double sum = 0;
    for (const Tried& t : d_.ranking)
      if (!t.candidate.rival && t.candidate.free_form == free_form) sum += t.probability;
    return sum;
  }

  // The noise is known better about the best explanation than about the baseline: is the baseline still refuted?
  bool still_refuted() {
    Residuals residuals(comparison_, d_.baseline, numerical_);
    for (const Direction& direction : directions_) residuals.score(direction);
    for (const Direction& direction : plain_directions(d_.baseline)) residuals.score(direction);
    d_.adequacy_p = residuals.family_p(options_.seed);
    return d_.adequacy_p <= family_level;
  }

  void choose() {
    if (!still_refuted()) {
      d_.best = d_.baseline;
      return nothing_more();
    }
    if (d_.ranking.empty()) return unexplained(nullptr);
    const Tried* named = best_named();
    if (named == nullptr) return unexplained(best_free());
    d_.remaining_p = remaining_of(*named);
    const auto better_free = [&] { return probability_of(true) > probability_of(false); };
    if (d_.remaining_p < second_look) {
      try_by_body();
      settle_noise();
      named = best_named();
      d_.remaining_p = remaining_of(*named);
    }
    if (d_.remaining_p < second_look || better_free()) {
      try_pairs();
      named = best_named();
      d_.remaining_p = remaining_of(*named);
    }
    for (std::size_t k = 0; k < std::min<std::size_t>(4, d_.ranking.size()); ++k) hold_out(d_.ranking[k]);
    named = best_named();
    if (named->bic > -2) return unexplained(best_free());
    // What one effect leaves may be too little to show in runs that were not fitted: then it is told, and nothing is built on it.
    bool little_left = false;
    if (Tried* single = best_single(); single != nullptr && (named->effects.size() > 1 || d_.remaining_p < left_level || better_free())) {
      constexpr double most_of_it = 0.9;
      double greatest = 0;
      for (const Tried& t : d_.ranking) greatest = std::max(greatest, t.gain);
      bool more = single->gain < most_of_it * greatest;
      for (std::size_t k = 0; k < std::min<std::size_t>(3, d_.ranking.size()) && !more; ++k) more = &d_.ranking[k] != single && tells_more(d_.ranking[k], *single);
      if (!more) little_left = true, named = single;
    }
    if (!little_left && (d_.remaining_p < left_level || better_free())) return unexplained(best_free());
    d_.verdict = Verdict::omitted_physics;
    d_.effects = named->effects;
    d_.form = named->candidate.form;
    d_.best = named->fit;
    tell_bodies(*named);
    look_alikes(*named);
    // A name that leaves something is a little less certain.
    if (little_left) {
      double alone = 0, all = 0;
      for (const Tried& t : d_.ranking)
        if (!t.candidate.free_form && t.effects.size() == 1) (t.effects == d_.effects ? alone : all) += t.probability;
      d_.confidence = alone > 0 ? 0.85 * alone / (alone + all) : 0.5;
      d_.remarks.push_back("Something small is left that the noise does not explain; it does not help to tell runs that were not fitted.");
    } else if (d_.remaining_p < second_look) {
      d_.confidence *= d_.remaining_p < family_level ? 0.6 : 0.85;
    }
  }

  // Which bodies need the effect, where each has its own strength.
  void tell_bodies(const Tried& winner) {
    std::vector<std::string> with, without;
    for (std::size_t k = 0; k < winner.fit.moved.size(); ++k) {
      const Parameter& p = winner.fit.moved[k];
      if (p.runs.empty()) continue;
      const bool needed = std::abs(winner.fit.shared[k] - p.value) > 2.6 * winner.fit.deviation(k) && winner.fit.shared[k] > p.lower;
      (needed ? with : without).push_back(p.name.substr(p.name.find('@') + 1));
    }
    if (!with.empty()) d_.remarks.push_back(fmt::format("Needed by {}{}.", fmt::join(with, ", "), without.empty() ? "" : fmt::format("; not seen in {}", fmt::join(without, ", "))));
  }

  void look_alikes(const Tried& winner) {
    double own = 0;
    std::map<std::string, double> others;
    for (const Tried& t : d_.ranking) {
      if (t.candidate.free_form || t.candidate.rival) continue;
      if (t.effects == winner.effects) own += t.probability;
      else if (t.effects.size() == 1 && winner.effects.size() == 1) others[t.candidate.effect] += t.probability;
    }
    d_.confidence = own;
    std::vector<std::pair<double, std::string>> order;
    for (const auto& [name, probability] : others)
      if (probability > own * std::exp(-alike_odds)) order.push_back({-probability, name});
    std::sort(order.begin(), order.end());
    for (const auto& [probability, name] : order) d_.indistinguishable.push_back(name);
    for (const Tried& t : d_.ranking)
      if (t.candidate.rival && t.probability > winner.probability * std::exp(-alike_odds))
        d_.remarks.push_back(fmt::format("{} ({}) would do as well; the case calls it known.", t.candidate.effect, t.candidate.form));
    const auto tried_as = [&](const std::string& effect) {
      return std::find_if(d_.ranking.begin(), d_.ranking.end(), [&](const Tried& t) { return t.effects == std::vector<std::string>{effect}; });
    };
    if (const auto linear = tried_as("viscous_drag"); d_.effects == std::vector<std::string>{"air_drag"} && linear != d_.ranking.end() && reynolds_ > 1e3)
      d_.remarks.push_back(fmt::format("A drag that is linear in the speed fits {} (ln of likelihood {:+.1f}); at Reynolds numbers of {:.0e} that would speak of the recording's scale, not of Stokes.",
                                       linear->gain > winner.gain ? "better" : "worse", linear->gain - winner.gain, reynolds_));
    if (winner.candidate.form.find("beside") != std::string::npos)
      d_.remarks.push_back("The scale of the recording bends as well, in the same way for all runs; for one body alone that and the effect could not be told apart.");
    if (const auto gravity = tried_as("gravity"); gravity != d_.ranking.end())
      d_.remarks.push_back(fmt::format("Setting gravity free instead would leave {:.1f} of ln likelihood unexplained (g = {:.3g} m/s²).", winner.gain - gravity->gain, gravity->fit.shared.back()));
    if (!d_.indistinguishable.empty())
      if (const EffectEntry* entry = find_effect(d_.effects.front()))
        d_.advice = fmt::format("To part {} from {}: {}.", d_.effects.front(), fmt::format("{}", fmt::join(d_.indistinguishable, ", ")), entry->experiment);
  }

  void unexplained(const Tried* free) {
    d_.verdict = Verdict::unexplained;
    d_.effects.clear();
    if (free != nullptr) d_.best = free->fit, d_.form = free->candidate.form;
    double named = 0;
    for (const Tried& t : d_.ranking)
      if (!t.candidate.free_form && !t.candidate.rival) named = std::max(named, t.probability);
    d_.confidence = std::clamp(1 - named * std::min(1.0, d_.remaining_p / left_level), 0.5, 0.97);
    if (const Tried* best = best_named())
      d_.remarks.push_back(fmt::format("The nearest known effect, {}, leaves structure that noise would leave with a probability of {:.2g}.", fmt::join(best->effects, " with "), d_.remaining_p));
  }

  // Steps 6, 12 and 13.
  Diagnosis finish() {
    d_.steps = experiment_.steps;
    const Fit& b = d_.baseline;
    const Noise& noise = d_.best.noise;
    d_.train = {comparison_.misfit(b, noise), comparison_.misfit(d_.best, noise)};
    if (!split_.sealed.empty()) {
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
      e.value = d_.best.shared[k], e.deviation = d_.best.deviation(k);
      e.of_effect = k >= free_.size();
      if (!e.of_effect) e.nominal = p.value;
      d_.parameters.push_back(e);
    }
    std::stable_sort(d_.parameters.begin(), d_.parameters.end(), [](const Estimate& x, const Estimate& y) { return x.of_effect > y.of_effect; });
    if (d_.verdict == Verdict::omitted_physics)
      if (const EffectEntry* entry = find_effect(d_.effects.front())) d_.signature = entry->signature;
    if (d_.verdict == Verdict::unexplained && !d_.form.empty()) d_.signature = "a force " + d_.form;
    return std::move(d_);
  }

  Experiment experiment_;   // its own, whose steps it refines
  Comparison comparison_;
  DiagnoseOptions options_;
  Split split_;
  std::vector<std::size_t> train_;
  std::vector<Parameter> free_;
  Sizes sizes_;
  std::vector<VectorXd> numerical_;  // how half the step moves the predictions
  std::vector<Candidate> candidates_;
  std::vector<Direction> directions_;
  std::vector<Score> scores_;
  std::size_t free_forms_ = 1;
  double independent_ = 4, reynolds_ = 0;
  std::optional<Fit> select_baseline_;
  Diagnosis d_;
};

}  // namespace

const char* name_of(Verdict verdict) {
  constexpr const char* names[] = {"omitted_physics", "nothing_missing", "parameters_only", "unexplained", "insufficient_data"};
  return names[static_cast<int>(verdict)];
}

Diagnosis diagnose(const Experiment& experiment, ThreadTeam& team, const DiagnoseOptions& options) { return Investigation(experiment, team, options).run(); }

}  // namespace quern
