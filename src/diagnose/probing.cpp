#include "src/diagnose/investigation.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>

namespace quern {

using Eigen::VectorXd;

Noise Investigation::noise_about(const Fit& fit, const std::vector<Direction>& directions) const {
  std::vector<std::vector<VectorXd>> columns;
  for (const Direction& direction : directions) {
    const auto& column = direction.columns[0];
    if (is_finite(column)) columns.push_back(column);
  }
  return comparison_.settled_noise(fit, columns);
}

double Investigation::change_between(const Noise& a, const Noise& b) {
  double change = 0;
  for (std::size_t c = 0; c < channel_count; ++c)
    change = std::max({change, std::abs(std::log(a[c].deviation / b[c].deviation)), std::abs(std::atanh(a[c].correlation) - std::atanh(b[c].correlation)), std::abs(1 / a[c].tail - 1 / b[c].tail), a[c].jitter == b[c].jitter ? 0.0 : 1.0});
  return change;
}

std::vector<VectorXd> Investigation::response_of(const Fit& fit, const Candidate& c, const std::vector<double>& values) const {
  Alteration more{{}, c.settings};
  for (std::size_t k = 0; k < c.parameters.size(); ++k) more.changes.push_back({&c.parameters[k], values[k]});
  return comparison_.response(fit, more);
}

std::vector<Direction> Investigation::directions_about(const Fit& fit, const std::vector<std::string>& without) const {
  std::vector<Direction> all;
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const Candidate& c = candidates_[k];
    if (std::find(without.begin(), without.end(), c.effect) != without.end()) continue;
    for (std::size_t probe = 0; probe < c.probes.size(); ++probe) {
      if (!telling_.empty() && telling_[k].count(probe) == 0) continue;
      Direction direction{c.effect + (c.form.empty() ? "" : " (" + c.form + ")"), {response_of(fit, c, c.probes[probe])}, false, static_cast<int>(k), probe};
      const Parameter& p = c.parameters[0];
      direction.one_sided = p.value <= p.lower || p.value >= p.upper;
      all.push_back(std::move(direction));
    }
  }
  return all;
}

