// The two kinds of drawing, each into one PNG. Needs a display (hidden_display.hpp).
#pragma once
#include <string>
#include <vector>
#include "src/engine/simulation.hpp"
#include "src/output/chart.hpp"
#include "src/output/pictures.hpp"

namespace quern {

struct ChargePicture {
  const Simulation* simulation;
  Vec3 axis;                     // unit, towards the viewer
  std::string title, caption;
  std::vector<ShellMark> marks;
  Vec3 up = Vec3::Zero();        // zero: against gravity
  bool by_fragment = false;      // colours tell fragments apart instead of speeds; with bonds
  bool cut_open = false;         // without the particles nearer to the viewer than the middle of all
};

// Particles coloured by speed or fragment, seen along the axis. 1200 × 900. Throws RunError where the file cannot be written.
void draw_charge(const ChargePicture& picture, const std::string& path);

// 1200 × 900. Throws RunError where the file cannot be written.
void draw_chart(const Chart& chart, const std::string& path);

}  // namespace quern
