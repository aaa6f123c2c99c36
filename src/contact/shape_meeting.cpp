#include "src/contact/shape_meeting.hpp"
#include "src/contact/kernels.hpp"

namespace quern {

ShapeMeetings shape_meetings(const Kernels& kernels) {
#if defined(__x86_64__)
  if (&kernels == &avx512::kernels) return {avx512::meet_shapes};
  if (&kernels == &avx2::kernels) return {avx2::meet_shapes};
#endif
  return {portable::meet_shapes};
}

}  // namespace quern
