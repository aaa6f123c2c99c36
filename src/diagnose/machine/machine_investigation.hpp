// One comparison of a machine under way: what is known so far and the steps that add to it (docs/diagnose-machines.md). The steps are in machine_diagnosis.cpp
// (the split, what is told in the end), machine_calibration.cpp, machine_screening.cpp and machine_choice.cpp.
#pragma once
#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <map>
#include <string>
#include <vector>
#include "src/diagnose/machine/machine_diagnosis.hpp"

namespace quern {

inline constexpr double family_level = 0.01;     // of the test whether anything is left
inline constexpr double second_look = 0.2;       // below which candidates are tried: what they would do is a sharper question than whether anything is left
inline constexpr double left_level = 0.001;      // what is left of an explanation refutes it
inline constexpr double least_visible = 3.4;     // standard deviations: 80 % power of a test at 1 %
inline constexpr double alike_odds = 3.0;        // ln of odds within which a rival is not ruled out
inline constexpr double most_effort = 4;         // of a run with an effect, over one of the case
inline constexpr double design_reach = 2.0;      // steps of the design beyond which the emulators are not believed before runs were made there
// Before any data: that nothing is missing, that one known effect is, that something unknown is, that two are.
inline constexpr double prior_none = 0.45, prior_one = 0.40, prior_unknown = 0.10, prior_two = 0.05;

// P(x > …) of a normal number.
double normal_above(double x);
// One number of the case may move alone or with others.
bool alike(const MachineParameter& a, const MachineParameter& b);

struct Explanation {
  std::vector<std::string> effects;
  std::string form;
  MachineFit fit;
  double gain = 0, bic = 0, probability = 0, held_out = 0, held_out_gain = 0;
  bool rival = false, free_form = false;
};

// What is left of a fit in units of its noise, with the slopes of what was fitted taken out of it.
struct WhiteRest {
  MachineTold told;
  Eigen::VectorXd rest;
  Eigen::MatrixXd basis;                     // orthonormal, of the slopes
  Eigen::LLT<Eigen::MatrixXd> factor;
  Eigen::Index degrees = 0;
  Eigen::VectorXd left(const Eigen::VectorXd& direction) const {
    const Eigen::VectorXd white = factor.matrixL().solve(direction);
    return white - basis * (basis.transpose() * white);
  }
};

struct Filter {
  Eigen::VectorXd unit;      // along the direction, as the fit leaves it
  double visible = 0;        // its length for one step of the design
  bool one_sided = false;
};

class MachineInvestigation {
 public:
  MachineInvestigation(const MachineExperiment& experiment, const CaseRunner& runner, const DiagnoseOptions& options) : experiment_(experiment), model_(experiment, runner), options_(options) {}
  MachineDiagnosis run();

 private:
  using VectorXd = Eigen::VectorXd;
  using Row = Eigen::Index;

  void note(const std::string& what, const MachineFit& fit) { d_.ledger.push_back({what, fmt::format("{:.3f}", fit.log_likelihood), fmt::format("{}", model_.runs_made())}); }
  // By condition, never inside one: those that the recording holds out are sealed; otherwise a quarter of the conditions, drawn by chance.
  void split();
  bool enough_data();
  std::vector<MachineModel::Request> at_rows(const std::vector<std::size_t>& rows, const std::vector<MachineParameter>& parameters, const VectorXd& z) const;
  // The case as it stands under all conditions, and each free number one step away under those of training.
  void design();
  std::vector<VectorXd> starts(Row n) const;
  // Fits, makes runs where the fit came out, and fits again, until it stays where runs are.
  MachineFit settled(const std::vector<MachineParameter>& parameters, std::vector<VectorXd> from, const std::string& what, int rounds);
  // Runs one step beside a fit in each direction, so that its slopes, on which intervals and predictions rest, are those of the simulation there.
  MachineFit polished(const MachineFit& fit);
  void calibrate();
  // Of channels without deviations and repeats: what is left of them after smooth curves over the conditions, which no noise follows.
  bool estimate_noise();
  WhiteRest whitened(const MachineFit& fit) const;
  // How a step of each candidate that needs no runs, or has had its runs, would show about a fit; and smooth changes of each channel.
  std::vector<Filter> filters_about(const MachineFit& fit, const WhiteRest& w) const;
  static double p_of(const Filter& f, const VectorXd& rest);
  // The chance that noise alone leaves as much: of the sum of squares and of every filter, the smallest chance, against what 999 drawings of the noise give.
  double left_over(const MachineFit& fit, std::vector<Filter>* filters = nullptr) const;
  void judge_baseline();
  // Step 7: one step of each candidate that needs runs.
  void screen();
  Explanation explain_by(const std::vector<const MachineCandidate*>& which, int rounds, const std::vector<VectorXd>& also = {});
  void rate(Explanation& e) const;
  // Smooth changes of every channel with its conditions, of no cause in particular: the measure of what names could explain.
  double free_form_bic() const;
  void weigh();
  Explanation* best_named();
  // Step 9: what a model fitted on the fit part tells of the select part.
  void hold_out(Explanation& e) const;
  // The chance that the best of all explanations would gain as much in noise alone, by the law of Wilks (1938), one-sided, for as many as were tried.
  double chance_of_gain() const;
  // Steps 8 to 11.
  void explain();
  // The explanations that lead are fitted with runs where they lead.
  void refine_best(std::size_t count);
  std::vector<const MachineCandidate*> candidates_of(const Explanation& e) const;
  void try_pairs();
  void choose();
  void unexplained(const Explanation* named);
  void nothing_more();
  // Where the recording and the case differ: the interval of the leading condition, or of the energy, that stands out most in one channel. Where something was
  // found it is its own doing that is looked at, since calibration without it bends other channels to make up for it.
  void locate();
  // Step 12: the sealed conditions, simulated with what was found.
  MachineDiagnosis finish();

  const MachineExperiment& experiment_;
  MachineModel model_;
  DiagnoseOptions options_;
  std::vector<std::size_t> fit_, select_, sealed_, train_;
  std::size_t numbers_ = 0;            // recorded, of training
  std::vector<MachineParameter> free_;
  std::vector<MachineCandidate> candidates_;
  std::vector<Filter> filters_;        // by candidate, then smooth changes
  MachineFit baseline_;
  std::vector<Explanation> tried_;
  MachineDiagnosis d_;
};

}  // namespace quern
