// What is known of a mill before it turns.
#pragma once
#include <vector>
#include "src/case/build.hpp"
#include "src/observe/table.hpp"

namespace quern {

// critical_speed, speed_fraction, filling, and what the classical models say of the power (see mills/power_models.hpp), each as far as its
// range reaches: power_hogg_fuerstenau (for a charge that leans at 40 degrees), power_morrell, power_bond. Of a planetary mill: disc_speed, vial_speed,
// critical_speed and speed_fraction of the vials, centrifugal_factor, filling. Empty without a mill.
std::vector<Headline> mill_headlines(const Case& c, const Built& built);

}  // namespace quern
