#include "src/immersion/edge_fan.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace overtet {

double count_gluings(const Region& region, Named named) {
  double plus = 0, minus = 0;
  for (const int sign : region.signs) ++(sign > 0 ? plus : minus);
  const double front = region.front_winding, back = region.back_winding, matched = back - plus;
  if (matched < 0 || matched != front - minus) return 0;
  const auto factorial = [](double n) { return std::tgamma(n + 1); };
  if (named == Named::back) return factorial(front) / factorial(matched);
  if (named == Named::front) return factorial(back) / factorial(matched);
  return factorial(front) * factorial(back) / factorial(matched);
}

void enumerate_gluings(const Region& region, Named named, std::deque<Gluing>& out) {
  if (count_gluings(region, named) == 0) return;
  const int front = region.front_winding, back = region.back_winding;
  std::vector<int> plus, minus;
  for (int s = 0; s < static_cast<int>(region.signs.size()); ++s)
    (region.signs[s] > 0 ? plus : minus).push_back(s);
  Gluing gluing{std::vector<int>(front, -100), std::vector<int>(back, -100)};
  const std::function<void(int)> place_matched = [&](int f) {
    while (f < front && gluing.back_of[f] != -100) ++f;
    if (f >= front) return out.push_back(gluing);
    for (int b = 0; b < back; ++b) {
      if (gluing.front_of[b] != -100) continue;
      gluing.back_of[f] = b, gluing.front_of[b] = f;
      place_matched(f + 1);
      gluing.back_of[f] = -100, gluing.front_of[b] = -100;
      if (named != Named::neither) break;  // in order
    }
  };
  // The slots of a named side take its last copies.
  const auto place = [&](auto&& self, const std::vector<int>& slots, std::size_t i, std::vector<int>& side,
                         bool last, const std::function<void()>& next) -> void {
    if (i == slots.size()) return next();
    const int n = static_cast<int>(side.size()), first = last ? n - static_cast<int>(slots.size() - i) : 0;
    for (int c = first; c < n; ++c) {
      if (side[c] != -100) continue;
      side[c] = -1 - slots[i];
      self(self, slots, i + 1, side, last, next);
      side[c] = -100;
      if (last) break;
    }
  };
  place(place, plus, 0, gluing.front_of, named == Named::back,
        [&] { place(place, minus, 0, gluing.back_of, named == Named::front, [&] { place_matched(0); }); });
}

bool satisfied(const Fan& fan, const std::vector<const Gluing*>& chosen, const std::vector<Region>& regions,
               int turns_wanted) {
  const int n = static_cast<int>(fan.leaves.size());
  // Copy `copy` in the cell on `side` of a leaf crosses the leaf: (other side's copy) or -1 - local sheet.
  const auto cross = [&](int leaf, int side, int copy) {
    const Fan::Leaf& l = fan.leaves[leaf];
    const Gluing& gluing = *chosen[l.region];
    const bool from_front = (side == 0) != l.flipped;
    const int to = from_front ? gluing.back_of[copy] : gluing.front_of[copy];
    if (to >= 0) return to;
    const auto local = std::find(l.slots.begin(), l.slots.end(), -1 - to);
    return -1 - static_cast<int>(local - l.slots.begin());
  };
  const auto copies = [&](int leaf, int side) {
    const Fan::Leaf& l = fan.leaves[leaf];
    const Region& r = regions[l.region];
    return static_cast<int>((side == 0) != l.flipped ? r.front_winding : r.back_winding);
  };
  // visited[leaf][copy on its front side] for sheets that cross the leaf
  std::vector<std::vector<char>> visited(n);
  for (int i = 0; i < n; ++i) visited[i].assign(copies(i, 0), 0);
  const int most_steps = 64 * n + 64;
  for (const Fan::Pass& pass : fan.passes) {
    // Both directions are listed or one: start inside the solid at `from`.
    const Fan::Leaf& l = fan.leaves[pass.from];
    const Region& r = regions[l.region];
    const Index slot = l.slots[pass.from_sheet];
    const bool inside_is_back = (r.signs[slot] > 0) != l.flipped;
    int side = inside_is_back ? 1 : 0, leaf = pass.from, copy = -1;
    const Gluing& gluing = *chosen[l.region];
    const auto& ends = r.signs[slot] > 0 ? gluing.front_of : gluing.back_of;
    for (int c = 0; c < static_cast<int>(ends.size()); ++c)
      if (ends[c] == -1 - slot) copy = c;
    int turns = 0;
    for (int step = 0;; ++step) {
      if (step > most_steps) return false;
      const int arrival = fan.arc[leaf][side];
      if (arrival < 0) return false;
      leaf = arrival / 2, side = arrival % 2;
      const int next = cross(leaf, side, copy);
      if (next < 0) {
        const int wanted = turns_wanted < 0 ? pass.turns : turns_wanted;
        if (leaf != pass.to || -1 - next != pass.to_sheet || turns != wanted) return false;
        break;
      }
      if (leaf == pass.from) ++turns;
      visited[leaf][side == 0 ? copy : next] = 1;
      copy = next, side = 1 - side;
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int start = 0; start < static_cast<int>(visited[i].size()); ++start) {
      if (visited[i][start]) continue;
      int next = cross(i, 0, start);
      if (next < 0) continue;
      visited[i][start] = 1;
      int leaf = i, side = 1, copy = next;
      for (int step = 0;; ++step) {
        if (step > most_steps) return false;
        const int arrival = fan.arc[leaf][side];
        if (arrival < 0) return false;
        leaf = arrival / 2, side = arrival % 2;
        if (leaf == i) {
          if (side != 0 || copy != start) return false;
          break;
        }
        next = cross(leaf, side, copy);
        if (next < 0) return false;  // belongs to no pass
        visited[leaf][side == 0 ? copy : next] = 1;
        copy = next, side = 1 - side;
      }
    }
  }
  return true;
}

}  // namespace overtet
