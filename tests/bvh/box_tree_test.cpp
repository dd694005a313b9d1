#include "kernels/bvh/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace overtet {
namespace {

constexpr unsigned kTreeSeed = 2024;
using Pair = std::pair<Index, Index>;

// What floats may add to a box on each side.
constexpr double kRounding = 1e-6;

enum class Spread { even, clustered, one_place };

std::vector<Box> random_boxes(int n, Spread spread, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Box> boxes(n);
  for (Box& b : boxes) {
    // Clustered: at distances from 1 down to 1e-12 of the origin, so that many share a cell of the grid.
    const double scale = spread == Spread::clustered ? std::pow(10, -12 * unit(random)) : 1;
    for (int k = 0; k < 3; ++k) {
      b.low[k] = spread == Spread::one_place ? 0.5 : scale * unit(random);
      b.high[k] = b.low[k] + (spread == Spread::one_place ? 0 : 2 * scale * unit(random) / std::cbrt(n));
    }
  }
  return boxes;
}

Box grown(Box b) {
  b.grow(kRounding);
  return b;
}

// Every pair that must be found was found, each once, and nothing that is far away.
void expect_pairs(const std::vector<Box>& a, const std::vector<Box>& b, bool self, std::vector<Pair> found) {
  std::sort(found.begin(), found.end());
  EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end()) << "a pair came twice";
  std::size_t at = 0;
  for (Index i = 0; i < static_cast<Index>(a.size()); ++i)
    for (Index j = self ? i + 1 : 0; j < static_cast<Index>(b.size()); ++j) {
      const bool here = at < found.size() && found[at] == Pair{i, j};
      at += here;
      if (a[i].overlaps(b[j])) {
        ASSERT_TRUE(here) << i << ", " << j << " is missing";
      }
      if (here) {
        ASSERT_TRUE(grown(a[i]).overlaps(grown(b[j]))) << i << ", " << j << " are far from each other";
      }
    }
  EXPECT_EQ(at, found.size());
}

std::vector<Pair> self_pairs(const BoxTree& tree) {
  return tree.collect_self_pairs<Pair>(
      [](Index i, Index j, std::vector<Pair>& out) { out.emplace_back(i, j); });
}

TEST(BoxTree, PairsAreThoseOfBruteForceOnAnyThreadsAlsoAfterARefit) {
  SCOPED_TRACE(kTreeSeed);
  std::mt19937 random(kTreeSeed);
  for (const Spread spread : {Spread::even, Spread::clustered, Spread::one_place})
    for (const int n : {0, 1, 2, 16, 17, 100, 700, 5000}) {
      if (spread == Spread::one_place && n > 700) continue;
      std::vector<Box> a = random_boxes(n, spread, random);
      const std::vector<Box> b = random_boxes(n / 3 + 1, spread, random);
      for (const int round : {0, 1}) {
        std::vector<Pair> first_self, first_mixed;
        for (const int threads : {1, 2, 8}) {
          const ScopedThreads scope(threads);
          BoxTree tree, other;
          tree.build(a);
          other.build(b);
          std::vector<Box> now = a;
          if (round == 1) {
            now = random_boxes(n, spread, random);
            if (threads > 1) continue;
            tree.refit(now);
          }
          const auto self = self_pairs(tree);
          const auto mixed = tree.collect_pairs<Pair>(
              other, [](Index i, Index j, std::vector<Pair>& out) { out.emplace_back(i, j); });
          if (threads == 1) {
            first_self = self;
            first_mixed = mixed;
            expect_pairs(now, now, true, self);
            expect_pairs(now, b, false, mixed);
          }
          EXPECT_EQ(self, first_self);
          EXPECT_EQ(mixed, first_mixed);
        }
      }
    }
}

TEST(BoxTree, LargeTreesAreTheSameOnAnyThreads) {
  std::mt19937 random(kTreeSeed + 1);
  const std::vector<Box> boxes = random_boxes(150000, Spread::even, random);
  std::vector<Pair> pairs;
  std::vector<Index> order;
  for (const int threads : {1, 2, 5}) {
    const ScopedThreads scope(threads);
    BoxTree tree;
    tree.build(boxes);
    const auto found = self_pairs(tree);
    const std::vector<Index> found_order(tree.order().begin(), tree.order().end());
    if (threads == 1) pairs = found, order = found_order;
    EXPECT_TRUE(found == pairs);
    EXPECT_TRUE(found_order == order);
  }
  EXPECT_GT(pairs.size(), 1000u);
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (Index i = 0; i < static_cast<Index>(sorted.size()); ++i) ASSERT_EQ(sorted[i], i);
}

