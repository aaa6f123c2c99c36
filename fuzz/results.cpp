// results.h5 of a run that goes on: the file itself (first byte even) or the journal of a killed process beside it (odd).
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include "fuzz/input.hpp"
#include "fuzz/small_run.hpp"
#include "src/output/results_file.hpp"

namespace {

void write(const std::string& path, std::string_view bytes) { std::ofstream(path, std::ios::binary) << bytes; }

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  using namespace quern;
  const SmallRun run;
  const std::string path = "/dev/shm/quern_fuzz_results_" + std::to_string(getpid());
  {
    ResultsFile results(path, run.simulation, "small", "case");
    results.append_frame(run.simulation);
  }
  std::ifstream written(path, std::ios::binary);
  plant("results", "0" + std::string(std::istreambuf_iterator<char>(written), {}));
  std::filesystem::remove(path);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static const std::string folder = [] {
    std::string name = (std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp") + std::string("/quern_fuzz_XXXXXX");
    if (mkdtemp(name.data()) == nullptr) std::abort();
    return name;
  }();
  if (size == 0) return 0;
  const std::string path = folder + "/results.h5";
  if (data[0] % 2 == 0) {
    write(path, view(data + 1, size - 1));
  } else {
    write(path, std::string(2000, '\0'));
    write(path + ".journal", view(data + 1, size - 1));
  }
  try_to([&] { ResultsFile::reopen(path, "case", 1, 6); });
  std::filesystem::remove(path + ".journal");
  return 0;
}
