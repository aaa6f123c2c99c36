// The force of the charge on the mill's shell against time, and its amplitude spectrum.
#pragma once
#include "src/engine/simulation.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct AmplitudeSpectrum {
  std::vector<double> frequency;  // [Hz]
  std::vector<double> amplitude;  // of a sine of that frequency, in the units of the series
  double band_rms = 0;            // root mean square of the part of the series between the two frequencies
};

// Welch's (1967) average over segments of one second, half overlapping, Hann window, means taken off. The series holds averages over its
// interval [s]; what that averaging takes from high frequencies is given back.
AmplitudeSpectrum amplitude_spectrum(const std::vector<double>& series, double interval, double band_from, double band_to);

struct ShellForce {
  std::vector<double> time;        // ends of the intervals [s]
  std::vector<double> horizontal;  // mean over each interval, positive towards the 90 degree position [N]
  std::vector<double> vertical;    // positive upwards [N]
  double seconds = 0, horizontal_sum = 0, vertical_sum = 0, interval = 0;
  bool began = false;

  void see(const Simulation& simulation, const ObserverSettings& settings);
  // `from` [s]: begin of the steady state.
  std::vector<Headline> headlines(const ObserverSettings& settings, double from) const;
  std::vector<Table> tables(const ObserverSettings& settings, double from) const;

  template <class Archive>
  void archive(Archive& a) {
    a(time, horizontal, vertical, seconds, horizontal_sum, vertical_sum, interval, began);
  }

 private:
  std::vector<double> since(const std::vector<double>& series, double from) const;
};

}  // namespace quern
