// The bonds and agglomerates of a case.
#pragma once
#include "src/case/case.hpp"
#include "src/case/values.hpp"

namespace quern {

// Reads [bond.*.*] and [agglomerate.*] into the case, whose species are read already. Throws InputError.
void read_agglomerates(const Values& v, Case& c);

}  // namespace quern
