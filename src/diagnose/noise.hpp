// The noise of a recording: by channel a standard deviation, a correlation that dies out with time, and tails.
//
// The residual e of a series is a slow part, which forgets itself with φ_i = exp(−Δt_i/τ) (an autoregression of first order on uneven times), and a
// white part, which grows where the signal changes fast and the clock trembles. A Kalman filter makes independent numbers of both; they are
// Student's t with ν degrees of freedom, scaled to the standard deviation 1 of their core: wild points then weigh little (Lange, Little & Taylor 1989), and
// neighbouring samples of a video count for less than their number.
#pragma once
#include <Eigen/Core>
#include <array>
#include "src/diagnose/recording.hpp"

namespace quern {

struct ChannelNoise {
  double deviation = 1;     // σ, in the channel's unit, or times the recorded deviations
  double correlation = 0;   // φ over the median spacing of the channel's samples, 0 … 0.995
  bool by_sample = false;   // φ is from each sample to the next, however far apart: what is read forgets itself, not what is measured
  double spacing = 1;       // that spacing [s]
  double white = 0;         // part of the variance that is white, 0 … 1
  double tail = 1e9;        // ν; beyond 1e6: normal
  double jitter = 0;        // of the clock, over the deviation: adds σ² (jitter × rate of change)² to the white part [s per unit]
};

using Noise = std::array<ChannelNoise, channel_count>;

// How the residuals of one series become independent: u_i = (e_i − carried_i m)/scale_i, where the slow part m is then moved to carried_i m + gain_i (e_i − carried_i m).
struct Whitening {
  Eigen::VectorXd carried, gain, scale;
  double log_scale = 0;  // Σ ln scale_i
};
Whitening whitening_of(const Series& series, const ChannelNoise& noise);

// In place, column by column.
void whiten(const Whitening& whitening, Eigen::Ref<Eigen::MatrixXd> columns);

// ln of the density of u, and the weight with which u² counts in a fit: (ν + 1)/(ν + u²).
double log_density(double u, double tail);
inline double weight_of(double u, double tail) { return tail > 1e6 ? 1.0 : (tail + 1) / (tail + u * u); }

// The median of numbers, of an even count the upper one; 0 of none.
double middle_of(std::vector<double> numbers);

// The median of |x|, times 1.4826: the standard deviation of normal numbers, whatever a few wild ones are.
double robust_deviation(std::vector<double> numbers);

}  // namespace quern
