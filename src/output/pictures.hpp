// Pictures for papers: the charge as it stands, and charts of the tables. Drawn without a screen.
#pragma once
#include <string>
#include <vector>
#include "src/engine/simulation.hpp"
#include "src/observe/table.hpp"

namespace quern {

struct PictureRequest {
  std::string directory;
  std::string title;                // above every picture; may be empty
  Vec3 view_axis = Vec3::Zero();    // of charge.png; zero: found from the walls
  const Simulation* simulation = nullptr;  // none: no charge.png
  const std::vector<Table>* tables = nullptr;
  const std::vector<Headline>* headlines = nullptr;
};

struct Drawn {
  std::vector<std::string> files;    // relative to the directory
  std::vector<std::string> remarks;  // one plain sentence where pictures were skipped
};

// charge.png, and, where the tables for them are there, spectrum.png, power.png and energy.png. Never throws for want of a
// screen or of memory for it: says so in the remarks.
Drawn draw_pictures(const PictureRequest& request);

}  // namespace quern
