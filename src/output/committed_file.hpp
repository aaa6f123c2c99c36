// A file of HDF5 that goes from one whole state to the next: HDF5 writes through here (as a virtual file driver), and what it writes over
// is kept back until commit(). Handles are those of HDF5 (hid_t).
#pragma once
#include <cstdint>
#include <string>

namespace quern {

// Makes a property list for file access choose this driver.
void use_commits(std::int64_t access);

// Puts in force what was written since the last commit; call after H5Fflush. The room is taken from the disk first, then the changes are
// written into path + ".journal", then made, and then the journal is removed. A process killed before the changes begin leaves the state
// before; one killed amidst them leaves a journal. False: not possible, and nothing was changed; last_system_error() says why.
bool commit(std::int64_t file);

// Commits, and what was committed outlives a power cut.
bool commit_and_sync(std::int64_t file);

// From here on nothing is written any more, closing included: the last committed state stays.
void abandon(std::int64_t file);

// The errno of the last call that the system refused; 0: none since forget_system_error().
int last_system_error();
void forget_system_error();

// Ends what a killed process had begun: makes the changes of a journal that was left, if there is one. Throws WriteError.
void recover(const std::string& path);

}  // namespace quern
