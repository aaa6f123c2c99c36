// Files that are there whole or not at all: written aside, then renamed.
#pragma once
#include <string>

namespace quern {

// Makes a directory and those above it. Throws InputError where that is not possible.
void make_directory(const std::string& path);

// Replaces the file's contents. Throws RunError where it cannot be written; an older file then stays as it was.
void write_whole_file(const std::string& path, const std::string& contents);

// A name beside `path` to write under, and the step from there to `path`.
std::string aside(const std::string& path);
void put_in_place(const std::string& path);

}  // namespace quern
