#include "src/diagnose/machine/machine_diagnosis.hpp"
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include "src/base/error.hpp"
#include "src/base/random.hpp"
#include "src/diagnose/catalogue.hpp"
#include "src/diagnose/scores.hpp"

namespace quern {
namespace {

using Row = Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double family_level = 0.01;     // of the test whether anything is left
constexpr double second_look = 0.2;       // below which candidates are tried: what they would do is a sharper question than whether anything is left
constexpr double left_level = 0.001;      // what is left of an explanation refutes it
constexpr double least_visible = 3.4;     // standard deviations: 80 % power of a test at 1 %
constexpr double alike_odds = 3.0;        // ln of odds within which a rival is not ruled out
constexpr double most_effort = 4;         // of a run with an effect, over one of the case
constexpr double design_reach = 2.0;      // steps of the design beyond which the emulators are not believed before runs were made there
// Before any data: that nothing is missing, that one known effect is, that something unknown is, that two are.
constexpr double prior_none = 0.45, prior_one = 0.40, prior_unknown = 0.10, prior_two = 0.05;

double normal_above(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

// One number of the case may move alone or with others.
bool alike(const MachineParameter& a, const MachineParameter& b) { return a.key == b.key && a.moves.size() == b.moves.size(); }

struct Explanation {
  std::vector<std::string> effects;
  std::string form;
  MachineFit fit;
  double gain = 0, bic = 0, probability = 0, held_out = 0, held_out_gain = 0, surprise = 0;
  bool rival = false, free_form = false;
};

class MachineInvestigation {
 public:
  MachineInvestigation(const MachineExperiment& experiment, const CaseRunner& runner, const DiagnoseOptions& options) : experiment_(experiment), model_(experiment, runner), options_(options) {}

  MachineDiagnosis run() {
    split();
    free_ = free_parameters(experiment_.base());
    for (MachineParameter& p : free_) model_.give_dimension(p);
    if (!enough_data()) return finish();
    design();
    calibrate();
    candidates_ = machine_candidates(experiment_);
    judge_baseline();
    // A body that breaks is simulated in a second: there the sharper question is always asked.
    if (experiment_.packings() == 1 && d_.adequacy_p > second_look) {
      nothing_more();
    } else {
      screen();
      judge_baseline();
      explain();
    }
    return finish();
  }

 private:
  void note(const std::string& what, const MachineFit& fit) { d_.ledger.push_back({what, fmt::format("{:.3f}", fit.log_likelihood), fmt::format("{}", model_.runs_made())}); }

  // By condition, never inside one: those that the recording holds out are sealed; otherwise a quarter of the conditions, drawn by chance.
  void split() {
    const auto& rows = experiment_.recording().rows;
    const bool told = std::any_of(rows.begin(), rows.end(), [](const MachineRow& row) { return row.held_out.has_value(); });
    std::vector<std::size_t> open;
    for (std::size_t r = 0; r < rows.size(); ++r) (told && rows[r].held_out.value_or(false) ? sealed_ : open).push_back(r);
    RandomStream random(options_.seed, 12);
    for (std::size_t k = open.size(); k > 1; --k) std::swap(open[k - 1], open[static_cast<std::size_t>(random.uniform() * static_cast<double>(k))]);
    // The ends of the curve come first, so that what is sealed lies between what was fitted.
    const std::string& leading = experiment_.leading_condition();
    if (!leading.empty() && open.size() >= 4) {
      const auto at = [&](std::size_t r) { return rows[r].conditions.count(leading) > 0 ? rows[r].conditions.at(leading) : 0.0; };
      const auto [least, most] = std::minmax_element(open.begin(), open.end(), [&](std::size_t a, std::size_t b) { return at(a) < at(b); });
      const double low = at(*least), high = at(*most);
      std::stable_partition(open.begin(), open.end(), [&](std::size_t r) { return at(r) == low || at(r) == high; });
    }
    if (!told && open.size() >= 4) {
      const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(experiment_.base().number("diagnose.held_out") * static_cast<double>(open.size()))));
      sealed_.assign(open.end() - static_cast<std::ptrdiff_t>(count), open.end());
      open.resize(open.size() - count);
    }
    const std::size_t selecting = open.size() >= 3 ? std::max<std::size_t>(1, open.size() / 3) : 0;
    select_.assign(open.end() - static_cast<std::ptrdiff_t>(selecting), open.end());
    fit_.assign(open.begin(), open.end() - static_cast<std::ptrdiff_t>(selecting));
    train_ = open;
    for (auto* part : {&sealed_, &select_, &fit_, &train_}) std::sort(part->begin(), part->end());
    for (const auto& [part, labels] : {std::pair(&fit_, &d_.fit_runs), std::pair(&select_, &d_.select_runs), std::pair(&sealed_, &d_.sealed_runs)})
      for (const std::size_t r : *part) labels->push_back(rows[r].label);
  }

