#include "src/immersion/vertex_link.h"

#include <algorithm>
#include "kernels/core/union_find.h"

namespace overtet {

namespace {

// Per copy in front of a facet, the copy behind it; negative where it ends.
const std::vector<int>& behind(const Gluing& gluing, bool flipped) {
  return flipped ? gluing.front_of : gluing.back_of;
}

// The points at which the corners of sectors meet around an edge: one for each turn that closes, and one for
// each sheet that passes.
int points_at(const Fan& fan, const std::vector<const Gluing*>& chosen, const std::vector<Region>& regions) {
  const int n = static_cast<int>(fan.leaves.size());
  // A corner lies between two sides of leaves, and bears the smaller one's number.
  std::vector<int> begin(2 * n, -1);
  int total = 0;
  for (int i = 0; i < 2 * n; ++i) {
    const int other = fan.arc[i / 2][i % 2];
    if (other < 0) continue;
    if (other < i) {
      begin[i] = begin[other];
      continue;
    }
    const Fan::Leaf& l = fan.leaves[i / 2];
    const Region& r = regions[l.region];
    begin[i] = total;
    total += (i % 2 == 0) != l.flipped ? r.front_winding : r.back_winding;
  }
  UnionFind classes(static_cast<std::size_t>(total));
  int points = total;
  for (int i = 0; i < n; ++i) {
    const Fan::Leaf& l = fan.leaves[i];
    const std::vector<int>& to = behind(*chosen[l.region], l.flipped);
    for (int copy = 0; copy < static_cast<int>(to.size()); ++copy)
      if (to[copy] >= 0 && classes.join(begin[2 * i] + copy, begin[2 * i + 1] + to[copy])) --points;
  }
  return points;
}

}  // namespace

bool makes_discs(const VertexLink& link, const std::vector<const Gluing*>& chosen,
                 const std::vector<Region>& regions) {
  std::vector<int> begin{0};
  for (const Index w : link.winding) begin.push_back(begin.back() + w);
  UnionFind classes(static_cast<std::size_t>(begin.back()));
  int surfaces = begin.back();
  std::vector<int> ending;  // copies at the border
  for (const VertexLink::Arc& arc : link.arcs) {
    const Gluing& gluing = *chosen[arc.region];
    const std::vector<int>&forth = behind(gluing, arc.flipped), &back = behind(gluing, !arc.flipped);
    for (int copy = 0; copy < static_cast<int>(forth.size()); ++copy) {
      if (forth[copy] < 0)
        ending.push_back(begin[arc.front] + copy);
      else if (classes.join(begin[arc.front] + copy, begin[arc.back] + forth[copy]))
        --surfaces;
    }
    for (int copy = 0; copy < static_cast<int>(back.size()); ++copy)
      if (back[copy] < 0) ending.push_back(begin[arc.back] + copy);
  }
  std::vector<char> bounded(static_cast<std::size_t>(begin.back()), 0);
  for (const int x : ending) bounded[classes.root(x)] = 1;
  const int discs = static_cast<int>(std::count(bounded.begin(), bounded.end(), 1));
  int euler = link.rest;
  for (const Fan& fan : link.corners) euler += points_at(fan, chosen, regions);
  // A sphere has 2, a disc 1, and everything else with a border less.
  return euler == 2 * (surfaces - discs) + discs;
}

}  // namespace overtet
