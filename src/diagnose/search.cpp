#include "src/diagnose/investigation.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <set>

namespace quern {

using Eigen::VectorXd;

std::optional<Tried> Investigation::attempt(const Candidate& c, const std::vector<std::vector<double>>& starts, const Fit& about, double promised) {
  std::vector<Parameter> moved = free_;
  std::vector<Setting> settings = about.settings;
  for (std::size_t k = free_.size(); k < about.moved.size(); ++k) moved.push_back(about.moved[k]);
  moved.insert(moved.end(), c.parameters.begin(), c.parameters.end());
  settings.insert(settings.end(), c.settings.begin(), c.settings.end());
  std::optional<Tried> best;
  const double before = gain_of(about);
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
    if (starts.size() > 1 && gain - before > 0.4 * promised) break;
  }
  return best;
}

double Investigation::gain_of(const Fit& fit) const { return comparison_.log_likelihood(fit, d_.baseline.noise) - comparison_.log_likelihood(d_.baseline, d_.baseline.noise); }

void Investigation::rate(Tried& tried) const {
  tried.gain = gain_of(tried.fit);
  tried.bic = -2 * tried.gain + static_cast<double>(tried.fit.moved.size() - free_.size()) * std::log(independent_);
}

void Investigation::settle_noise() {
  const Tried* best = nullptr;
  for (const Tried& t : d_.ranking)
    if (best == nullptr || t.bic < best->bic) best = &t;
  if (best == nullptr) return;
  const Noise noise = noise_about(best->fit, directions_about(best->fit, best->effects));
  if (change_between(noise, d_.baseline.noise) < 0.03) return;
  d_.baseline.noise = noise;
  Fit about = best->fit;
  about.noise = noise;
  comparison_.learn_trembling(about);
  d_.baseline = comparison_.fit(free_, {}, train_, &d_.baseline, noise_given());
  fit_again("under the noise about the best explanation");
}

void Investigation::settle_softness(const Fit& best) {
  if (look_for_numerics(best) < 0.3) return;
  d_.baseline = comparison_.fit(free_, {}, train_, &d_.baseline, noise_given());
  fit_again("with contacts as they are about the best explanation");
}

void Investigation::fit_again(const std::string& why) {
  constexpr std::size_t most = 8;
  note("calibrated, " + why, d_.baseline);
  for (std::size_t k = 0; k < d_.ranking.size(); ++k) {
    Tried& t = d_.ranking[k];
    t.fit.noise = d_.baseline.noise;
    if (k < most) {
      t.fit = comparison_.fit(t.fit.moved, t.fit.settings, train_, &t.fit, noise_given());
      note("again: " + std::string(fmt::format("{}", fmt::join(t.effects, " + "))), t.fit);
    }
    rate(t);
  }
  weigh();
}

std::vector<std::vector<double>> Investigation::starts_of(const Candidate& c, const std::vector<Direction>& directions, const std::vector<Score>& scores) const {
  std::vector<std::vector<double>> starts;
  const std::size_t none = directions.size();
  // The probe that the residual asks for most, and the one that agrees best with the strength that it is asked for in: there the response is straight.
  std::size_t best = none, straight = none;
  const auto bend = [&](std::size_t k) { return scores[k].amplitude > 0 ? std::abs(std::log(scores[k].amplitude)) : 1e300; };
  for (std::size_t k = 0; k < none; ++k) {
    if (&candidates_[static_cast<std::size_t>(directions[k].candidate)] != &c) continue;
    if (best == none || scores[k].statistic > scores[best].statistic) best = k;
    if (straight == none || bend(k) < bend(straight)) straight = k;
  }
  if (best == none) return starts;
  const Parameter& p = c.parameters[0];
  const auto add = [&](std::size_t k, double part) {
    std::vector<double> at = c.probes[directions[k].probe];
    at[0] = std::clamp(p.value + part * (at[0] - p.value), p.lower + 1e-6 * p.scale, p.upper - 1e-6 * p.scale);
    starts.push_back(at);
  };
  constexpr double much = 1.4;  // a factor four
  const double amplitude = scores[best].amplitude;
  add(best, amplitude);
  if (bend(best) > much && straight != best && bend(straight) < bend(best)) add(straight, scores[straight].amplitude);
  if (bend(best) > much && amplitude > 0) add(best, std::sqrt(amplitude));
  starts.push_back(c.probes[directions[best].probe]);
  return starts;
}