std::vector<Direction> Investigation::plain_directions(const Fit& fit) const {
  std::vector<Direction> all;
  const Recording& recording = experiment_.recording();
  std::set<Channel> channels;
  for (const std::size_t r : fit.runs)
    for (const Series& series : recording.runs[r].series) channels.insert(series.channel);
  for (const Channel channel : channels) {
    add_waves(channel, fit, all);
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

void Investigation::add_waves(Channel channel, const Fit& fit, std::vector<Direction>& all) const {
  const Recording& recording = experiment_.recording();
  std::vector<double> lengths, samples;
  for (const std::size_t r : fit.runs)
    for (const Series& series : recording.runs[r].series)
      if (series.channel == channel) lengths.push_back(series.t.back() - series.t.front()), samples.push_back(static_cast<double>(series.t.size()));
  if (channel == Channel::impact || lengths.empty()) return;
  const double length = middle_of(std::move(lengths));
  // Slower ones are in the smooth courses; faster ones have less than five samples each.
  constexpr int slowest = 3, most = 24;
  const int fastest = std::min(most, static_cast<int>(middle_of(std::move(samples)) / 5));
  for (int periods = slowest; periods <= fastest && length > 0; ++periods) {
    Direction wave{fmt::format("{} periods of {}", periods, name_of(channel)), {{}, {}}, false, -1, 0};
    for (std::size_t place = 0; place < fit.runs.size(); ++place) {
      VectorXd even = VectorXd::Zero(fit.linear[place].rest.size()), odd = even;
      Eigen::Index row = 0;
      for (const Series& series : recording.runs[fit.runs[place]].series)
        for (const double t : series.t) {
          const double phase = 2 * M_PI * periods * t / length;
          if (series.channel == channel) even[row] = std::cos(phase), odd[row] = std::sin(phase);
          ++row;
        }
      wave.columns[0].push_back(even), wave.columns[1].push_back(odd);
    }
    all.push_back(std::move(wave));
  }
}

std::vector<Direction> Investigation::scaling_of_free(const Fit& fit) const {
  std::vector<Direction> all;
  for (const Parameter& p : free_) {
    Candidate own;
    own.parameters = {p};
    for (Direction& direction : scaling_directions(fit, own)) all.push_back(std::move(direction));
  }
  return all;
}

std::vector<Direction> Investigation::scaling_directions(const Fit& fit, const Candidate& c) const {
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
  if (fit.runs.size() > 2) all.push_back({"its strength in the order of the runs", {weighted([](std::size_t r) { return static_cast<double>(r); })}, false, -1, 0});
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

bool Investigation::is_finite(const std::vector<VectorXd>& runs) {
  return std::all_of(runs.begin(), runs.end(), [](const VectorXd& run) { return run.allFinite(); });
}

void Investigation::soften(Direction& direction) {
  if (direction.probe != 0) return;
  Candidate& c = candidates_[static_cast<std::size_t>(direction.candidate)];
  for (int tries = 0; tries < 3 && !is_finite(direction.columns[0]); ++tries) {
    const double nothing = c.parameters[0].value;
    c.probes[0][0] = nothing + 0.1 * (c.probes[0][0] - nothing);
    direction.columns[0] = response_of(d_.baseline, c, c.probes[0]);
  }
}

void Investigation::probe_nearer() {
  constexpr double by_far = 40, nearer = 12;  // standard deviations
  constexpr int most_turns = 3;
  Residuals residuals(comparison_, d_.baseline, numerical_);
  std::vector<std::pair<double, std::size_t>> weakest(candidates_.size(), {1e300, 0});
  const auto look = [&](std::size_t k) {
    auto& one = weakest[static_cast<std::size_t>(directions_[k].candidate)];
    if (!is_finite(directions_[k].columns[0])) return;
    if (const double visible = residuals.score(directions_[k]).visible; visible > 0 && visible < one.first) one = {visible, k};
  };
  for (std::size_t k = 0; k < directions_.size(); ++k) look(k);
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    Candidate& candidate = candidates_[c];
    const double nothing = candidate.parameters[0].value;
    for (int turn = 0; turn < most_turns && weakest[c].first > by_far && weakest[c].first < 1e299; ++turn) {
      Direction direction = directions_[weakest[c].second];
      std::vector<double> probe = candidate.probes[direction.probe];
      probe[0] = nothing + nearer / weakest[c].first * (probe[0] - nothing);
      direction.probe = candidate.probes.size();
      direction.columns[0] = response_of(d_.baseline, candidate, probe);
      candidate.probes.push_back(std::move(probe));
      directions_.push_back(std::move(direction));
      look(directions_.size() - 1);
    }
  }
}

void Investigation::choose_telling() {
  telling_.resize(candidates_.size());
  constexpr double unseen = 0.3, well_seen = 12;  // standard deviations
  std::vector<double> best(candidates_.size(), -1), nearest(candidates_.size(), 1e300);
  std::vector<std::size_t> strongest(candidates_.size()), straightest(candidates_.size());
  for (std::size_t k = 0; k < directions_.size(); ++k) {
    const auto c = static_cast<std::size_t>(directions_[k].candidate);
    if (!(scores_[k].visible > unseen)) continue;
    if (scores_[k].statistic > best[c]) best[c] = scores_[k].statistic, strongest[c] = directions_[k].probe;
    if (const double off = std::abs(std::log(scores_[k].visible / well_seen)); off < nearest[c]) nearest[c] = off, straightest[c] = directions_[k].probe;
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c)
    if (best[c] >= 0) telling_[c] = {strongest[c], straightest[c]};
}

void Investigation::judge_baseline() {
  sizes_ = sizes_of(comparison_, d_.baseline);
  candidates_ = candidates_for(comparison_, d_.baseline, sizes_);
  reynolds_ = 2 * sizes_.radius * sizes_.speed * experiment_.base().number("medium.density") / experiment_.base().number("medium.viscosity");
  telling_.clear();
  directions_ = directions_about(d_.baseline, {});
  for (Direction& direction : directions_) soften(direction);
  probe_nearer();
  d_.baseline.noise = noise_about(d_.baseline, directions_);
  comparison_.learn_trembling(d_.baseline);
  d_.baseline = d_.best = comparison_.fit(free_, {}, train_, &d_.baseline, noise_given());
  note("calibrated, under that noise", d_.baseline);
  Residuals residuals(comparison_, d_.baseline, numerical_);
  d_.detectable.clear();
  scores_ = score_all(residuals, directions_, d_.baseline);
  d_.adequacy_p = residuals.family_p(options_.seed);
  choose_telling();
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

std::vector<Score> Investigation::score_all(Residuals& residuals, const std::vector<Direction>& directions, const Fit& fit, double* gain) const {
  std::vector<Score> scores;
  for (const Direction& direction : directions) scores.push_back(residuals.score(direction));
  double most = 0;
  for (const Score& score : scores) most = std::max(most, score.statistic - 1);
  std::vector<Direction> plain = plain_directions(fit);
  for (Direction& direction : scaling_of_free(fit)) plain.push_back(std::move(direction));
  for (const Direction& direction : plain) {
    const Score score = residuals.score(direction);
    most = std::max(most, score.statistic - score.degrees);
  }
  if (gain != nullptr) *gain = 0.5 * most;
  return scores;
}

Investigation::Remainder Investigation::remainder_of(const Tried& tried) const {
  Residuals residuals(comparison_, tried.fit, numerical_);
  Remainder left;
  score_all(residuals, directions_about(tried.fit, tried.effects), tried.fit, &left.gain);
  for (const Direction& direction : scaling_directions(tried.fit, tried.candidate)) residuals.score(direction);
  left.p = residuals.family_p(options_.seed + 1);
  return left;
}

bool Investigation::still_refuted() {
  Residuals residuals(comparison_, d_.baseline, numerical_);
  score_all(residuals, directions_, d_.baseline);
  d_.adequacy_p = residuals.family_p(options_.seed);
  return d_.adequacy_p <= family_level;
}

}  // namespace quern
