// A CSV table of a case (sizes, grains, balls), or one of materials for `quern convert`.
#include "fuzz/input.hpp"
#include "src/case/csv.hpp"
#include "src/convert/converted.hpp"
#include "src/particle/size_distribution.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static Bytes file("table.csv");
  const std::string& path = file.holding(view(data, size));
  try_to([&] {
    const NumberTable table = read_numbers(path);
    if (table.columns.size() == 2) SizeDistribution::table(table.columns[0], table.columns[1]);
  });
  try_to([&] { convert_materials({path}); });
  return 0;
}
