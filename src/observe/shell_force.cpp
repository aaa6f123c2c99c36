#include "src/observe/shell_force.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "src/observe/angles.hpp"
#include "src/observe/block_average.hpp"
#include "src/observe/torque_power.hpp"

namespace quern {

namespace {
constexpr double pi = 3.141592653589793;
}

AmplitudeSpectrum amplitude_spectrum(const std::vector<double>& series, double interval, double band_from, double band_to) {
  AmplitudeSpectrum result;
  const std::size_t length = std::min(series.size(), static_cast<std::size_t>(std::lround(1 / interval)));
  if (length < 8) return result;
  std::vector<double> window(length), mean_square(length / 2, 0.0);
  double window_sum = 0, window_squares = 0;
  for (std::size_t k = 0; k < length; ++k) {
    window[k] = 0.5 - 0.5 * std::cos(2 * pi * static_cast<double>(k) / static_cast<double>(length));
    window_sum += window[k];
    window_squares += window[k] * window[k];
  }
  Eigen::FFT<double> transform;
  std::size_t segments = 0;
  for (std::size_t start = 0; start + length <= series.size(); start += std::max<std::size_t>(1, length / 2), ++segments) {
    double mean = 0;
    for (std::size_t k = 0; k < length; ++k) mean += series[start + k] / static_cast<double>(length);
    std::vector<double> part(length);
    for (std::size_t k = 0; k < length; ++k) part[k] = window[k] * (series[start + k] - mean);
    std::vector<std::complex<double>> lines;
    transform.fwd(lines, part);
    for (std::size_t k = 0; k < mean_square.size(); ++k) mean_square[k] += std::norm(lines[k]);
  }
  double square_in_band = 0;
  const double resolution = 1 / (static_cast<double>(length) * interval);
  for (std::size_t k = 1; k < mean_square.size(); ++k) {
    const double frequency = static_cast<double>(k) * resolution;
    if (frequency < band_from || frequency > band_to) continue;
    const double averaging = pi * frequency * interval, lost = std::sin(averaging) / averaging;
    const double square = mean_square[k] / static_cast<double>(segments) / (lost * lost);
    result.frequency.push_back(frequency);
    result.amplitude.push_back(2 * std::sqrt(square) / window_sum);
    square_in_band += 2 * square / (window_squares * static_cast<double>(length));
  }
  result.band_rms = std::sqrt(square_in_band);
  return result;
}

void ShellForce::see(const Simulation& simulation, const ObserverSettings& settings) {
  const std::optional<MillView> view = settings.mill ? view_of(*settings.mill, simulation.gravity) : std::nullopt;
  if (!view) return;
  if (!began) {
    began = true;
    interval = std::max(settings.force_interval, simulation.clock.time_step);
    return;
  }
  const double dt = simulation.clock.time_step;
  const std::vector<int>& listed = settings.shell_walls.empty() ? settings.driven_walls : settings.shell_walls;
  for (std::size_t w = 0; w < simulation.walls.size(); ++w) {
    if (!is_driven(simulation, listed, w)) continue;
    const Vec3 force = vec(simulation.walls[w].force);
    horizontal_sum += dt * force.dot(view->ahead);
    vertical_sum += dt * force.dot(view->up);
  }
  seconds += dt;
  // Intervals follow the clock, not each other, so that their mean length is the one asked for.
  if (std::floor(simulation.clock.time() / interval + 1e-9) <= std::floor((simulation.clock.time() - dt) / interval + 1e-9)) return;
  time.push_back(simulation.clock.time());
  horizontal.push_back(horizontal_sum / seconds);
  vertical.push_back(vertical_sum / seconds);
  seconds = horizontal_sum = vertical_sum = 0;
}

std::vector<double> ShellForce::since(const std::vector<double>& series, double from) const {
  const auto first = std::lower_bound(time.begin(), time.end(), from) - time.begin();
  return {series.begin() + first, series.end()};
}

std::vector<Headline> ShellForce::headlines(const ObserverSettings& settings, double from) const {
  const std::vector<double> h = since(horizontal, from), v = since(vertical, from);
  if (h.empty()) return {};
  std::vector<double> size(h.size());
  for (std::size_t k = 0; k < h.size(); ++k) size[k] = std::hypot(h[k], v[k]);
  const BlockAverage mean = block_average(size), mean_h = block_average(h), mean_v = block_average(v);
  const AmplitudeSpectrum sh = amplitude_spectrum(h, interval, settings.band_from, settings.band_to);
  const AmplitudeSpectrum sv = amplitude_spectrum(v, interval, settings.band_from, settings.band_to);
  return {{"shell_force", mean.mean, "N", mean.ci95, "mean size of the charge's force on the shell"},
          {"shell_force_horizontal", mean_h.mean, "N", mean_h.ci95, "mean, positive towards the 90 degree position"},
          {"shell_force_vertical", mean_v.mean, "N", mean_v.ci95, "mean, positive upwards"},
          {"shell_force_peak", *std::max_element(size.begin(), size.end()), "N", std::nullopt, "largest size, averaged over one interval of shell_force.csv"},
          {"shell_force_band", std::hypot(sh.band_rms, sv.band_rms), "N", std::nullopt, "root mean square of the force within the spectrum's band"}};
}

std::vector<Table> ShellForce::tables(const ObserverSettings& settings, double from) const {
  if (time.empty()) return {};
  const AmplitudeSpectrum sh = amplitude_spectrum(since(horizontal, from), interval, settings.band_from, settings.band_to);
  const AmplitudeSpectrum sv = amplitude_spectrum(since(vertical, from), interval, settings.band_from, settings.band_to);
  return {{"shell_force",
           "force of the charge on the shell, averaged over the intervals that end at each time",
           {{"time", "s", "end of the interval", time, {}},
            {"horizontal", "N", "positive towards the 90 degree position", horizontal, {}},
            {"vertical", "N", "positive upwards", vertical, {}}}},
          {"shell_force_spectrum",
           "amplitude spectrum of the force on the shell in the steady state (Welch, Hann window, segments of one second)",
           {{"frequency", "Hz", "centre of the line", sh.frequency, {}},
            {"horizontal", "N", "amplitude", sh.amplitude, {}},
            {"vertical", "N", "amplitude", sv.amplitude, {}}}}};
}

}  // namespace quern
