// A checkpoint: as a file (first byte even), or as the state that a file with the right checksum holds (odd), which then must step and be observed
// to the end.
#include "fuzz/input.hpp"
#include "fuzz/small_run.hpp"
#include "src/engine/checkpoint.hpp"
#include "src/observe/soundness.hpp"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  using namespace quern;
  SmallRun run;
  for (int k = 0; k < 300; ++k) {
    run.simulation.step();
    run.observers.see(run.simulation);
  }
  const std::string state = ArchiveWriter::written_by([&](ArchiveWriter& a) {
    archive_state(a, run.simulation);
    a(run.observers);
  });
  plant("state", "1" + state);
  const std::string file = "/dev/shm/quern_fuzz_checkpoint_" + std::to_string(getpid());
  write_checkpoint(file, run.read.text, "state");
  std::ifstream written(file, std::ios::binary);
  plant("file", "0" + std::string(std::istreambuf_iterator<char>(written), {}));
  remove_checkpoints(file);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quern;
  static const SmallRun start;
  static Bytes file("checkpoint");
  if (size == 0) return 0;
  const std::string_view bytes = view(data + 1, size - 1);
  if (data[0] % 2 == 0) {
    const std::string& path = file.holding(bytes);
    try_to([&] { read_checkpoint(path, start.read.text); });
    return 0;
  }
  Simulation simulation = start.simulation;
  Observers observers = start.observers;
  try_to([&] {
    ArchiveReader reader(bytes);
    archive_state(reader, simulation);
    reader(observers);
    if (!sound(observers, simulation)) return;
    // What takes its rows by the clock would take very many after very long.
    constexpr std::int64_t few = 1'000'000;
    if (simulation.clock.step > few) return;
    simulation.step();
    observers.see(simulation);
    observers.finish(simulation);
    observers.headlines();
    observers.tables();
  });
  return 0;
}
