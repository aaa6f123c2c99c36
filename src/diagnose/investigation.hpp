// One diagnosis under way: what is known so far and the steps that add to it (docs/diagnose.md). The steps are in diagnosis.cpp (calibration, numerics,
// what is told in the end), probing.cpp, search.cpp and choice.cpp.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include "src/diagnose/diagnosis.hpp"

namespace quern {

inline constexpr double family_level = 0.01;   // of the test whether anything is left
inline constexpr double least_visible = 3.4;   // standard deviations: 80 % power of a test at 1 %

struct Split {
  std::vector<std::size_t> fit, select, sealed;
  std::vector<std::size_t> train() const {
    std::vector<std::size_t> all = fit;
    all.insert(all.end(), select.begin(), select.end());
    std::sort(all.begin(), all.end());
    return all;
  }
};

class Investigation {
 public:
  Investigation(const Experiment& experiment, ThreadTeam& team, const DiagnoseOptions& options)
      : experiment_(experiment), comparison_(experiment_, team), options_(options) {}
  Diagnosis run();

 private:
  using VectorXd = Eigen::VectorXd;

  FitOptions options_of() const;
  // With the noise of the start.
  FitOptions noise_given() const;
  void note(const std::string& what, const Fit& fit);
  // Step 4: the baseline as the case has it, and with what may be calibrated.
  void calibrate();
  // Other starts of the calibration, where it may have stopped in a valley of its own. Whether one was better.
  bool start_elsewhere();
  bool enough_data();
  // Step 2: what finite steps (and softer contacts) err by at a fit, of first and second order in them, is told from a half and a quarter of the step and taken off all
  // predictions; what the second order was is taken for what is left (Richardson 1911).
  // Returns by how much that moved the predictions, in standard deviations of all samples together.
  double look_for_numerics(const Fit& about);
  static VectorXd stacked(const Experiment::Prediction& prediction);
  // Whether runs of half the step would still take but milliseconds.
  bool affordable() const;
  void nothing_more();
  // Steps 6, 12 and 13.
  Diagnosis finish();

  // probing.cpp: how candidates would show, and whether anything is left
  // Step 3: the noise about a fit, whatever of the catalogue the fit may lack.
  Noise noise_about(const Fit& fit, const std::vector<Direction>& directions) const;
  static double change_between(const Noise& a, const Noise& b);
  std::vector<VectorXd> response_of(const Fit& fit, const Candidate& c, const std::vector<double>& values) const;
  // The directions of all candidates about a fit.
  std::vector<Direction> directions_about(const Fit& fit, const std::vector<std::string>& without) const;
  // Directions of no cause in particular: smooth curves over each run, common to all of them, by channel; and the strength of an effect that differs
  // between runs, which no cause should (step 10).
  std::vector<Direction> plain_directions(const Fit& fit) const;
  // Waves of one phase in all runs, by channel: what is periodic, or rings.
  void add_waves(Channel channel, const Fit& fit, std::vector<Direction>& all) const;
  // Whether the free numbers are one and the same in all runs, in their order and along each condition.
  std::vector<Direction> scaling_of_free(const Fit& fit) const;
  // Whether the strength that a fit found is one and the same in all runs, and along each condition.
  std::vector<Direction> scaling_directions(const Fit& fit, const Candidate& c) const;
  static bool is_finite(const std::vector<VectorXd>& runs);
  // A first probe that is too strong to be simulated is brought nearer to nothing.
  void soften(Direction& direction);
  // Where the weakest probe of a candidate would show by far, its response bends: a weaker one tells what little of it does.
  void probe_nearer();
  // Which probes are looked at about other fits: the one that the residual asks for most, and the one that shows well without bending.
  void choose_telling();
  // Steps 5 and 7: is anything left, and how each candidate would show.
  void judge_baseline();
  struct Remainder {
    double p = 1;     // chance that noise alone leaves as much
    double gain = 0;  // ln of likelihood that the most telling direction might yet bring
  };
  // What an explanation leaves.
  Remainder remainder_of(const Tried& tried) const;
  // Holds a residual against directions and smooth courses; returns the scores of the directions, and in `gain` that of the best of all.
  std::vector<Score> score_all(Residuals& residuals, const std::vector<Direction>& directions, const Fit& fit, double* gain = nullptr) const;
  // The noise is known better about the best explanation than about the baseline: is the baseline still refuted?
  bool still_refuted();

  // search.cpp: fits of candidates, alone, by body and in pairs
  // Fits a candidate with every free parameter, from each start given; the best is kept.
  std::optional<Tried> attempt(const Candidate& c, const std::vector<std::vector<double>>& starts, const Fit& about, double promised = 0);
  double gain_of(const Fit& fit) const;
  void rate(Tried& tried) const;
  // The noise once more, about the best explanation; what was tried is weighed anew under it.
  void settle_noise();
  // What softer contacts err by depends on what acts: it is told anew about the best explanation, and what was tried is fitted again.
  void settle_softness(const Fit& best);
  // The first of what was tried once more, and all weighed.
  void fit_again(const std::string& why);
  // Where a fit of a candidate begins: at the strength that its response asks for, and at its probes.
  std::vector<std::vector<double>> starts_of(const Candidate& c, const std::vector<Direction>& directions, const std::vector<Score>& scores) const;
  // Step 8: the candidates that the residual asks for, and the free forms.
  void try_candidates();
  // The best fits once more, with slopes that are true where they are.
  void refine();
  // Runs of one body: alike in mass, diameter and density.
  std::map<std::array<double, 3>, std::vector<std::size_t>> bodies() const;
  // What the labels of some runs begin with alike.
  std::string common_label(const std::vector<std::size_t>& runs) const;
  // A coefficient that belongs to the body (its skin, its shape) may differ from body to body, where each was recorded at least twice.
  void try_by_body();
  void try_by_body(const Tried& winner, const std::map<std::array<double, 3>, std::vector<std::size_t>>& groups);
  // A scale that bends is not physics, but it may stand beside it.
  void add_beside(const Tried& first, const Candidate& distortion, Tried both);
  // Two effects: the best ones, each with what its residual asks for.
  void try_pairs();

  // choice.cpp: which explanation holds
  double effects_count() const;
  double log_prior(const Candidate& c) const;
  // Instruments are calibrated: a scale is wrong by some hundredths, not by half.
  static double strangeness(const Fit& fit);
  void weigh();
  // Step 9: what a model that was fitted on the fit part tells of the select part, against the baseline treated likewise.
  void hold_out(Tried& tried);
  // Whether one explanation tells the select part better than another, by more than the chance of its runs.
  bool tells_more(Tried& more, Tried& less);
  Tried* best_single();
  const Tried* best_named() const;
  const Tried* best_free() const;
  // Of all learnt curves, or of all names.
  double probability_of(bool free_form) const;
  void choose();
  // Which bodies need the effect, where each has its own strength.
  void tell_bodies(const Tried& winner);
  void look_alikes(const Tried& winner);
  void unexplained(const Tried* free);

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
  std::vector<std::set<std::size_t>> telling_;  // by candidate: its probes that are; empty: all of all
  std::vector<Score> scores_;
  std::size_t free_forms_ = 1;
  double independent_ = 4, reynolds_ = 0;
  std::optional<Fit> select_baseline_;
  Diagnosis d_;
};

}  // namespace quern