void Investigation::try_candidates() {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    double strongest = 0;
    for (std::size_t k = 0; k < directions_.size(); ++k)
      if (directions_[k].candidate == static_cast<int>(c)) strongest = std::max(strongest, scores_[k].statistic);
    order.push_back({-strongest, c});
  }
  std::sort(order.begin(), order.end());
  constexpr std::size_t most = 16;
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

void Investigation::refine() {
  constexpr std::size_t most = 5;
  for (std::size_t k = 0; k < std::min(most, d_.ranking.size()); ++k) {
    Tried& t = d_.ranking[k];
    t.fit = comparison_.fit(t.fit.moved, t.fit.settings, train_, &t.fit, noise_given());
    note("again: " + std::string(fmt::format("{}", fmt::join(t.effects, " + "))), t.fit);
    rate(t);
  }
  weigh();
}

std::map<std::array<double, 3>, std::vector<std::size_t>> Investigation::bodies() const {
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

std::string Investigation::common_label(const std::vector<std::size_t>& runs) const {
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

void Investigation::try_by_body() {
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

void Investigation::try_by_body(const Tried& winner, const std::map<std::array<double, 3>, std::vector<std::size_t>>& groups) {
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

void Investigation::add_beside(const Tried& first, const Candidate& distortion, Tried both) {
  both.effects = first.effects;
  both.candidate = first.candidate;
  both.candidate.settings.insert(both.candidate.settings.end(), distortion.settings.begin(), distortion.settings.end());
  both.candidate.form += (first.candidate.form.empty() ? "" : ", ") + ("beside " + distortion.form);
  d_.ranking.push_back(std::move(both));
}

void Investigation::try_pairs() {
  std::vector<Tried> firsts;
  std::set<std::string> seen;
  for (const Tried& t : d_.ranking) {
    if (t.candidate.free_form || t.candidate.rival || t.effects.size() > 1 || !seen.insert(t.candidate.effect).second) continue;
    if (firsts.size() < 3) firsts.push_back(t);
  }
  const auto bends = [](const Tried& t) { return t.candidate.form.find("beside") != std::string::npos; };
  std::vector<const Tried*> straight;  // those beside which no bent scale was tried
  for (const Tried& first : firsts) {
    if (!bends(first)) straight.push_back(&first);
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
      auto tried = attempt(second, starts_of(second, directions, scores), first.fit, -order[k].first);
      if (!tried) continue;
      tried->effects = {first.candidate.effect, second.effect};
      if (second.rival) {
        if (!bends(first)) add_beside(first, second, std::move(*tried)), straight.pop_back();
        continue;
      }
      tried->candidate.settings.insert(tried->candidate.settings.begin(), first.candidate.settings.begin(), first.candidate.settings.end());
      d_.ranking.push_back(std::move(*tried));
    }
  }
  // What stands beside one of them may stand beside all, or they could not be compared.
  const auto distortion = std::find_if(candidates_.begin(), candidates_.end(), [](const Candidate& c) { return c.effect == "camera_distortion"; });
  if (distortion != candidates_.end() && std::any_of(d_.ranking.begin(), d_.ranking.end(), bends))
    for (const Tried* first : straight)
      if (auto both = attempt(*distortion, distortion->probes, first->fit)) add_beside(*first, *distortion, std::move(*both));
  weigh();
}

}  // namespace quern
