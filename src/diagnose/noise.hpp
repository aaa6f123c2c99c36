// The noise of a recording: by channel a standard deviation, a correlation that dies out with time, and tails.
//
// The residual e of a series is e_i = φ_i e_{i−1} + σ √(1 − φ_i²) u_i with φ_i = exp(−Δt_i/τ): an autoregression of first order on uneven
// times; u is Student's t with ν degrees of freedom, scaled to the standard deviation 1 of its core. Wild points then weigh little (Lange, Little &
// Taylor 1989), and neighbouring samples of a video count for less than their number.
#pragma once
#include <Eigen/Core>
#include <array>
#include "src/diagnose/recording.hpp"

namespace quern {

struct ChannelNoise {
  double deviation = 1;     // σ, in the channel's unit, or times the recorded deviations
  double correlation = 0;   // φ over the median spacing of the channel's samples, 0 … 0.995
  double spacing = 1;       // that spacing [s]
  double tail = 1e9;        // ν; beyond 1e6: normal
};

using Noise = std::array<ChannelNoise, channel_count>;

// How the residuals of one series become independent: u_i = (e_i − carried_i e_{i−1}) / scale_i.
struct Whitening {
  Eigen::VectorXd carried, scale;
  double log_scale = 0;  // Σ ln scale_i
};
Whitening whitening_of(const Series& series, const ChannelNoise& noise);

// In place, column by column.
void whiten(const Whitening& whitening, Eigen::Ref<Eigen::MatrixXd> columns);

// ln of the density of u, and the weight with which u² counts in a fit: (ν + 1)/(ν + u²).
double log_density(double u, double tail);
inline double weight_of(double u, double tail) { return tail > 1e6 ? 1.0 : (tail + 1) / (tail + u * u); }

// The median of |x|, times 1.4826: the standard deviation of normal numbers, whatever a few wild ones are.
double robust_deviation(std::vector<double> numbers);

}  // namespace quern
