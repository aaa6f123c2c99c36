#include "src/diagnose/finding.hpp"
#include <algorithm>
#include <cmath>

namespace quern {

const char* name_of(Verdict verdict) {
  constexpr const char* names[] = {"omitted_physics", "nothing_missing", "parameters_only", "unexplained", "insufficient_data"};
  return names[static_cast<int>(verdict)];
}

double as_experienced(double probability, bool two) {
  constexpr double surest = 0.9995;
  const double p = std::clamp(probability, 1 - surest, surest), odds = std::log(p / (1 - p));
  const double experienced = two ? 0.05 * odds + 0.5 : 0.19 * odds + 0.6;
  return 1 / (1 + std::exp(-experienced));
}

}  // namespace quern
