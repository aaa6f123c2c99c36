// Sums over successive spans of time. Their number stays between half of `most` and `most`, however long the run: when there are too many,
// neighbours are joined and the spans double. So the beginning can still be dropped when the steady state is known, and the scatter
// between spans gives intervals.
#pragma once
#include <cstddef>
#include <vector>

namespace quern {

// Sums: default-made as nothing; has add(const Sums& later) and archive(Archive&).
template <class Sums>
struct TimeBlocks {
  struct Block {
    double from = 0;  // [s]
    double to = 0;    // of the last addition [s]
    Sums sums;
    template <class Archive>
    void archive(Archive& a) {
      a(from, to, sums);
    }
  };
  static constexpr std::size_t most = 40;
  double span = 0;  // of a block [s]; set before the first use
  std::vector<Block> blocks;

  // Whether an addition at this time begins a new block.
  bool due(double time) const { return blocks.empty() || time >= blocks.back().from + span * (1 - 1e-9); }
  // Begins a new block, joining the old ones when there are too many.
  Block& open(double time) {
    if (blocks.size() == most) {
      for (std::size_t k = 0; k < most / 2; ++k) {
        Block joined = blocks[2 * k];
        joined.sums.add(blocks[2 * k + 1].sums);
        joined.to = blocks[2 * k + 1].to;
        blocks[k] = std::move(joined);
      }
      blocks.resize(most / 2);
      span *= 2;
    }
    blocks.emplace_back();
    blocks.back().from = blocks.back().to = time;
    return blocks.back();
  }
  // The first block that begins at `time` or later, to the nearest step; at least the last half of them stays.
  std::size_t first_from(double time) const {
    std::size_t first = 0;
    while (first < blocks.size() / 2 && blocks[first].from < time - 0.01 * span) ++first;
    return first;
  }
  Sums total(std::size_t first) const {
    Sums sums;
    for (std::size_t k = first; k < blocks.size(); ++k) {
      if (k == first) sums = blocks[k].sums;
      else sums.add(blocks[k].sums);
    }
    return sums;
  }
  template <class Archive>
  void archive(Archive& a) {
    a(span, blocks);
  }
};

}  // namespace quern
