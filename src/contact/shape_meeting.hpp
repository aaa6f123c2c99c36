// Where two particles of other shapes than spheres touch that touched a step ago: eight pairs at once.
#pragma once
#include "src/contact/contact_block.hpp"

namespace quern {

struct Kernels;

// A particle where it stands, in rows for packs.
struct PosedShape {
  Quad axis[3];    // its own axes in the fixed frame; companions: 1/semi-axes [1/m]
  Quad centre;     // [m]; companion: radius of the ball of its volume [m]
  Quad exponents;  // n1, n2; companions not used
};

// What a contact of shapes remembers: three rows of ContactBlock::shaped to a slot.
inline constexpr Index shaped_rows = 3;  // normal and R*; the deepest place of the first body, of the second, each in the body's own axes [m]

struct KeptPair {
  Index first, second;  // rows of the poses
  Index slot;
};

struct Meeting {
  Quad normal;  // from the second body to the first; companion: overlap [m], negative once they are apart
  Quad arm;     // from the first body's centre to the contact; companion: 1, or 0 where there is no answer and the memory is as it was
};

// Two that did not touch, and the normal of a plane that may be between them, from the second to the first.
struct ParallelPlanes {
  Quad normal;
  Index first, second;  // rows of the poses
};

// Their places that are nearest along it, each in the body's own axes; companion of the first: how far they are apart, negative where
// they overlap [m].
struct Gap {
  Quad first, second;
};

// Newton's method in both deepest places, with the curvatures of both surfaces, which go smoothly to zero on faces: the places, the
// normals there and what joins them are brought onto one line. Places of the memory are brought up to date. No answer where a few steps
// do not lead there, or bodies are deep in each other.
struct ShapeMeetings {
  void (*meet)(const PosedShape* poses, const KeptPair* pairs, Index count, Quad* shaped, Meeting* meetings);
  void (*gaps)(const PosedShape* poses, const ParallelPlanes* pairs, Index count, Gap* gaps);
};

// For the instruction set of those kernels.
ShapeMeetings shape_meetings(const Kernels& kernels);

namespace portable {
void meet_shapes(const PosedShape*, const KeptPair*, Index, Quad*, Meeting*);
void find_gaps(const PosedShape*, const ParallelPlanes*, Index, Gap*);
}
namespace avx2 {
void meet_shapes(const PosedShape*, const KeptPair*, Index, Quad*, Meeting*);
void find_gaps(const PosedShape*, const ParallelPlanes*, Index, Gap*);
}
namespace avx512 {
void meet_shapes(const PosedShape*, const KeptPair*, Index, Quad*, Meeting*);
void find_gaps(const PosedShape*, const ParallelPlanes*, Index, Gap*);
}

}  // namespace quern
