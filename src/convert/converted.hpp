// src/convert — inputs of other codes to cases. What has no plain meaning here is left out, and said.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct Converted {
  std::string text;                     // of the case, TOML
  std::vector<std::string> meshes;      // files that it names, which stand beside the input
  std::vector<std::string> left_out;    // a sentence each, with the line that it is about
};

// An input script of LIGGGHTS (material properties, particle templates, distributions, regions, insertion, walls, meshes and their motion,
// gravity, time). Throws InputError where it cannot be read.
Converted convert_liggghts(const std::string& file);

// Tables of materials and of what they do to each other (CSV), as EDEM shows them: `material`, density, shear_modulus or young, poisson; or
// `a`, `b`, restitution, static_friction, rolling_friction. Gives those tables of a case. Throws InputError.
Converted convert_materials(const std::vector<std::string>& files);

}  // namespace quern
