// src/output — runs a simulation to its end and writes what came of it: HDF5, VTK, CSV, JSON, pictures, report. No physics.
//
// The run loop: step, tell the observers, sample the ledger, write frames, show progress, and at the end the summary.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>
#include "src/base/vec.hpp"
#include "src/case/echo.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct Simulation;
struct Observers;

// What a case asks to have written.
struct OutputSettings {
  std::string name;                 // of the case
  std::string title;                // one line for people; may be empty
  std::string case_text;            // the complete case as run, TOML
  std::vector<NamedFile> case_files;  // copied beside it
  double frame_interval = 0;        // between frames for ParaView and in results.h5 [s]; 0: the first and the last state alone
  double energy_interval = 0;       // between rows of energy.csv [s]; 0: a thousandth of the run
  bool vtk_frames = true;           // frames/*.vtp
  bool trajectory = true;           // /particles of results.h5
  bool pictures = true;             // *.png
  std::vector<double> stages;       // ascending times [s] at which stage_1.png, stage_2.png … are drawn
  Vec3 view_axis = Vec3::Zero();    // from which the charge is seen: along a mill's axis; zero: found from the walls
  std::vector<Headline> headlines;  // known before the run (critical_speed …), copied into summary.json
};

// What the person at the keyboard asks for.
struct RunOptions {
  std::string directory;                          // made if it is not there
  int threads = 0;                                // 0: leave the simulation's team as it is
  bool resume = false;                            // go on from the checkpoint in the directory
  double checkpoint_interval = 300;               // between checkpoints [s] of wall clock; one is written at a stop signal too
  bool quiet = false;                             // no progress on stderr
  const std::atomic<int>* stop_signal = nullptr;  // once it is not 0, the run finishes its step, writes what there is and returns
};

struct RunSummary {
  bool finished = false;             // false: stopped by a signal
  int stopped_by = 0;                // that signal
  double time = 0;                   // reached [s]
  std::int64_t steps = 0;            // of this call
  double wall_clock = 0;             // [s]
  std::vector<Headline> headlines;   // as in summary.json
  std::vector<std::string> files;    // written, relative to the directory
  std::vector<std::string> remarks;  // plain sentences for the user: a picture that could not be drawn …
};

// Runs a simulation that has been started (Simulation::start) until its clock shows `duration` [s], and writes the results into
// options.directory. Throws RunError where the run fails, after writing what there is: a number that is not finite, a particle
// that left the walls, energy out of nothing. Throws InputError where the directory cannot be written, or where there is no sound
// checkpoint of this very case to go on from.
RunSummary run_simulation(Simulation& simulation, Observers& observers, const OutputSettings& settings, const RunOptions& options,
                          double duration);

}  // namespace quern
