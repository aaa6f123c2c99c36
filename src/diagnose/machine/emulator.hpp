// What runs of a simulation tell of runs that were not made: a Gaussian process over conditions and parameters.
#pragma once
#include <Eigen/Core>
#include <vector>

namespace quern {

// One output of a stochastic simulation, at fixed sites (conditions, energies), as it depends on parameters counted from the case in steps of the design.
// At each site it is a quadratic of the parameters whose coefficients vary smoothly from site to site (a Gaussian process with the kernel
// k(s, s′)·(a² + b² Σ w u u′ + c² Σ w w (u u′)(u u′)); Rasmussen & Williams 2006, § 2.7). What a run scatters by, and what no run has told, is in the covariance.
class Emulator {
 public:
  // One row per site, each coordinate scaled to about 0 … 1.
  Emulator() = default;
  explicit Emulator(Eigen::MatrixXd sites) : sites_(std::move(sites)) {}

  // `deviation`: standard deviation that the run claims for itself; 0: it does not say.
  void add(std::size_t site, const Eigen::VectorXd& parameters, double value, double deviation);
  std::size_t size() const { return samples_.size(); }

  // Finds how smooth, how bent and how noisy the output is, by its marginal likelihood; to be called after the last `add`.
  void learn();

  struct Told {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
  };
  // At all sites, for one set of parameters (those beyond the vector's end are 0).
  Told tell(const Eigen::VectorXd& parameters) const;
  // The scatter of one run at a site, of mean claimed deviation.
  double scatter() const { return scatter_; }

 private:
  struct Sample {
    Eigen::Index site;
    Eigen::VectorXd parameters;
    double value, deviation;
  };
  struct Shape {
    double length = 0.6;   // over which coefficients vary, in coordinates of the sites
    double bend = 0.3;     // c/b
    double noise = 1;      // factor on what runs claim; where they claim nothing: over the spread of all values
  };
  double between_sites(Eigen::Index a, Eigen::Index b, double length) const;
  double of_parameters(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double bend) const;
  double variance_of(const Sample& sample, double noise) const;
  // ln of the marginal likelihood; leaves the factor of the covariance behind.
  double factorize(const Shape& shape);
  void weigh_parameters();

  Eigen::MatrixXd sites_;
  std::vector<Sample> samples_;
  Shape shape_;
  double mean_ = 0, spread_ = 1, scatter_ = 0;
  Eigen::VectorXd weights_;        // by parameter: mean square of the response to one step
  Eigen::MatrixXd factor_;         // lower Cholesky factor of the samples' covariance
  Eigen::VectorXd solved_;         // covariance⁻¹ (values − mean)
};

}  // namespace quern
