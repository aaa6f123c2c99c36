// A case file (TOML), read to its end; overrides stand after a line of "%%".
#include "fuzz/input.hpp"
#include "src/case/case.hpp"
#include "src/case/values.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  std::string text(view(data, size));
  std::vector<std::string> overrides;
  if (const std::size_t mark = text.find("\n%%\n"); mark != text.npos) {
    std::string rest = text.substr(mark + 4);
    text.resize(mark);
    for (std::size_t end; (end = rest.find('\n')) != rest.npos && overrides.size() < 8; rest.erase(0, end + 1)) overrides.push_back(rest.substr(0, end));
  }
  try_to([&] { named_case_of(read_values_in(text, "/nowhere/case.toml", overrides)); });
  return 0;
}