  bool enough_data() {
    std::size_t numbers = 0;
    for (const RecordedChannel& channel : experiment_.channels())
      for (const auto& site : channel.sites) numbers += std::find(train_.begin(), train_.end(), site.row) != train_.end();
    if (numbers >= free_.size() + 3) return true;
    d_.verdict = Verdict::insufficient_data;
    d_.confidence = 0.9;
    d_.remarks.push_back(fmt::format("{} numbers stand against {} that may be calibrated; at least three more are needed to tell noise from physics.", numbers, free_.size()));
    return false;
  }

  std::vector<MachineModel::Request> at_rows(const std::vector<std::size_t>& rows, const std::vector<MachineParameter>& parameters, const VectorXd& z) const {
    std::vector<MachineModel::Request> all;
    for (const std::size_t row : rows) all.push_back({row, parameters, z});
    return all;
  }

  // The case as it stands under all conditions, and each free number one step away under those of training.
  void design() {
    const auto n = static_cast<Row>(free_.size());
    std::vector<std::size_t> all = train_;
    all.insert(all.end(), sealed_.begin(), sealed_.end());
    std::sort(all.begin(), all.end());
    if (!model_.run(at_rows(all, free_, VectorXd::Zero(n)), "the case")) throw RunError("a run of the case failed; its log.txt in the folder runs tells why.");
    std::vector<MachineModel::Request> requests;
    for (Row k = 0; k < n; ++k) {
      const MachineParameter& p = free_[static_cast<std::size_t>(k)];
      for (const double step : {1.0, -1.0}) {
        VectorXd z = VectorXd::Zero(n);
        z[k] = step;
        if (p.at(step) < p.lower || p.at(step) > p.upper) z[k] = step < 0 ? 0.5 : 0.0;  // where there is no room, halfway on the other side
        if (z[k] == 0) continue;
        const auto some = at_rows(train_, free_, z);
        requests.insert(requests.end(), some.begin(), some.end());
      }
    }
    model_.run(requests, "free numbers one step away");
  }

  std::vector<VectorXd> starts(Row n) const {
    std::vector<VectorXd> all = {VectorXd::Zero(n)};
    for (Row k = 0; k < n; ++k)
      for (const double step : {1.0, -1.0}) {
        VectorXd z = VectorXd::Zero(n);
        z[k] = step;
        all.push_back(z);
      }
    return all;
  }

  // Fits, makes runs where the fit came out, and fits again, until it stays where runs are.
  MachineFit settled(const std::vector<MachineParameter>& parameters, std::vector<VectorXd> from, const std::string& what, int rounds) {
    MachineFit fit = model_.fit(parameters, train_, from, design_reach);
    double reach = design_reach;
    for (int round = 0; round < rounds && fit.sound; ++round) {
      constexpr double near = 0.2;
      if (model_.explored(fit, near * std::max(1.0, fit.z.size() > 0 ? fit.z.cwiseAbs().maxCoeff() : 1.0))) break;
      if (model_.effort({train_.front(), fit.moved, fit.z}) > 2 * most_effort || !model_.run(model_.requests_at(fit, train_), what + " where it fits")) break;
      reach *= 2;
      from.push_back(fit.z);
      fit = model_.fit(parameters, train_, from, reach);
    }
    note(what, fit);
    return fit;
  }

  // Runs one step beside a fit in each direction, so that its slopes, on which intervals and predictions rest, are those of the simulation there.
  MachineFit polished(const MachineFit& fit) {
    std::vector<MachineModel::Request> requests;
    for (std::size_t k = 0; k < fit.moved.size(); ++k) {
      const MachineParameter& p = fit.moved[k];
      if (!p.simulated()) continue;
      const auto i = static_cast<Row>(k);
      VectorXd z = fit.z;
      const double step = 0.5 * std::max(1.0, std::abs(z[i]));
      const double above = p.at(z[i] + step), below = p.at(z[i] - step);
      z[i] += above >= p.lower && above <= p.upper ? step : below >= p.lower && below <= p.upper ? -step : 0;
      if (z[i] != fit.z[i] && model_.effort({train_.front(), fit.moved, z}) < 2 * most_effort) {
        const auto some = at_rows(train_, fit.moved, z);
        requests.insert(requests.end(), some.begin(), some.end());
      }
    }
    model_.run(requests, "beside the best");
    MachineFit best = fit;
    for (int round = 0; round < 2; ++round) {
      best = model_.fit(fit.moved, train_, {best.z, fit.z}, 1e3);
      constexpr double near = 0.15;
      if (!best.sound || model_.explored(best, near * std::max(1.0, best.z.cwiseAbs().maxCoeff()))) break;
      model_.run(model_.requests_at(best, train_), "the best");
    }
    note("the best", best);
    return best.sound ? best : fit;
  }

