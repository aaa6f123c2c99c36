// A recording (CSV) for `quern diagnose`: of a body, a contact or a machine.
#include "fuzz/input.hpp"
#include "src/diagnose/machine/machine_recording.hpp"
#include "src/diagnose/recording.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("recording.csv");
  const std::string& path = file.holding(view(data, size));
  try_to([&] {
    if (is_machine_recording(path)) read_machine_recordings({path});
    else read_recordings({path});
  });
  return 0;
}
