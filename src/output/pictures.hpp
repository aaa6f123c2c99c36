// Pictures for papers: the charge as it stands, and charts of the tables. Drawn without a screen.
#pragma once
#include <string>
#include <vector>
#include "src/engine/simulation.hpp"
#include "src/observe/table.hpp"
#include "src/output/chart.hpp"

namespace quern {

// A direction from the mill's axis to mark on the shell.
struct ShellMark {
  std::string label;
  Vec3 direction;  // unit, across the axis
};

struct PictureRequest {
  std::string directory;
  std::string title;              // above every picture; may be empty
  Vec3 view_axis = Vec3::Zero();  // of charge.png, towards the viewer; zero: found from the walls
  const Simulation* simulation = nullptr;  // none: no charge.png
  std::vector<ShellMark> marks;
  std::vector<Table> tables;
  std::vector<Headline> headlines;
  std::vector<Chart> charts = {}; // further ones
  Vec3 view_up = Vec3::Zero();    // of charge.png; zero: against gravity
  std::string of;                 // what of the mill charge.png shows; empty: all
};

struct Drawn {
  std::vector<std::string> files;    // relative to the directory
  std::vector<std::string> remarks;  // one plain sentence where pictures were skipped
};

// charge.png, with bonds fragments.png too, and, where the tables for them are there, spectrum.png, convergence.png, power.png, loading.png, discharge.png,
// energy.png and damage.png. Where they cannot be drawn, a remark says so; a run does not fail for a picture.
Drawn draw_pictures(const PictureRequest& request);

// The charge now, as stage_<number>.png; where grains are bonded by fragment, and cut open halfway along the view.
Drawn draw_stage(const PictureRequest& request, int number);

}  // namespace quern
