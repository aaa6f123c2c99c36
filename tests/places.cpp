#include "tests/places.hpp"

namespace quern {

const char* const source_directory = QUERN_SOURCE_DIR;
const char* const program = QUERN_PROGRAM;

}  // namespace quern
