#include "kernels/core/union_find.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace overtet {
namespace {

// Against labels that are all written anew at every join.
TEST(UnionFind, JoinsWhatLabelsJoin) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Index n = 50;
    UnionFind sets(n), smaller(n);
    std::vector<Index> label(n), least(n);
    for (Index i = 0; i < n; ++i) label[i] = least[i] = i;
    for (int step = 0; step < 60; ++step) {
      const Index x = static_cast<Index>(random() % n), y = static_cast<Index>(random() % n);
      const bool apart = label[x] != label[y];
      EXPECT_EQ(sets.join(x, y), apart);
      EXPECT_EQ(smaller.join_smaller(x, y), apart);
      // The second one's label stays, and the smaller one.
      const Index from = label[x], to = label[y], a = least[x], b = least[y];
      std::replace(label.begin(), label.end(), from, to);
      std::replace(least.begin(), least.end(), std::max(a, b), std::min(a, b));
      for (Index i = 0; i < n; ++i) {
        ASSERT_EQ(sets.root(i), label[i]);
        ASSERT_EQ(smaller.root(i), least[i]);
        ASSERT_EQ(sets.same(i, x), label[i] == label[x]);
      }
    }
  }
}

TEST(UnionFind, BeginsAgainAfterReset) {
  UnionFind sets(3);
  sets.join(0, 2);
  sets.reset(5);
  EXPECT_EQ(sets.size(), 5u);
  for (Index i = 0; i < 5; ++i) EXPECT_EQ(sets.root(i), i);
}

}  // namespace
}  // namespace overtet
