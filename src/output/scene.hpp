// The charge and its mill, frame by frame, as a page carries them: places to a 65000th of the room they take, speeds in 256 steps.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include "src/base/vec.hpp"

namespace quern {

struct SceneView {
  Vec3 forward, up;  // the way one looks at first, and what is up then
};

struct PackedScene {
  std::string description, bytes;      // JSON, and the numbers it tells of
  std::size_t shown = 0, saved = 0;    // frames
  std::size_t particles = 0;
  double first_time = 0, last_time = 0;  // [s]
};

// From the frames of a run, at most so many of them, evenly, that they fill `room` bytes before packing; none: the run has no frames.
// Throws RunError where frames cannot be read.
std::optional<PackedScene> pack_scene(const std::string& directory, const SceneView& view, std::size_t room = 5'000'000);

}  // namespace quern
