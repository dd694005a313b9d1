// A binary tree of boxes over a fixed set of items, for all pairs of overlapping boxes.
//
// Built once from the boxes at hand, refitted when they move (refitting keeps the answer exact; only the
// speed depends on how well the tree still fits). Results are listed in an order that depends on the tree
// alone: the same on any number of threads.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "overtet/types.h"

namespace overtet {

struct Box {
  double low[3], high[3];

  void grow(double margin) {
    for (int k = 0; k < 3; ++k) low[k] -= margin, high[k] += margin;
  }
  void include(const Box& other) {
    for (int k = 0; k < 3; ++k) {
      low[k] = other.low[k] < low[k] ? other.low[k] : low[k];
      high[k] = other.high[k] > high[k] ? other.high[k] : high[k];
    }
  }
  // Closed boxes: touching counts.
  bool overlaps(const Box& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] &&
           other.low[1] <= high[1] && low[2] <= other.high[2] && other.low[2] <= high[2];
  }
};

struct IndexPair {
  Index a, b;
  friend bool operator==(const IndexPair&, const IndexPair&) = default;
  friend auto operator<=>(const IndexPair&, const IndexPair&) = default;
};

class BoxTree {
 public:
  BoxTree() = default;
  // One box per item. pre: finite.
  explicit BoxTree(std::span<const Box> boxes) { build(boxes); }
  void build(std::span<const Box> boxes);
  // pre: as many boxes as at the last build.
  void refit(std::span<const Box> boxes);

  Index size() const { return static_cast<Index>(item_.size()); }

  // Pairs (i, j), i < j, of items whose boxes overlap: each once. In parallel.
  std::vector<IndexPair> self_pairs() const;
  // Pairs (i of this tree, j of the other one). In parallel.
  std::vector<IndexPair> pairs_with(const BoxTree& other) const;

 private:
  // Children follow their parent; a leaf holds items item_[first .. first + count).
  struct Node {
    Box box;
    Index left = -1, right = -1;  // left < 0: leaf
    Index first = 0, count = 0;
  };
  Index split(Index first, Index count, const std::vector<Eigen::Vector3d>& centre);
  void self(Index node, std::vector<IndexPair>& out) const;
  void cross(Index node, const BoxTree& other, Index other_node, bool same,
             std::vector<IndexPair>& out) const;

  std::vector<Node> node_;
  std::vector<Index> item_;
  std::vector<Box> box_;  // by position in item_
};

}  // namespace overtet
