#include "src/covering/next_region.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <vector>

namespace overtet {
namespace {

// Against a look at all of them.
TEST(NextRegion, IsWhatALookAtAllFinds) {
  const std::uint64_t seed = 17;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  struct One {
    bool in;
    double options;
    int changes;
  };
  for (const std::size_t n : {1u, 2u, 3u, 8u, 21u}) {
    NextRegion tree(n);
    EXPECT_TRUE(tree.none());
    std::vector<One> all(n, One{false, 0, 0});
    for (int step = 0; step < 2000; ++step) {
      const std::size_t i = random() % n;
      all[i] = {random() % 3 > 0, static_cast<double>(random() % (step % 100 < 50 ? 4 : 40)),
                static_cast<int>(random() % 3)};
      if (step % 100 < 90 && all[i].options == 0) all[i].options = 1;
      all[i].in ? tree.set(i, all[i].options, all[i].changes) : tree.take_out(i);
      std::size_t best = n;
      for (std::size_t k = 0; k < n; ++k) {
        if (!all[k].in || (best < n && all[best].options == 0)) continue;
        if (best == n || all[k].options < all[best].options ||
            (all[k].options == all[best].options && all[k].changes > all[best].changes))
          best = k;
      }
      ASSERT_EQ(best == n, tree.none());
      if (best == n) continue;
      ASSERT_EQ(best, tree.next());
      ASSERT_EQ(all[best].options == 0, tree.stuck());
    }
  }
}

}  // namespace
}  // namespace overtet
