// Measured sizes for `quern grinding` and impacts for `quern breakage` (CSV), read to the study that is fitted.
#include "fuzz/input.hpp"
#include "src/case/breakage_input.hpp"
#include "src/case/grinding_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("study.csv");
  const std::string& path = file.holding(view(data, size));
  try_to([&] {
    GrindingRequest request;
    request.file = path;
    read_grinding(request);
  });
  try_to([&] {
    BreakageRequest request;
    request.source = path;
    read_breakage(request);
  });
  return 0;
}