  void calibrate() {
    const auto n = static_cast<Row>(free_.size());
    for (int round = 0; round < 2; ++round) {
      baseline_ = settled(free_, starts(n), "calibrated", 3);
      if (!estimate_noise()) break;
    }
    d_.best = baseline_;
  }

  // Of channels without deviations and repeats: what is left of them after smooth curves over the conditions, which no noise follows.
  bool estimate_noise() {
    bool any = false;
    const MachineTold told = model_.tell(baseline_.moved, baseline_.z, train_);
    for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
      if (model_.noise_known(c)) continue;
      const RecordedChannel& channel = experiment_.channels()[c];
      std::vector<Row> mine;
      for (std::size_t k = 0; k < told.places.size(); ++k)
        if (told.places[k][0] == c) mine.push_back(static_cast<Row>(k));
      const auto n = static_cast<Row>(mine.size());
      const Row d = channel.coordinates.cols(), terms = 1 + 2 * d;
      if (n < terms + 2) continue;
      MatrixXd curves(n, terms);
      VectorXd rest(n);
      for (Row i = 0; i < n; ++i) {
        const auto site = static_cast<Row>(told.places[static_cast<std::size_t>(mine[static_cast<std::size_t>(i)])][1]);
        curves(i, 0) = 1;
        for (Row v = 0; v < d; ++v) curves(i, 1 + v) = channel.coordinates(site, v), curves(i, 1 + d + v) = std::pow(channel.coordinates(site, v), 2);
        rest[i] = told.recorded[mine[static_cast<std::size_t>(i)]] - told.mean[mine[static_cast<std::size_t>(i)]];
      }
      const Eigen::ColPivHouseholderQR<MatrixXd> qr(curves);
      const double squares = (rest - curves * qr.solve(rest)).squaredNorm();
      const double largest = told.recorded.cwiseAbs().maxCoeff();
      // The mean of log χ² lies below log of its mean: a few numbers tend to look quieter than they are.
      const auto left = static_cast<double>(n - qr.rank());
      model_.set_noise(c, std::max(channel.scale == Scale::logarithm ? 0.02 : 1e-3 * largest, std::sqrt(squares / std::max(1.0, left - 1))));
      any = true;
    }
    return any;
  }

  // What is left of a fit in units of its noise, with the slopes of what was fitted taken out of it.
  struct Whitened {
    VectorXd rest;
    MatrixXd basis;                     // orthonormal, of the slopes
    Eigen::LLT<MatrixXd> factor;
    Row degrees = 0;
    VectorXd left(const VectorXd& direction) const {
      const VectorXd white = factor.matrixL().solve(direction);
      return white - basis * (basis.transpose() * white);
    }
  };
  Whitened whitened(const MachineFit& fit) const {
    const MachineTold told = model_.tell(fit.moved, fit.z, train_);
    Whitened w;
    w.factor.compute(told.covariance);
    MatrixXd slopes = MatrixXd::Zero(told.mean.size(), 0);
    if (!fit.moved.empty()) slopes = w.factor.matrixL().solve(model_.slopes(fit.moved, fit.z, train_));
    Eigen::ColPivHouseholderQR<MatrixXd> qr(slopes);
    qr.setThreshold(1e-6);
    const Row rank = slopes.cols() > 0 ? qr.rank() : 0;
    w.basis = MatrixXd(qr.householderQ() * MatrixXd::Identity(slopes.rows(), rank));
    const VectorXd white = w.factor.matrixL().solve(told.recorded - told.mean);
    w.rest = white - w.basis * (w.basis.transpose() * white);
    w.degrees = told.mean.size() - rank;
    return w;
  }

  struct Filter {
    VectorXd unit;      // along the direction, as the fit leaves it
    double visible = 0; // its length for one step of the design
    bool one_sided = false;
  };

