// The mean of a series of correlated measurements and how well it is known.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace quern {

struct BlockAverage {
  double mean = 0;
  double standard_error = 0;              // of the mean
  std::optional<std::array<double, 2>> ci95;  // none where the series is too short to tell
  std::size_t block = 1;                  // samples per block at which the error stops growing
  std::size_t blocks = 0;
  bool settled = false;                   // whether blocks could be found that are free of correlation
};

// Block averages (Flyvbjerg & Petersen 1989, J. Chem. Phys. 91:461): neighbours are averaged in pairs until the blocks no longer show
// correlation, judged by the test of Jonsson (2018, Phys. Rev. E 98:043304) at 70 %; a positive correlation left between neighbours widens
// the error by √((1 + ρ)/(1 − ρ)). The interval takes Student's t with the number of blocks that are left.
BlockAverage block_average(const std::vector<double>& series);

// Where the steady state begins: index of its first sample, by MSER-5 (White 1997, Simulation 69:323; Spratt 1998): of all truncations in the
// first half, the one with the least marginal standard error over batch means of five samples.
std::size_t steady_start(const std::vector<double>& series);

// The block average of what follows steady_start.
BlockAverage steady_average(const std::vector<double>& series);

// The exact 95 % interval of a Poisson mean of which `count` events were seen (Garwood 1936).
std::array<double, 2> poisson_interval(double count);

}  // namespace quern
