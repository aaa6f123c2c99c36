// The state of a run on disk, from which it goes on bit for bit.
#pragma once
#include <string>
#include <string_view>
#include "src/base/archive.hpp"
#include "src/engine/simulation.hpp"

namespace quern {

// Everything of a started simulation that changes with time. What follows from the case (materials, laws, wall shapes, motions) is not
// stored: the simulation is built from the case again and started, and then takes this over.
void archive_state(ArchiveWriter& archive, Simulation& simulation);
void archive_state(ArchiveReader& archive, Simulation& simulation);

// Writes a file aside with a format version, its length and a checksum, syncs it and renames it over `path`; the checkpoint that was there
// is kept as path + ".previous". `identity` names the case that it belongs to. Throws WriteError where the disk is full or not writable.
void write_checkpoint(const std::string& path, const std::string& identity, std::string_view bytes);

struct Checkpoint {
  std::string file;            // all of it
  std::size_t begin = 0;       // of the state in it
  std::string_view bytes() const { return std::string_view(file).substr(begin); }
  std::string remark;  // where the newest could not be used: why, and that the one before it is; else empty
};

// The newest sound checkpoint of that case. Throws InputError: none there, or each torn, foreign or of another version, saying which.
Checkpoint read_checkpoint(const std::string& path, const std::string& identity);

// Removes the checkpoints of a run that has ended or begins anew.
void remove_checkpoints(const std::string& path);

}  // namespace quern
