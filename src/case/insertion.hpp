// Putting a case's particles and agglomerates into a simulation that has its walls.
#pragma once
#include <string>
#include <utility>
#include <vector>
#include "src/case/case.hpp"
#include "src/engine/simulation.hpp"

namespace quern {

// Of all vials of a planetary mill together; 0 without a mill [m³].
double mill_volume(const Case& c);

// Adds all particles and bonds. Returns what a body of each agglomerate is like. Throws InputError where they do not fit or overlap.
std::vector<std::pair<std::string, BodyReport>> insert_particles(const Case& c, Simulation& s);

}  // namespace quern
