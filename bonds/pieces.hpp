// Which members hang together: connected components of a graph that grows edge by edge.
#pragma once
#include <cstdint>
#include <numeric>
#include <vector>
#include "src/base/triple.hpp"

namespace quern {

class Pieces {
 public:
  explicit Pieces(std::size_t members) : parent_(members) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  // The member that stands for a piece: the lowest of it.
  Index of(Index member) {
    while (parent_[static_cast<std::size_t>(member)] != member) {
      Index& up = parent_[static_cast<std::size_t>(member)];
      up = parent_[static_cast<std::size_t>(up)];
      member = up;
    }
    return member;
  }
  void join(Index a, Index b) {
    a = of(a), b = of(b);
    if (a < b) parent_[static_cast<std::size_t>(b)] = a;
    else parent_[static_cast<std::size_t>(a)] = b;
  }
  std::int64_t count() {
    std::int64_t pieces = 0;
    for (std::size_t k = 0; k < parent_.size(); ++k) pieces += of(static_cast<Index>(k)) == static_cast<Index>(k);
    return pieces;
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace quern
