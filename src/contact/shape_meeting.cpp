#include "src/contact/shape_meeting.hpp"
#include "src/contact/kernels.hpp"

namespace quern {

ShapeMeetings shape_meetings(const Kernels& kernels) {
#if defined(__x86_64__)
  if (&kernels == &avx512::kernels) return {avx512::meet_shapes, avx512::find_gaps};
  if (&kernels == &avx2::kernels) return {avx2::meet_shapes, avx2::find_gaps};
#endif
  return {portable::meet_shapes, portable::find_gaps};
}

}  // namespace quern
