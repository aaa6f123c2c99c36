// Fits of the experiment to its recording: shared parameters, what each run leaves unknown, and the noise, together.
#pragma once
#include <Eigen/Core>
#include <vector>
#include "src/base/threads.hpp"
#include "src/diagnose/experiment.hpp"
#include "src/diagnose/noise.hpp"

namespace quern {

// One run about a fit: what is left, and how it would change. Rows go through the samples of a run, series after series.
struct RunLinear {
  Eigen::VectorXd rest;      // recorded − predicted
  Eigen::MatrixXd unknowns;  // ∂ predicted/∂ unknowns, in their scales
  Eigen::MatrixXd shared;    // ∂ predicted/∂ shared parameters, in their scales
};

// Just what is left of a run.
inline RunLinear without_slopes(const Eigen::VectorXd& rest) { return {rest, Eigen::MatrixXd(rest.size(), 0), Eigen::MatrixXd(rest.size(), 0)}; }

struct Fit {
  std::vector<Parameter> moved;                // shared parameters
  std::vector<double> shared;                  // their values
  std::vector<Setting> settings;               // other keys that were set
  std::vector<std::vector<double>> unknowns;   // by run
  Noise noise;
  std::vector<std::size_t> runs;               // that were fitted
  std::vector<RunLinear> linear;               // by place in `runs`
  Eigen::MatrixXd covariance;                  // of the shared parameters, in their units
  double log_likelihood = -1e300;              // restricted to what the common unknowns leave (see Comparison::fit)
  double horizon = 1;                          // part of each run's duration that counts
  std::size_t samples = 0;
  int iterations = 0;
  bool sound = false;                          // the simulation ran and the search came to rest

  double deviation(std::size_t k) const { return std::sqrt(std::max(0.0, covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)))); }
};

struct FitOptions {
  int most_iterations = 15;
  int noise_rounds = 3;            // how often the noise is estimated again; 0: that of the start is taken as given
  bool by_horizon = false;         // a beginning of each run is fitted first, then more: for motions that a wrong guess throws out of step
  bool tails = true;               // whether its tails are
  bool thorough = true;            // the slopes at the end are true ones; otherwise those of the start, as its steps corrected them
  std::size_t common = 0;          // how many of the shared parameters the models compared have in common: the first ones
};

// Independent residuals of one run and the columns beside them, weighted by the noise's tails at the fit.
struct Whitened {
  Eigen::VectorXd rest;
  Eigen::MatrixXd unknowns, shared;
  double log_density = 0;          // Σ ln p − Σ ln scale
};

inline constexpr std::size_t few_samples = 30;  // of all runs: they tell a deviation and no more of the noise

class Comparison {
 public:
  Comparison(const Experiment& experiment, ThreadTeam& team) : experiment_(&experiment), recording_(experiment.recording()), team_(&team) {}
  const Experiment& experiment() const { return *experiment_; }
  const Recording& recording() const { return recording_; }
  ThreadTeam& team() const { return *team_; }

  // What is added to all predictions of each run of the recording: the error of finite steps. Empty: nothing.
  void correct(std::vector<Eigen::VectorXd> errors) { errors_ = std::move(errors); }
  const std::vector<Eigen::VectorXd>& corrections() const { return errors_; }

  // From now on: how fast the signals of a fit's runs change at their samples, by which the clock's trembling shows, is as the fit has it, and so is what
  // trembling adds to their means, where a bounce bends them.
  void learn_trembling(const Fit& fit);

  // The most likely values of the moved parameters, within their bounds, and of each run's unknowns, by Levenberg–Marquardt on the
  // likelihood of the noise, whose parameters follow from the restricted likelihood (Patterson & Thompson 1971): what estimates take away from the
  // residuals is given back. Begins at `start` where its sizes fit, else at the case.
  Fit fit(const std::vector<Parameter>& moved, const std::vector<Setting>& settings, const std::vector<std::size_t>& runs, const Fit* start, const FitOptions& options) const;

  // The unknowns of other runs alone, all shared parameters and the noise as in a fit.
  Fit carry_over(const Fit& fit, const std::vector<std::size_t>& runs) const;

  // How the predictions of the fitted runs would change with something more: by place in `runs`.
  std::vector<Eigen::VectorXd> response(const Fit& fit, const Alteration& more) const;

  Whitened whitened(std::size_t run, const RunLinear& linear, const Noise& noise, double horizon = 1) const;

  // The same without weights.
  Whitened independent(std::size_t run, const RunLinear& linear, const Noise& noise) const;

  // The noise about a fit, judged by what is left when the residuals may also follow the main directions of the columns (by place in the fit's runs) and
  // smooth curves over each piece of a run between its contacts: physics that the fit lacks is not taken for noise.
  Noise settled_noise(const Fit& fit, const std::vector<std::vector<Eigen::VectorXd>>& columns) const;

  // The likelihood of a fit's residuals under another noise.
  double log_likelihood(const Fit& fit, const Noise& noise) const;
  std::vector<double> log_likelihoods(const Fit& fit, const Noise& noise) const;  // by run

  // RMS over runs of the independent residuals, each over its standard deviation; tails count as their weights say.
  double misfit(const Fit& fit, const Noise& noise) const;

  Alteration alteration_of(const Fit& fit) const;

 private:
  // What is left of a run; false where the simulation fails.
  bool predict(std::size_t run, const Alteration& altered, const std::vector<double>& unknowns, double horizon, Eigen::VectorXd& rest) const;
  void linearize(Fit& fit, const Fit* known = nullptr) const;
  void estimate_noise(Fit& fit, const FitOptions& options) const;
  void settle(Fit& fit, const FitOptions& options, bool& noise_known, const Fit* start) const;
  // Smooth curves over each piece of a run between its contacts, as columns, and which samples lie clear of the contacts of a bouncing body.
  struct Pieces {
    Eigen::MatrixXd curves;
    std::vector<bool> kept;
  };
  Pieces pieces_of(const Fit& fit, std::size_t place) const;
  // A force leaps at first touch, by what its dashpot does at once: a sample within a step of that may show either side.
  template <class Seen>
  void find_leaps(std::size_t run, const Fit& fit, const Experiment::Prediction& at, Seen&& seen, Eigen::VectorXd& added);
  bool bring_back(Fit& fit) const;
  double restricted(const Fit& fit, const Noise& noise, std::size_t common) const;

  const Experiment* experiment_;
  Recording recording_;  // of the experiment, or a part of its samples
  ThreadTeam* team_;
  std::vector<Eigen::VectorXd> errors_;
  std::vector<Eigen::VectorXd> trembling_;  // what it adds to the mean of each sample; by run, empty where it is not known
};

}  // namespace quern
