// Files that are there whole or not at all: written aside, then renamed.
#pragma once
#include <initializer_list>
#include <string>
#include <string_view>

namespace quern {

// Makes a directory and those above it. Throws InputError where that is not possible or nothing can be written into it.
void make_directory(const std::string& path);

enum class Synced { no, yes };

// Replaces the file's contents with the pieces, one after the other. Throws WriteError where it cannot be written; an older file then
// stays as it was. Synced: what was written outlives a power cut.
void write_whole_file(const std::string& path, std::initializer_list<std::string_view> pieces, Synced synced = Synced::no);
inline void write_whole_file(const std::string& path, std::string_view contents) { write_whole_file(path, {contents}); }

// Puts a file in the place of another, lastingly. Throws WriteError.
void rename_file(const std::string& from, const std::string& to);

}  // namespace quern
