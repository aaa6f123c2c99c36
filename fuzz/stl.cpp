// An STL file, text or binary, with its check and repair.
#include "fuzz/input.hpp"
#include "src/wall/stl.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("mesh.stl");
  const std::string& path = file.holding(view(data, size));
  try_to([&] {
    StlReport report;
    read_stl(path, 1e-3, report);
    describe(report);
  });
  return 0;
}
