#include "src/immersion/vertex_link.h"

#include <gtest/gtest.h>

namespace overtet {
namespace {

// A vertex whose faces show as a square on a small sphere, covered twice inside and once outside. At each
// side one of the two copies inside goes on outside, and the other one ends. Where neighbouring sides differ
// in that, the edge between them turns once more than it shows. Two such edges make a disc that covers the
// sphere once and the square again; four make a handle, though every edge is right by itself.
TEST(VertexLink, HandlesAreNoDiscs) {
  constexpr int n = 4;
  const std::vector<Region> regions(n, Region{1, 2, {1}, {}, {}});
  for (int choice = 0; choice < 1 << n; ++choice) {
    std::vector<Gluing> gluings;
    std::vector<const Gluing*> chosen;
    for (int i = 0; i < n; ++i) {
      const bool second = choice >> i & 1;
      gluings.push_back({{second ? 1 : 0}, {second ? -1 : 0, second ? 0 : -1}});
    }
    for (const Gluing& g : gluings) chosen.push_back(&g);
    VertexLink link;
    link.winding = {1, 2};  // outside and inside
    link.rest = 1 + 2 - 2 * n;
    int turning = 0;
    for (Index i = 0; i < n; ++i) {
      const Index next = (i + 1) % n;
      link.arcs.push_back({i, false, 0, 1});
      const int turns = (choice >> i & 1) != (choice >> next & 1);
      turning += turns;
      const Fan fan{{{i, false, {0}}, {next, false, {0}}}, {{2, 3}, {0, 1}}, {{0, 0, 1, 0, turns}}};
      EXPECT_TRUE(satisfied(fan, chosen, regions));
      link.corners.push_back(fan);
    }
    EXPECT_EQ(makes_discs(link, chosen, regions), turning < 4) << choice;
  }
}

}  // namespace
}  // namespace overtet
