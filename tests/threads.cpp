// The team of threads: every block once, and what a block throws reaches the caller.
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>
#include "src/base/threads.hpp"

using namespace quern;

TEST_CASE("a team does every block once, whatever its size") {
  for (const int threads : {1, 2, 5}) {
    ThreadTeam team(threads);
    for (int round = 0; round < 200; ++round) {
      std::vector<int> done(37, 0);
      team.run(37, [&](int block) { ++done[static_cast<std::size_t>(block)]; });
      REQUIRE(done == std::vector<int>(37, 1));
    }
  }
}

TEST_CASE("what the first failing block throws reaches the caller, and the team goes on") {
  for (const int threads : {1, 2, 5}) {
    ThreadTeam team(threads);
    for (int round = 0; round < 50; ++round) {
      const auto fail_late = [](int block) {
        if (block >= 30) throw std::runtime_error("block " + std::to_string(block));
      };
      CHECK_THROWS_WITH(team.run(37, fail_late), "block 30");
      int sum = 0;
      team.run(1, [&](int) { ++sum; });
      CHECK(sum == 1);
    }
  }
}
