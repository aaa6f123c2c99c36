// What the emulators of a machine tell for any values of its parameters, and fits of them to a recording.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <string>
#include <vector>
#include "src/diagnose/machine/emulator.hpp"
#include "src/diagnose/machine/machine_effects.hpp"

namespace quern {

struct MachineFit {
  std::vector<MachineParameter> moved;  // free parameters first, then those of effects
  Eigen::VectorXd z;                    // their values, in steps of the design from where nothing happens
  Eigen::MatrixXd covariance;           // of z
  std::vector<std::size_t> rows;        // of the recording, that were fitted
  double log_likelihood = -1e300;
  bool sound = false;

  double value(std::size_t k) const { return moved[k].at(z[static_cast<Eigen::Index>(k)]); }
  double deviation(std::size_t k) const {
    const auto i = static_cast<Eigen::Index>(k);
    return std::abs(moved[k].scale) * std::sqrt(std::max(0.0, covariance(i, i)));
  }
};

// Predictions, channel after channel, site after site; only sites of some rows.
struct MachineTold {
  Eigen::VectorXd recorded, mean;
  Eigen::MatrixXd covariance;          // of the prediction and of the noise together
  Eigen::VectorXd noise;               // standard deviation of the recording alone
  std::vector<std::array<std::size_t, 2>> places;  // channel, site
};

class MachineModel {
 public:
  MachineModel(const MachineExperiment& experiment, CaseRunner runner);

  const MachineExperiment& experiment() const { return experiment_; }
  // The place of a parameter among the simulated ones; a new one where it has none yet.
  void give_dimension(MachineParameter& parameter);

  // One run: of a row, with values of simulated parameters (all must have a dimension).
  struct Request {
    std::size_t row;
    std::vector<MachineParameter> parameters;
    Eigen::VectorXd z;
  };
  // Makes those runs that were not made before and learns from them. False where one of them failed.
  bool run(const std::vector<Request>& requests, const std::string& why);
  std::size_t runs_made() const { return made_; }
  // How many times as many steps such a run takes as the case itself.
  double effort(const Request& request) const;

  // Whether runs near these values were made for all the rows: within a part of a step.
  bool explored(const MachineFit& fit, double part) const;

  MachineTold tell(const std::vector<MachineParameter>& parameters, const Eigen::VectorXd& z, const std::vector<std::size_t>& rows) const;
  // ∂ mean/∂ z.
  Eigen::MatrixXd slopes(const std::vector<MachineParameter>& parameters, const Eigen::VectorXd& z, const std::vector<std::size_t>& rows) const;
  // The most likely values within bounds, from each start; z within `farthest` steps of where nothing happens.
  MachineFit fit(const std::vector<MachineParameter>& parameters, const std::vector<std::size_t>& rows, const std::vector<Eigen::VectorXd>& starts, double farthest) const;
  double log_likelihood(const MachineTold& told) const;
  // RMS of what is left over its standard deviation.
  double misfit(const MachineTold& told) const;

  // Where a channel's noise was not recorded it is estimated.
  void set_noise(std::size_t channel, double deviation) { unknown_noise_[channel] = deviation; }
  bool noise_known(std::size_t channel) const;
  Alteration alteration_of(const std::vector<MachineParameter>& parameters, const Eigen::VectorXd& z) const;

 private:
  struct Made {
    std::size_t row;
    Eigen::VectorXd at;   // by dimension
    Outcome outcome;
  };
  Eigen::VectorXd at(const std::vector<MachineParameter>& parameters, const Eigen::VectorXd& z) const;
  void learn();
  void act(const std::vector<MachineParameter>& parameters, const Eigen::VectorXd& z, std::size_t channel, Eigen::VectorXd& mean) const;
  double turn_of(std::size_t row) const { return turns_[row]; }

  const MachineExperiment& experiment_;
  CaseRunner runner_;
  std::vector<std::string> dimensions_;  // by effect and key
  std::vector<Made> runs_;
  std::vector<Emulator> emulators_;      // by channel
  std::vector<double> unknown_noise_;    // by channel
  std::vector<double> turns_;            // speed of the mill by row [rad/s]
  std::vector<double> steps_;            // of a run of the case by row
  std::size_t made_ = 0;
};

}  // namespace quern
