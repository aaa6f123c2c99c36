// The equation of each effect of the catalogue, as docs/effects.md has it, for those who read a report.
#pragma once
#include <string>
#include <vector>

namespace quern {

struct EffectEquation {
  std::string equation;  // in plain characters
  std::string where;     // its symbols
};

// Of one form of an effect where a key of the case tells it, otherwise of the effect; empty where there is none.
EffectEquation equation_of(const std::string& effect, const std::vector<std::string>& keys = {});

}  // namespace quern
