// The effects of a pair: what [pair.<a>.<b>] says beyond its law.
#pragma once
#include "src/case/case.hpp"
#include "src/case/values.hpp"

namespace quern {

// Reads them into pair.effects and refuses what the pair's law cannot do. `table`: "pair.default" or "pair.<a>.<b>".
void read_effects(const Values& v, const std::string& table, PairCase& pair);

// Adds what follows from the law: E*, its exponent, its restitution.
Extras extras_of(const PairCase& pair, const ContactLaw& law);

}  // namespace quern
