// A run that was broken off and taken up again ends bit for bit where the unbroken one ends; what is torn or foreign is refused.
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>
#include "src/base/error.hpp"
#include "src/engine/checkpoint.hpp"
#include "tests/scene.hpp"

using namespace quern;

namespace {

// Balls of two sizes tumbling in a turning periodic drum.
Simulation drum(int threads = 1) {
  const Material steel{"steel", 7800, 5e7, 0.3};
  PairLaw law = scene::hertz(steel, steel, 0.6, 0.5);
  law.rolling = {RollingModel::elastic_plastic, 0.02, 0.3};
  Simulation s = scene::free_space(steel, law, 2e-5);
  s.gravity = Vec3(0, -9.81, 0);
  s.domain.period[2] = 0.06;
  s.frames = {{"drum", -1, Rotating{Vec3::Zero(), Vec3::UnitZ(), 9.0}}};
  Wall shell;
  shell.surface = Revolved{0.05, -1, 0.05, 1, Revolved::Side::inside};
  shell.frame = 0;
  s.walls.push_back(shell);
  for (int x = -3; x <= 3; ++x)
    for (int y = -3; y <= 3; ++y)
      for (int z = 0; z < 5; ++z) scene::add_ball(s, {0.0101 * x + 1e-4 * z, 0.0101 * y, 0.012 * z}, (x + y) % 2 ? 0.005 : 0.0035, {0, 0, 0.1 * x});
  s.team = std::make_shared<ThreadTeam>(threads);
  return s;
}

void run(Simulation& s, int steps) {
  for (int k = 0; k < steps; ++k) s.step();
}

std::string pack_state(Simulation& s) {
  return ArchiveWriter::written_by([&](ArchiveWriter& a) { archive_state(a, s); });
}

bool same(Simulation& a, Simulation& b) { return pack_state(a) == pack_state(b); }

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("quern_checkpoint_" + std::to_string(::getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string file() const { return path / "checkpoint"; }
};

}  // namespace

TEST_CASE("a run taken up from its state goes on bit for bit, in the middle of contacts and with another number of threads") {
  Simulation unbroken = drum();
  unbroken.start(true);
  run(unbroken, 1500);
  const std::string state = pack_state(unbroken);
  run(unbroken, 1500);
  CHECK(unbroken.contacts.sums.pair_contacts > 20);
  for (const int threads : {1, 3}) {
    Simulation resumed = drum(threads);
    resumed.start(true);
    ArchiveReader reader(state);
    archive_state(reader, resumed);
    run(resumed, 1500);
    CHECK(std::memcmp(resumed.particles.position.data(), unbroken.particles.position.data(), unbroken.particles.position.size() * sizeof(Quad)) == 0);
    CHECK(same(resumed, unbroken));
  }
}

TEST_CASE("a torn, foreign or missing checkpoint is refused with a sentence and the one before it is used") {
  const Folder folder;
  const auto spoil = [&](auto change) {
    std::ifstream in(folder.file(), std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    std::string bytes = text.str();
    change(bytes);
    std::ofstream(folder.file(), std::ios::binary) << bytes;
  };
  CHECK_THROWS_WITH(read_checkpoint(folder.file(), "case"), Catch::Contains("no checkpoint"));
  write_checkpoint(folder.file(), "case", "first");
  CHECK(read_checkpoint(folder.file(), "case").bytes() == "first");
  CHECK_THROWS_WITH(read_checkpoint(folder.file(), "other"), Catch::Contains("another case"));
  write_checkpoint(folder.file(), "case", "second");
  CHECK(read_checkpoint(folder.file(), "case").bytes() == "second");

  const auto falls_back = [&](const char* why) {
    const Checkpoint found = read_checkpoint(folder.file(), "case");
    CHECK(found.bytes() == "first");
    CHECK_THAT(found.remark, Catch::Contains(why));
  };
  spoil([](std::string& b) { b[b.size() - 2] ^= 1; });  // a flipped bit
  falls_back("checksum");
  spoil([](std::string& b) { b.resize(b.size() / 2); });
  falls_back("torn");
  spoil([](std::string& b) { b[8] = 99; });  // the format version
  falls_back("format");
  spoil([](std::string& b) { b = "something else entirely, and long enough"; });
  falls_back("not a checkpoint");
  std::filesystem::remove(folder.file());
  falls_back("cannot be read");
}

TEST_CASE("a checkpoint that cannot be written says so and leaves the one before it") {
  CHECK_THROWS_WITH(write_checkpoint("/proc/quern/checkpoint", "case", "state"), Catch::Contains("cannot be written"));
  const Folder folder;
  write_checkpoint(folder.file(), "case", "first");
  std::filesystem::create_directory(folder.file() + ".new");  // where it would be written aside
  CHECK_THROWS_AS(write_checkpoint(folder.file(), "case", "second"), RunError);
  CHECK(read_checkpoint(folder.file(), "case").bytes() == "first");
}
