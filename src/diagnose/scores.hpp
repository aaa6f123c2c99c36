// What is left after a fit, held against directions in which it could have gone: matched filters and smooth curves, with the chance that any
// of them would stand out as much in noise alone.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>
#include "src/diagnose/comparison.hpp"

namespace quern {

// One or more directions that belong together.
struct Direction {
  std::string name;
  std::vector<std::vector<Eigen::VectorXd>> columns;  // [column][place in the fit's runs], as predictions
  bool one_sided = false;                             // a single column that only counts forwards
  int candidate = -1;                                 // which candidate it is of; −1: none
  std::size_t probe = 0;                              // and which of its probes
};

struct Score {
  double statistic = 0;     // of the independent residuals along the direction, squared, over their variance: χ² with `degrees` in noise alone
  int degrees = 0;          // left after what the fit explains itself
  double p = 1;             // of that alone
  double amplitude = 0;     // of a single column, as a part of it
  double visible = 0;       // length of the direction that the fit cannot explain, in standard deviations
  double share = 0;         // of the direction's length that is visible
};

class Residuals {
 public:
  // `numerical`: how half the time step would move the predictions, by place in the fit's runs; as little is blamed on physics. May be empty.
  Residuals(const Comparison& comparison, const Fit& fit, const std::vector<Eigen::VectorXd>& numerical);

  Score score(const Direction& direction);
  // How likely the smallest p of all directions scored so far would be as small in noise alone; parametric bootstrap with the noise of the fit, whose
  // correlation is itself uncertain.
  double family_p(std::uint64_t seed, int repetitions = 999) const;
  double smallest_p() const { return smallest_p_; }
  // Cosine of the angle between two directions as the fit leaves them.
  double coherence(const Direction& a, const Direction& b) const;

  std::size_t samples() const { return static_cast<std::size_t>(rest_.size()); }
  double degrees_left() const { return degrees_left_; }
  const Eigen::VectorXd& rest() const { return rest_; }
  // A direction's column, independent and weighted, less what the fit explains.
  Eigen::VectorXd left_of(const std::vector<Eigen::VectorXd>& column) const;

 private:
  Eigen::VectorXd stacked(const std::vector<Eigen::VectorXd>& column) const;  // independent and weighted
  Eigen::VectorXd without_own(Eigen::VectorXd all) const;  // less what the unknowns of each run explain
  Eigen::VectorXd unexplained(Eigen::VectorXd all) const;  // and less what the shared parameters do

  const Comparison* comparison_;
  const Fit* fit_;
  std::vector<Eigen::MatrixXd> own_;   // orthonormal: what the unknowns of each run explain
  Eigen::MatrixXd shared_;             // orthonormal: what the shared parameters explain beyond that
  std::vector<Eigen::Index> first_;    // row of each run
  Eigen::VectorXd rest_;
  double degrees_left_ = 1, smallest_p_ = 1;
  bool few_ = false;   // samples: their deviation is hardly known, and is taken from what a direction leaves
  double spread_ = 1;  // standard deviation of what a direction of length one shows in noise alone
  std::vector<Eigen::MatrixXd> bases_;  // of the directions scored, orthonormal
  std::vector<bool> one_sided_;
};

// P(χ² with k degrees > x).
double chi_squared_above(double x, int degrees);

}  // namespace quern
