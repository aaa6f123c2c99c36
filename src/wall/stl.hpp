// STL files, text and binary: reading with check and repair, and writing.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include "src/wall/mesh.hpp"

namespace quern {

// What a file held and what became of it.
struct StlReport {
  std::size_t triangles = 0;         // read
  std::size_t merged_vertices = 0;   // corners that fell on one already there
  std::size_t degenerate = 0;        // triangles without area, removed
  std::size_t duplicate = 0;         // triangles there before, on either side; removed
  std::size_t turned = 0;            // triangles turned over so that neighbours agree on their side
  std::size_t open_edges = 0;        // edges with a triangle on one side only
  std::size_t crossings = 0;         // pairs of triangles without a common vertex that cross or touch
  bool closed = false;               // no open edges
  bool oriented = false;             // neighbours agree on their side after repair; false for a Möbius strip
  bool self_intersecting() const { return crossings > 0; }
};

// One line for a person: "1204 triangles, closed; 3 without area removed".
std::string describe(const StlReport& report);

// Reads a file and repairs it: merges equal vertices, drops triangles that have no area or come twice, turns neighbours to the same
// side. `scale` [m per unit of the file] takes it to metres. Throws InputError, naming the file (and the line of a text file), what
// was found and what is allowed.
Mesh read_stl(const std::filesystem::path& path, double scale, StlReport& report);

enum class StlFormat { text, binary };

// Writes a mesh in metres; text keeps all digits, binary has floats. Throws RunError if the file cannot be written.
void write_stl(const std::filesystem::path& path, const Mesh& mesh, StlFormat format = StlFormat::binary);

}  // namespace quern
