// A complete case as it stands elsewhere, with copies of the files that it names, so that it can be moved and run again.
#pragma once
#include <string>
#include <vector>

namespace quern {

class Values;

struct NamedFile {
  std::string from;  // absolute
  std::string name;  // of the copy, relative to the echo: files/vial_1a2b3c4d.stl, where the number follows from its contents
};

// The complete case (complete_case in src/case/values.hpp) with its files by the names of their copies, which are added to `files`.
std::string echo_of(Values values, std::vector<NamedFile>& files);

// Makes the copies in a directory that exists. Throws WriteError where that is not possible.
void copy_files(const std::vector<NamedFile>& files, const std::string& directory);

// Writes the echo into a file, after the lines of a heading, and the copies beside it. Returns what was written.
std::string write_echo(const std::string& file, const std::string& heading, const Values& values);

}  // namespace quern
