// The machine behind a recording: the case under each condition, what a run of it shows of each channel, and the runs that were made.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>
#include "src/case/values.hpp"
#include "src/diagnose/experiment.hpp"
#include "src/diagnose/machine/machine_recording.hpp"

namespace quern {

// What one run shows.
struct Outcome {
  struct Number {
    double value = 0, deviation = 0;  // deviation 0: not known
  };
  struct Bin {
    std::string pair;
    double from = 0, to = 0;          // energy [J]
    double rate = 0, deviation = 0;   // [1/s]
  };
  bool sound = false;
  std::map<std::string, Number> numbers;  // headline numbers by name
  std::vector<Bin> bins;                  // of the collision spectrum, where it was asked for
};

struct WantedRun {
  Values values;
  std::string label;
};

// Runs cases and returns what each shows, in their order; runs that were made before are known again.
using CaseRunner = std::function<std::vector<Outcome>(const std::vector<WantedRun>& wanted)>;

// On which a channel is compared: rates by their natural logarithms, shares of a whole by arcsin √x, on which their scatter is alike everywhere (Bartlett 1936).
enum class Scale { linear, logarithm, share };

// One channel at all sites where it was recorded.
struct RecordedChannel {
  struct Site {
    std::size_t row;                  // of the recording
    double energy = 0;                // of a rate [J]
    double from = 0, to = 0;          // edges of its bin [J]
    double value = 0, deviation = 0;  // recorded, on the channel's scale; the mean of repeats; deviation 0: not known
  };
  std::string name, pair;             // pair: of a rate
  Scale scale = Scale::linear;
  std::vector<Site> sites;
  Eigen::MatrixXd coordinates;        // of the sites, for an emulator
  double scaled(double x) const;      // to the scale, and back
  double plain(double y) const;
  double stretch(double x) const;     // |∂ scaled/∂ x|
  std::string label() const { return pair.empty() ? name : name + " " + pair; }
};

class MachineExperiment {
 public:
  // Checks that the case can show what was recorded. Throws InputError.
  MachineExperiment(Values base, const MachineRecording& recording);

  const Values& base() const { return base_; }
  const MachineRecording& recording() const { return *recording_; }
  const std::vector<RecordedChannel>& channels() const { return channels_; }
  // Plain sentences: what was joined.
  const std::vector<std::string>& remarks() const { return remarks_; }
  // The condition that takes the most values, by which places are told; "" where there is only one.
  const std::string& leading_condition() const { return leading_; }

  // The case under the conditions of a row, with changes.
  Values values_of(std::size_t row, const Alteration& altered) const;
  // The same, less what nobody reads of a run that is only compared.
  Values compared(std::size_t row, const Alteration& altered) const;
  // Of how many packings, each with a seed of its own, a run is the mean: a mill forgets how it was filled, a body that breaks does not.
  int packings() const;
  // What the outcome of a run of that row shows at a site; false where it shows nothing.
  bool shown(const Outcome& outcome, const RecordedChannel& channel, const RecordedChannel::Site& site, double& value, double& deviation) const;

 private:
  Values base_;
  const MachineRecording* recording_;
  std::vector<RecordedChannel> channels_;
  std::string leading_;
  std::vector<std::string> remarks_;
};

}  // namespace quern
