// Where the tests find the repository and the program; told to places.cpp alone, so that no other file must be compiled again elsewhere.
#pragma once

namespace quern {

extern const char* const source_directory;
extern const char* const program;

}  // namespace quern