TEST(BoxTree, OnlyPairsWithAnActiveItem) {
  std::mt19937 random(kTreeSeed + 2);
  const std::vector<Box> boxes = random_boxes(900, Spread::clustered, random);
  std::vector<std::uint8_t> active(boxes.size());
  for (std::size_t i = 0; i < active.size(); ++i) active[i] = i % 11 == 0;
  BoxTree tree;
  tree.build(boxes);
  std::vector<Pair> want;
  for (const Pair& p : self_pairs(tree))
    if (active[p.first] || active[p.second]) want.push_back(p);
  tree.set_active(active);
  EXPECT_EQ(self_pairs(tree), want);
  tree.set_active({});
  EXPECT_GT(self_pairs(tree).size(), want.size());
}

// Whether the ray meets the box, decided with a margin: 1 yes, 0 no, -1 too close to call.
int meets(const Box& box, const double* o, const double* d) {
  int out[2];
  for (const int pass : {0, 1}) {
    const double margin = pass == 0 ? -1e-12 : 1e-5;
    double near = 0, far = HUGE_VAL;
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
      const double lo = box.low[k] - margin - o[k], hi = box.high[k] + margin - o[k];
      if (d[k] == 0) {
        inside = inside && lo <= 0 && hi >= 0;
        continue;
      }
      near = std::max(near, std::min(lo / d[k], hi / d[k]));
      far = std::min(far, std::max(lo / d[k], hi / d[k]));
    }
    out[pass] = inside && near <= far;
  }
  return out[0] == out[1] ? out[0] : out[0] == 1 ? 1 : -1;
}

TEST(BoxTree, QueriesMissNothing) {
  SCOPED_TRACE(kTreeSeed);
  std::mt19937 random(kTreeSeed + 3);
  std::uniform_real_distribution<double> unit(-0.2, 1.2);
  for (const Spread spread : {Spread::even, Spread::clustered}) {
    const std::vector<Box> boxes = random_boxes(3000, spread, random);
    BoxTree tree;
    tree.build(boxes);
    int hits = 0, surplus = 0;
    for (int trial = 0; trial < 300; ++trial) {
      double o[3], d[3];
      Box box;
      for (int k = 0; k < 3; ++k) {
        o[k] = unit(random);
        d[k] = trial % 3 == 0 && k != trial % 2 ? 0 : unit(random) - 0.5;
        if (trial % 5 == 0) d[k] *= 1e-200;
        if (trial % 7 == 0) d[k] *= 1e150;
        box.low[k] = unit(random);
        box.high[k] = box.low[k] + 0.2 * std::fabs(unit(random));
      }
      if (trial % 4 == 0) std::copy(boxes[trial].low, boxes[trial].low + 3, o);
      std::set<Index> in_box, on_ray;
      tree.query_box(box.low, box.high, [&](Index i) { EXPECT_TRUE(in_box.insert(i).second); });
      tree.query_ray(o, d, 0, [&](Index i) { EXPECT_TRUE(on_ray.insert(i).second); });
      for (Index i = 0; i < static_cast<Index>(boxes.size()); ++i) {
        if (boxes[i].overlaps(box)) {
          ASSERT_TRUE(in_box.contains(i));
        } else if (in_box.contains(i)) {
          ASSERT_TRUE(grown(boxes[i]).overlaps(box));
        }
        const int hit = meets(boxes[i], o, d);
        if (hit == 1) {
          ASSERT_TRUE(on_ray.contains(i)) << "trial " << trial;
          ++hits;
        }
        surplus += hit == 0 && on_ray.contains(i);
      }
    }
    EXPECT_GT(hits, 200);
    EXPECT_EQ(surplus, 0);
  }
}

TEST(BoxTree, NothingIsMissedBeyondTheRangeOfFloats) {
  for (const double scale : {1e-300, 1e-40, 1e37, 1e300}) {
    std::vector<Box> boxes;
    for (int i = 0; i < 100; ++i) {
      const double x = scale * i;
      boxes.push_back({{x, x, x}, {x + 1.5 * scale, x + 1.5 * scale, x + 1.5 * scale}});
    }
    BoxTree tree;
    tree.build(boxes);
    const auto pairs = self_pairs(tree);
    for (Index i = 0; i + 1 < 100; ++i)
      EXPECT_TRUE(std::find(pairs.begin(), pairs.end(), Pair{i, i + 1}) != pairs.end());
    const double o[3] = {-scale, -scale, -scale}, d[3] = {1, 1, 1};
    int seen = 0;
    tree.query_ray(o, d, 0, [&](Index) { ++seen; });
    EXPECT_EQ(seen, 100);
  }
}

}  // namespace
}  // namespace overtet
