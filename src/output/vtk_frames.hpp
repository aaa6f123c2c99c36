// Frames for ParaView: frames/balls_N.vtp, frames/walls_N.vtp and, where there are bonds, frames/bonds_N.vtp, and frames.pvd that lists them against time.
#pragma once
#include <string>
#include <vector>
#include "src/engine/simulation.hpp"

namespace quern {

class VtkFrames {
 public:
  // `directory` of the run. Throws InputError where frames/ cannot be made there.
  explicit VtkFrames(std::string directory);

  // Writes this instant. Throws RunError where a file cannot be written.
  void append(const Simulation& simulation);

  // What has been written, for a checkpoint.
  template <class Archive>
  void archive(Archive& a) {
    a(entries_, fixed_walls_, frames_);
  }

 private:
  std::string directory_;
  std::string entries_;       // of frames.pvd
  std::string fixed_walls_;   // the one file of walls where none moves
  int frames_ = 0;
};

}  // namespace quern