  // How a step of each candidate that needs no runs, or has had its runs, would show about a fit; and smooth changes of each channel.
  std::vector<Filter> filters_about(const MachineFit& fit, const Whitened& w) const {
    std::vector<Filter> all;
    const auto add = [&](const VectorXd& direction, bool one_sided) {
      const VectorXd left = w.left(direction);
      const double length = left.norm();
      all.push_back({length > 1e-6 ? VectorXd(left / length) : VectorXd::Zero(left.size()), length, one_sided});
    };
    const MachineTold told = model_.tell(fit.moved, fit.z, train_);
    for (const MachineCandidate& c : candidates_) {
      const auto same = std::find_if(fit.moved.begin(), fit.moved.end(), [&](const MachineParameter& p) { return alike(p, c.parameter); });
      if (same != fit.moved.end() || (c.parameter.simulated() && c.parameter.dimension < 0)) {
        all.push_back({});
        continue;
      }
      std::vector<MachineParameter> with = fit.moved;
      with.push_back(c.parameter);
      VectorXd z(fit.z.size() + 1);
      z << fit.z, 1;
      const bool one_sided = std::min(std::abs(c.parameter.lower - c.parameter.null), std::abs(c.parameter.upper - c.parameter.null)) < 1e-12;
      add(model_.tell(with, z, train_).mean - told.mean, one_sided);
    }
    for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
      const RecordedChannel& channel = experiment_.channels()[c];
      for (Row power = 0; power < 2; ++power)
        for (Row v = 0; v < (power == 0 ? 1 : channel.coordinates.cols()); ++v) {
          VectorXd direction = VectorXd::Zero(told.mean.size());
          for (std::size_t k = 0; k < told.places.size(); ++k)
            if (told.places[k][0] == c) direction[static_cast<Row>(k)] = power == 0 ? 1 : channel.coordinates(static_cast<Row>(told.places[k][1]), v) - 0.5;
          add(direction, false);
        }
    }
    return all;
  }

  static double p_of(const Filter& f, const VectorXd& rest) {
    const double along = f.unit.dot(rest);
    return f.one_sided ? normal_above(along) : 2 * normal_above(std::abs(along));
  }

  // The chance that noise alone leaves as much: of the sum of squares and of every filter, the smallest chance, against what 999 drawings of the noise give.
  double left_over(const MachineFit& fit, std::vector<Filter>* filters = nullptr) const {
    const Whitened w = whitened(fit);
    const std::vector<Filter> all = filters_about(fit, w);
    const auto least = [&](const VectorXd& rest) {
      double p = chi_squared_above(rest.squaredNorm(), static_cast<int>(w.degrees));
      for (const Filter& f : all)
        if (f.visible > 1e-6) p = std::min(p, p_of(f, rest));
      return p;
    };
    const double seen = least(w.rest);
    if (filters != nullptr) *filters = all;
    // Where a channel's noise is an estimate, it may be off: t-distributed rather than normal.
    double quiet = 0;
    for (std::size_t c = 0; c < experiment_.channels().size(); ++c) quiet += !model_.noise_known(c);
    RandomStream random(options_.seed, 13);
    constexpr int repetitions = 999;
    int as_small = 0;
    for (int k = 0; k < repetitions; ++k) {
      VectorXd noise(w.rest.size());
      for (Row i = 0; i < noise.size(); ++i) noise[i] = random.normal();
      if (quiet > 0) {
        double chi = 0;
        const int degrees = std::max(2, static_cast<int>(w.degrees) - 4);
        for (int i = 0; i < degrees; ++i) chi += std::pow(random.normal(), 2);
        noise *= std::sqrt(degrees / chi);
      }
      noise -= w.basis * (w.basis.transpose() * noise).eval();
      as_small += least(noise) <= seen;
    }
    // Beyond what drawings can tell: the smallest chance, times as many as were asked.
    const double told = static_cast<double>(as_small + 1) / (repetitions + 1);
    return as_small > 0 ? told : std::min(told, seen * static_cast<double>(all.size() + 1));
  }

  void judge_baseline() {
    d_.adequacy_p = left_over(baseline_, &filters_);
    d_.detectable.clear();
    for (std::size_t k = 0; k < candidates_.size(); ++k)
      if (!candidates_[k].rival && filters_[k].visible > 1e-6)
        d_.detectable.push_back({candidates_[k].effect, candidates_[k].parameter.key, candidates_[k].parameter.unit, least_visible / filters_[k].visible * std::abs(candidates_[k].parameter.scale)});
  }

  // Step 7: one step of each candidate that needs runs.
  void screen() {
    for (MachineCandidate& c : candidates_) {
      if (!c.parameter.simulated()) continue;
      model_.give_dimension(c.parameter);
      std::vector<MachineParameter> with = free_;
      with.push_back(c.parameter);
      // About the case as it stands: what calibration has bent to make up for what is missing is no place to look from.
      VectorXd z = VectorXd::Zero(static_cast<Row>(with.size()));
      z[z.size() - 1] = 1;
      // What makes contacts so stiff that runs would take for ever is looked at more weakly.
      for (int halvings = 0; halvings < 3 && model_.effort({train_.front(), with, z}) > most_effort; ++halvings) c.parameter.scale *= 0.3, with.back() = c.parameter;
      if (model_.effort({train_.front(), with, z}) > most_effort) {
        c.parameter.dimension = -1;
        d_.remarks.push_back(fmt::format("{} was not looked for: its runs would take more than {:.0f} times as long as those of the case.", c.effect, most_effort));
        continue;
      }
      if (!model_.run(at_rows(train_, with, z), c.effect)) d_.remarks.push_back(fmt::format("Runs with {} failed at {} = {:.3g}; what it would do is not known.", c.effect, c.parameter.key, c.parameter.at(1)));
    }
    // The case is known better by now.
    const auto n = static_cast<Row>(free_.size());
    auto from = starts(n);
    from.push_back(baseline_.z);
    baseline_ = settled(free_, from, "calibrated", 1);
  }

  Explanation explain_by(const std::vector<const MachineCandidate*>& which, int rounds, const std::vector<VectorXd>& also = {}) {
    Explanation e;
    std::vector<MachineParameter> parameters = free_;
    for (const MachineCandidate* c : which) {
      parameters.push_back(c->parameter);
      e.effects.push_back(c->effect);
      e.form += (e.form.empty() || c->form.empty() ? "" : ", ") + c->form;
      e.rival |= c->rival, e.surprise += c->surprise;
    }
    const auto n = static_cast<Row>(parameters.size()), f = static_cast<Row>(free_.size());
    std::vector<VectorXd> from = also;
    for (const double strength : {0.02, 0.3, 1.0}) {
      VectorXd z = VectorXd::Zero(n);
      z.head(f) = baseline_.z;
      z.tail(n - f).setConstant(strength);
      from.push_back(z);
      if (which.size() == 1 && which.front()->parameter.lower < which.front()->parameter.null && which.front()->parameter.upper > which.front()->parameter.null) {
        z.tail(n - f).setConstant(-strength);
        from.push_back(z);
      }
    }
    const std::string what = fmt::format("{}", fmt::join(e.effects, " and "));
    e.fit = settled(parameters, from, what, rounds);
    rate(e);
    return e;
  }

  void rate(Explanation& e) const {
    e.gain = e.fit.log_likelihood - baseline_.log_likelihood;
    const double numbers = static_cast<double>(model_.tell(free_, baseline_.z, train_).mean.size());
    e.bic = -2 * e.gain + static_cast<double>(e.fit.moved.size() - free_.size()) * std::log(std::max(2.0, numbers));
  }

  // Smooth changes of every channel with its conditions, of no cause in particular: the measure of what names could explain.
  double free_form_bic() const {
    const Whitened w = whitened(baseline_);
    const std::vector<Filter> all = filters_about(baseline_, w);
    MatrixXd columns(w.rest.size(), static_cast<Row>(all.size() - candidates_.size()));
    for (Row k = 0; k < columns.cols(); ++k) columns.col(k) = all[candidates_.size() + static_cast<std::size_t>(k)].unit;
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
    const double gain = w.rest.squaredNorm() - (w.rest - columns * qr.solve(w.rest)).squaredNorm();
    return -gain + static_cast<double>(qr.rank()) * std::log(std::max(2.0, static_cast<double>(w.rest.size())));
  }

  void weigh() {
    std::map<std::string, int> forms;
    std::set<std::string> names;
    for (const MachineCandidate& c : candidates_) ++forms[c.effect], names.insert(c.effect);
    const double count = std::max<double>(1, static_cast<double>(names.size()));
    const auto weight = [&](const Explanation& e) {
      const double prior = e.free_form ? std::log(prior_unknown) : e.effects.size() > 1 ? std::log(prior_two / (count * (count - 1) / 2)) : std::log(prior_one / count / forms[e.effects.front()]);
      double strange = e.surprise;
      for (std::size_t k = 0; k < e.fit.moved.size() && !e.free_form; ++k)  // instruments are calibrated: wrong by some hundredths, not by half
        if (e.fit.moved[k].acts == MachineParameter::Acts::gain) strange += 0.5 * std::pow(std::log(std::max(1e-3, e.fit.value(k))) / 0.05, 2);
      return -0.5 * e.bic - strange + prior;
    };
    double most = std::log(prior_none);
    for (const Explanation& e : tried_) most = std::max(most, weight(e));
    double sum = prior_none * std::exp(-most);
    for (Explanation& e : tried_) e.probability = std::exp(weight(e) - most), sum += e.probability;
    for (Explanation& e : tried_) e.probability /= sum;
    std::stable_sort(tried_.begin(), tried_.end(), [](const Explanation& a, const Explanation& b) { return a.probability > b.probability; });
  }

  Explanation* best_named() {
    for (Explanation& e : tried_)
      if (!e.free_form && !e.rival) return &e;
    return nullptr;
  }

  // Step 9: what a model fitted on the fit part tells of the select part.
  void hold_out(Explanation& e) const {
    if (select_.empty() || fit_.empty() || e.free_form) return;
    const auto told_of = [&](const std::vector<MachineParameter>& parameters, const VectorXd& from) {
      const MachineFit part = model_.fit(parameters, fit_, {from}, 1e3);
      return model_.tell(parameters, part.z, select_);
    };
    const MachineTold with = told_of(e.fit.moved, e.fit.z), without = told_of(free_, baseline_.z);
    e.held_out = model_.misfit(with);
    e.held_out_gain = model_.log_likelihood(with) - model_.log_likelihood(without);
  }

  // The chance that the best of all explanations would gain as much in noise alone, by the law of large numbers (Wilks 1938), one-sided, for as many as were tried.
  double chance_of_gain() const {
    double most = 0;
    int count = 0;
    for (const Explanation& e : tried_)
      if (!e.rival && !e.free_form && e.effects.size() == 1) most = std::max(most, e.gain), ++count;
    return std::min(1.0, count * normal_above(std::sqrt(2 * most)));
  }

  // Steps 8 to 11.
  void explain() {
    tried_.clear();
    for (const MachineCandidate& c : candidates_)
      if (!c.parameter.simulated() || c.parameter.dimension >= 0) tried_.push_back(explain_by({&c}, 0));
    weigh();
    // Filters look from where the calibration has come to rest; an explanation may lie far from there.
    if (std::min(d_.adequacy_p, chance_of_gain()) > family_level) return nothing_more();
    refine_best(3);
    d_.adequacy_p = std::min(d_.adequacy_p, chance_of_gain());
    if (d_.adequacy_p > family_level) return nothing_more();
    const auto look = [&] {
      const Explanation* named = best_named();
      d_.remaining_p = named != nullptr ? left_over(named->fit) : 0;
    };
    look();
    if (d_.remaining_p < family_level) {
      try_pairs();
      look();
    }
    Explanation smooth;
    smooth.effects = {"unknown"}, smooth.form = "smooth changes of each channel with the conditions", smooth.free_form = true;
    smooth.fit = baseline_, smooth.bic = free_form_bic();
    tried_.push_back(smooth);
    weigh();
    for (std::size_t k = 0; k < std::min<std::size_t>(4, tried_.size()); ++k) hold_out(tried_[k]);
    choose();
  }

  // The explanations that lead are fitted with runs where they lead.
  void refine_best(std::size_t count) {
    for (int round = 0; round < 2; ++round) {
      std::size_t seen = 0;
      bool changed = false;
      for (std::size_t k = 0; k < tried_.size() && seen < count; ++k) {
        Explanation& e = tried_[k];
        if (e.free_form || (e.bic > tried_.front().bic + 12 && k > 0)) continue;
        ++seen;
        const std::size_t before = model_.runs_made();
        std::vector<const MachineCandidate*> which = candidates_of(e);
        Explanation again = explain_by(which, 2, {e.fit.z});
        changed |= model_.runs_made() != before;
        e = again;
      }
      if (!changed) break;
      // More runs tell more of the case, too.
      baseline_ = model_.fit(free_, train_, {baseline_.z, VectorXd::Zero(static_cast<Row>(free_.size()))}, 1e3);
      for (Explanation& e : tried_) {
        e.fit = model_.fit(e.fit.moved, train_, {e.fit.z}, 1e3);
        rate(e);
      }
      weigh();
    }
  }

  std::vector<const MachineCandidate*> candidates_of(const Explanation& e) const {
    std::vector<const MachineCandidate*> which;
    for (std::size_t k = free_.size(); k < e.fit.moved.size(); ++k)
      for (const MachineCandidate& c : candidates_)
        if (alike(c.parameter, e.fit.moved[k])) which.push_back(&c);
    return which;
  }

  void try_pairs() {
    std::vector<Explanation> leading(tried_.begin(), tried_.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(4, tried_.size())));
    std::vector<Explanation> pairs;
    std::set<std::set<std::string>> done;
    for (const Explanation& first : leading) {
      if (first.rival) continue;
      for (const MachineCandidate& second : candidates_) {
        const MachineCandidate* one = candidates_of(first).front();
        if (one->effect == second.effect || second.rival || (second.parameter.simulated() && second.parameter.dimension < 0)) continue;
        if (!done.insert({one->parameter.key, second.parameter.key}).second) continue;
        VectorXd z(first.fit.z.size() + 1);
        z << first.fit.z, 0.2;
        pairs.push_back(explain_by({one, &second}, 0, {z}));
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Explanation& a, const Explanation& b) { return a.bic < b.bic; });
    const double single = best_named() != nullptr ? best_named()->bic : 0;
    for (std::size_t k = 0; k < std::min<std::size_t>(3, pairs.size()); ++k)
      if (pairs[k].bic < single - 2) tried_.push_back(explain_by(candidates_of(pairs[k]), 1, {pairs[k].fit.z}));
    weigh();
  }

  void choose() {
    const Explanation* named = best_named();
    double free = 0, names = 0;
    for (const Explanation& e : tried_) (e.free_form ? free : names) += e.rival ? 0 : e.probability;
    if (named == nullptr || named->bic > -2 || d_.remaining_p < left_level || free > names) return unexplained(named);
    d_.verdict = Verdict::omitted_physics;
    d_.effects = named->effects, d_.form = named->form;
    d_.best = polished(named->fit);
    double own = 0;
    std::map<std::string, double> others;
    for (const Explanation& e : tried_) {
      if (e.free_form || e.rival) continue;
      if (e.effects == named->effects) own += e.probability;
      else if (e.effects.size() == 1 && named->effects.size() == 1) others[e.effects.front()] += e.probability;
    }
    d_.confidence = own;
    // A quantity that the case calls known, and that would do, leaves less to be sure of.
    for (const Explanation& e : tried_)
      if (e.rival) d_.confidence = std::min(d_.confidence, own / (own + e.probability));
    if (d_.remaining_p < family_level) d_.confidence *= 0.7;
    std::vector<std::pair<double, std::string>> order;
    for (const auto& [name, probability] : others)
      if (probability > own * std::exp(-alike_odds)) order.push_back({-probability, name});
    std::sort(order.begin(), order.end());
    for (const auto& [probability, name] : order) d_.indistinguishable.push_back(name);
    for (const Explanation& e : tried_)
      if (e.rival && e.probability > named->probability * std::exp(-alike_odds)) d_.remarks.push_back(fmt::format("{} would do as well; the case calls it known.", e.form));
    if (const EffectEntry* entry = find_effect(d_.effects.front())) {
      d_.signature = entry->signature;
      if (!d_.indistinguishable.empty()) d_.advice = fmt::format("To part {} from {}: {}.", d_.effects.front(), fmt::join(d_.indistinguishable, ", "), entry->experiment);
    }
  }

  void unexplained(const Explanation* named) {
    d_.verdict = Verdict::unexplained;
    d_.best = baseline_;
    d_.form = "smooth changes of each channel with the conditions";
    double probability = named != nullptr ? named->probability : 0;
    d_.confidence = std::clamp(1 - probability * std::min(1.0, d_.remaining_p / left_level), 0.5, 0.97);
    if (named != nullptr)
      d_.remarks.push_back(fmt::format("The nearest known effect, {}, leaves structure that noise would leave with a probability of {:.2g}.", fmt::join(named->effects, " with "), d_.remaining_p));
    d_.remarks.push_back("What is left is in residuals.csv; a machine's curves do not tell the force behind it, and amended.toml is the calibrated case.");
  }

  void nothing_more() {
    d_.best = baseline_;
    const auto n = static_cast<Row>(free_.size());
    double distance = 0;
    if (n > 0) distance = baseline_.z.dot(baseline_.covariance.ldlt().solve(baseline_.z));
    d_.verdict = n > 0 && chi_squared_above(distance, static_cast<int>(n)) < family_level ? Verdict::parameters_only : Verdict::nothing_missing;
    d_.confidence = (d_.verdict == Verdict::nothing_missing ? 0.65 : 0.5) + 0.2 * d_.adequacy_p;
  }

  // Where the recording and the case differ: the interval of the leading condition, or of the energy, that stands out most in one channel. Where something was
  // found it is its own doing that is looked at, since calibration without it bends other channels to make up for it.
  void locate() {
    MachineTold told = model_.tell(baseline_.moved, baseline_.z, train_);
    if (d_.verdict == Verdict::omitted_physics) {
      VectorXd without = d_.best.z;
      without.tail(without.size() - static_cast<Row>(free_.size())).setZero();
      const VectorXd with = model_.tell(d_.best.moved, d_.best.z, train_).mean;
      told = model_.tell(d_.best.moved, without, train_);
      told.recorded = with;
    }
    double most = 0;
    for (std::size_t c = 0; c < experiment_.channels().size(); ++c) {
      const RecordedChannel& channel = experiment_.channels()[c];
      const bool by_energy = channel.scale == Scale::logarithm;
      struct Point {
        double at, rest;
      };
      std::vector<Point> points;
      for (std::size_t k = 0; k < told.places.size(); ++k) {
        if (told.places[k][0] != c) continue;
        const auto& site = channel.sites[told.places[k][1]];
        const auto& conditions = experiment_.recording().rows[site.row].conditions;
        const double at = by_energy ? site.energy : experiment_.leading_condition().empty() ? 0 : conditions.at(experiment_.leading_condition());
        const auto i = static_cast<Row>(k);
        points.push_back({at, (told.recorded[i] - told.mean[i]) / std::sqrt(told.covariance(i, i))});
      }
      std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.at < b.at; });
      for (std::size_t first = 0; first < points.size(); ++first) {
        double sum = 0;
        for (std::size_t last = first; last < points.size(); ++last) {
          sum += points[last].rest;
          const double statistic = std::abs(sum) / std::sqrt(static_cast<double>(last - first + 1));
          if (statistic <= most) continue;
          most = statistic;
          std::string unit = by_energy ? "J" : "1";
          for (const MachineConditionName& one : machine_condition_names)
            if (!by_energy && experiment_.leading_condition() == one.name) unit = one.unit;
          d_.where = {channel.label(), by_energy ? "energy" : experiment_.leading_condition(), unit, "", "", points[first].at, points[last].at, d_.adequacy_p, sum > 0 ? "above" : "below"};
        }
      }
    }
  }

  // Step 12: the sealed conditions, simulated with what was found.
  MachineDiagnosis finish() {
    if (d_.verdict == Verdict::omitted_physics || d_.verdict == Verdict::unexplained) d_.confidence = as_experienced(d_.confidence, d_.effects.size() > 1);
    d_.runs = model_.runs_made();
    d_.baseline = baseline_;
    if (!baseline_.sound) return std::move(d_);
    const bool found = d_.verdict == Verdict::omitted_physics;
    if (!sealed_.empty()) {
      std::vector<MachineModel::Request> requests = at_rows(sealed_, baseline_.moved, baseline_.z);
      if (found) {
        const auto more = at_rows(sealed_, d_.best.moved, d_.best.z);
        requests.insert(requests.end(), more.begin(), more.end());
      }
      model_.run(requests, "sealed conditions");
    }
    d_.runs = model_.runs_made();
    const auto side_by_side = [&](const std::vector<std::size_t>& rows, bool sealed) {
      const MachineTold before = model_.tell(baseline_.moved, baseline_.z, rows), after = model_.tell(d_.best.moved, d_.best.z, rows);
      for (Row k = 0; k < before.mean.size(); ++k) {
        const auto simulated = [&](const MachineTold& told) { return std::sqrt(std::max(0.0, told.covariance(k, k) - told.noise[k] * told.noise[k])); };
        const auto [c, s] = before.places[static_cast<std::size_t>(k)];
        d_.residuals.push_back({c, s, before.recorded[k], before.noise[k], before.mean[k], simulated(before), after.mean[k], simulated(after), sealed});
      }
      return Before{model_.misfit(before), model_.misfit(after)};
    };
    d_.train = side_by_side(train_, false);
    if (!sealed_.empty()) {
      d_.sealed = side_by_side(sealed_, true);
      const double excess = d_.sealed->before * d_.sealed->before - 1, left = std::max(0.0, d_.sealed->after * d_.sealed->after - 1);
      d_.excess_removed = excess > 0 ? 1 - left / excess : 0;
      if (found && d_.sealed->after > std::max(1.3, d_.sealed->before)) {
        d_.confidence *= 0.5;
        d_.remarks.push_back("Under the sealed conditions it does not fit better: the name may be a stand-in for something else.");
      }
    }
    if (found || d_.verdict == Verdict::unexplained) locate();
    for (std::size_t k = 0; k < d_.best.moved.size(); ++k) {
      const MachineParameter& p = d_.best.moved[k];
      Estimate e;
      e.key = p.key, e.unit = p.unit, e.value = d_.best.value(k), e.deviation = d_.best.deviation(k), e.of_effect = k >= free_.size();
      if (!e.of_effect) e.nominal = p.null;
      d_.parameters.push_back(e);
    }
    std::stable_sort(d_.parameters.begin(), d_.parameters.end(), [](const Estimate& x, const Estimate& y) { return x.of_effect > y.of_effect; });
    for (const Explanation& e : tried_) d_.ranking.push_back({e.effects, e.form, e.held_out, e.held_out_gain, e.bic, e.probability, e.rival});
    return std::move(d_);
  }

  const MachineExperiment& experiment_;
  MachineModel model_;
  DiagnoseOptions options_;
  std::vector<std::size_t> fit_, select_, sealed_, train_;
  std::vector<MachineParameter> free_;
  std::vector<MachineCandidate> candidates_;
  std::vector<Filter> filters_;        // by candidate, then smooth changes
  MachineFit baseline_;
  std::vector<Explanation> tried_;
  MachineDiagnosis d_;
};

}  // namespace

MachineDiagnosis diagnose_machine(const MachineExperiment& experiment, const CaseRunner& runner, const DiagnoseOptions& options) { return MachineInvestigation(experiment, runner, options).run(); }

}  // namespace quern
