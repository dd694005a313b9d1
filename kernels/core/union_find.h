// Disjoint sets of the numbers 0 .. n-1 [Galler and Fischer 1964; path halving: Tarjan and van Leeuwen 1984].
//
// Every set is known by one of its numbers, its root. Which one that is follows from the calls alone: join()
// keeps the second set's root; where only join_smaller() is used, a root is the smallest number of its set.
// Calls may run at the same time when the sets they concern have no number in common.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include "overtet/types.h"

namespace overtet {

class UnionFind {
 public:
  UnionFind() = default;
  explicit UnionFind(std::size_t n) { reset(n); }

  // n sets of one number each. Memory is kept.
  void reset(std::size_t n) {
    up_.resize(n);
    std::iota(up_.begin(), up_.end(), 0);
  }

  std::size_t size() const { return up_.size(); }

  // Shortens the way for later calls.
  Index root(Index x) {
    while (up_[x] != x) x = up_[x] = up_[up_[x]];
    return x;
  }

  bool same(Index x, Index y) { return root(x) == root(y); }

  // One set of two; the root is root(y). Returns whether they were two.
  bool join(Index x, Index y) {
    x = root(x), y = root(y);
    up_[x] = y;
    return x != y;
  }

  // One set of two; the root is the smaller of the two. Returns whether they were two.
  bool join_smaller(Index x, Index y) {
    x = root(x), y = root(y);
    if (x < y)
      up_[y] = x;
    else
      up_[x] = y;
    return x != y;
  }

 private:
  std::vector<Index> up_;
};

}  // namespace overtet
