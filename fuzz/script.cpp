// An input script of LIGGGHTS for `quern convert`.
#include "fuzz/input.hpp"
#include "src/convert/converted.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("in.script");
  const std::string& path = file.holding(view(data, size));
  try_to([&] { convert_liggghts(path); });
  return 0;
}
