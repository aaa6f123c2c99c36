// An input script of LIGGGHTS for `quern convert`: what it becomes is TOML, whatever it says.
#include <toml++/toml.h>
#include <algorithm>
#include "fuzz/input.hpp"
#include "src/convert/converted.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("in.script");
  const std::string& path = file.holding(view(data, size));
  std::string text;
  try_to([&] { text = convert_liggghts(path).text; });
  // Names of files may stand in any alphabet, of which only whole letters are TOML.
  if (std::all_of(data, data + size, [](std::uint8_t c) { return c < 128; })) static_cast<void>(toml::parse(text));
  return 0;
}
