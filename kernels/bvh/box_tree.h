// A tree of boxes over a fixed set of items: all pairs of items whose boxes overlap, the items near a box or
// along a ray. The one broad phase of the program: the intersection test, the ray casts and the contact
// search use it.
//
// Guaranteed:
//  1. Conservative: boxes are rounded outwards to floats, so that no query misses an item (a few more are
//     possible; the caller decides exactly).
//  2. Results and their order do not depend on the number of threads.
//  3. Queries are const and may run from several threads.
//
// Built by sorting the items along a space-filling curve: everything is parallel, and a quarter of the time
// of a binned surface-area heuristic, which gives trees that are only a tenth faster to search. Leaves hold
// up to 16 items, coordinate by coordinate, so that four boxes are compared at once; in a pair of leaves the
// items that reach into the other leaf are found first.
//
//   BoxTree tree;
//   tree.build(n, [&](Index i) { return box_of(i); });
//   tree.refit([&](Index i) { return moved_box_of(i); });
//   auto hits = tree.collect_self_pairs<Hit>([&](Index i, Index j, std::vector<Hit>& out) { ... });
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "kernels/bvh/lanes.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/raw_vector.h"
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

class BoxTree {
 public:
  // n items; box_of(i) returns the Box of item i and is called from several threads.
  // pre: boxes are finite. O(n log n).
  template <std::invocable<Index> BoxOf>
  void build(Index n, BoxOf&& box_of) {
    build_from(n, [&](const Index* items, Index count, FloatBox* out) {
      for (Index i = 0; i < count; ++i) out[i] = rounded(box_of(items[i]));
    });
  }
  void build(std::span<const Box> boxes) {
    build(static_cast<Index>(boxes.size()), [&](Index i) -> const Box& { return boxes[i]; });
  }

  // New boxes for the same items. Answers stay complete; the search is slower the less the tree fits.
  template <std::invocable<Index> BoxOf>
  void refit(BoxOf&& box_of) {
    refit_from([&](const Index* items, Index count, FloatBox* out) {
      for (Index i = 0; i < count; ++i) out[i] = rounded(box_of(items[i]));
    });
  }
  void refit(std::span<const Box> boxes) {
    refit([&](Index i) -> const Box& { return boxes[i]; });
  }

  // Self pairs are reported only when at least one of the two items is active (one flag an item, 0 or 1); an
  // empty mask means all. Kept until the next build or set_active.
  void set_active(const std::vector<std::uint8_t>& active);

  Index size() const { return static_cast<Index>(item_.size()); }
  // Items in the tree's order, in which neighbours are near each other: the item at each place.
  std::span<const Index> order() const { return item_; }

  // The largest coordinate in absolute value, rounded up; 0 without items, infinity beyond floats.
  double reach() const;

  // visit(i, j, out) for every two different items whose boxes overlap, each pair once, i < j. Parallel; what
  // the visits append to `out` comes in an order that does not depend on threads.
  template <class T, class Visit>
  std::vector<T> collect_self_pairs(Visit&& visit) const {
    return collect_self_places<T>([&](Index p, Index q, std::vector<T>& out) {
      const Index i = item_[p], j = item_[q];
      i < j ? visit(i, j, out) : visit(j, i, out);
    });
  }
  // The same with places instead of items (see order()), p < q or p > q.
  template <class T, class Visit>
  std::vector<T> collect_self_places(Visit&& visit) const {
    return collect<T>(*this, self_tasks(), [&](Index p, Index q, std::vector<T>& out) {
      visit(p, q, out);
      return true;
    });
  }
  // The same, but the search ends soon after a visit appended something. What is returned does not depend on
  // threads either.
  template <class T, class Visit>
  std::vector<T> find_self_places(Visit&& visit) const {
    const std::vector<NodePair> tasks = self_tasks();
    constexpr std::size_t wave = 64;  // tasks that are finished together
    std::vector<T> found;
    for (std::size_t first = 0; first < tasks.size() && found.empty(); first += wave) {
      const auto begin = tasks.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = first + wave < tasks.size() ? begin + wave : tasks.end();
      found = collect<T>(*this, {begin, end}, [&](Index p, Index q, std::vector<T>& out) {
        visit(p, q, out);
        return out.empty();
      });
    }
    return found;
  }

  // visit(i, j, out) for every item i of this tree and j of the other one whose boxes overlap. Parallel, as
  // collect_self_pairs. Active flags are not looked at.
  template <class T, class Visit>
  std::vector<T> collect_pairs(const BoxTree& other, Visit&& visit) const {
    return collect<T>(other, tasks_with(other), [&](Index p, Index q, std::vector<T>& out) {
      visit(item_[p], other.item_[q], out);
      return true;
    });
  }

  // visit(i) for every item whose box meets [low, high]. Serial.
  template <class Visit>
  void query_box(const double* low, const double* high, Visit&& visit) const;

  // visit(i) for every item whose box, inflated by slack, meets the ray origin + t direction, t >= 0. Serial.
  template <class Visit>
  void query_ray(const double* origin, const double* direction, double slack, Visit&& visit) const;

 private:
  using Lanes = bvh_detail::Lanes;

  struct FloatBox {
    float low[3], high[3];
  };
  struct Node {
    float low[3];
    std::int32_t first;  // the first of two children, or the place of the first item
    float high[3];
    std::int32_t kind;  // 0 for inner ones, else number of items; bit 30: nothing in it is active

    int count() const { return kind & ~kPassive; }
    bool passive() const { return (kind & kPassive) != 0; }
  };
  struct NodePair {
    std::int32_t a, b;
  };
  // A part of the tree that one thread builds and refits: nodes [first, last) and, apart from them, its root.
  struct Subtree {
    std::int32_t root, first, last;
    Index begin, end;  // places
    int depth;         // of the root
  };
  using Fill = std::function<void(const Index* items, Index count, FloatBox* out)>;
  struct Builder;
  friend struct Builder;

  static constexpr std::int32_t kPassive = 1 << 30;
  static constexpr int kLeafSize = 16;

  // At least an ulp beyond the nearest float, without branches.
  static float round_down(double x) {
    const float f = std::min(static_cast<float>(x), std::numeric_limits<float>::max());
    return f - (std::fabs(f) * 1.2e-7f + std::numeric_limits<float>::min());
  }
  static float round_up(double x) { return -round_down(-x); }
  static FloatBox rounded(const Box& b) {
    return {{round_down(b.low[0]), round_down(b.low[1]), round_down(b.low[2])},
            {round_up(b.high[0]), round_up(b.high[1]), round_up(b.high[2])}};
  }

  void build_from(Index n, const Fill& fill);
  void refit_from(const Fill& fill);
  void fill_places(Index begin, Index end, const Fill& fill);
  void fit(Node& node, const Node* children) const;
  std::vector<NodePair> self_tasks() const;
  std::vector<NodePair> tasks_with(const BoxTree& other) const;

  const float* low(int axis) const { return bounds_.data() + axis * stride_; }
  const float* high(int axis) const { return bounds_.data() + (3 + axis) * stride_; }

  static bool overlap(const Node& x, const Node& y) {
    const auto both =
        (Lanes::load(x.low) <= Lanes::load(y.high)) & (Lanes::load(y.low) <= Lanes::load(x.high));
    return (both.bits() & 7) == 7;  // the fourth lane holds first and kind
  }
  // Bit k: the box at place first + k overlaps [lo, hi], k < count <= 16.
  unsigned overlapping(const float* lo, const float* hi, std::int32_t first, int count) const {
    const Lanes lx = Lanes::all(lo[0]), ly = Lanes::all(lo[1]), lz = Lanes::all(lo[2]);
    const Lanes hx = Lanes::all(hi[0]), hy = Lanes::all(hi[1]), hz = Lanes::all(hi[2]);
    const float *x0 = low(0) + first, *y0 = low(1) + first, *z0 = low(2) + first;
    const float *x1 = high(0) + first, *y1 = high(1) + first, *z1 = high(2) + first;
    unsigned out = 0;
    for (int k = 0; k < count; k += 4) {
      const auto x = (Lanes::load(x0 + k) <= hx) & (lx <= Lanes::load(x1 + k));
      const auto y = (Lanes::load(y0 + k) <= hy) & (ly <= Lanes::load(y1 + k));
      const auto z = (Lanes::load(z0 + k) <= hz) & (lz <= Lanes::load(z1 + k));
      out |= (x & y & z).bits() << k;
    }
    return out & ((1u << count) - 1);
  }
  unsigned overlapping(const BoxTree& other, std::int32_t place, std::int32_t first, int count) const {
    const float lo[3] = {other.low(0)[place], other.low(1)[place], other.low(2)[place]};
    const float hi[3] = {other.high(0)[place], other.high(1)[place], other.high(2)[place]};
    return overlapping(lo, hi, first, count);
  }

  // Whether a pair of nodes (of this tree and of the other one, which may be this one) is to be searched.
  bool wanted(const BoxTree& other, NodePair pair) const {
    const Node &x = nodes_[pair.a], &y = other.nodes_[pair.b];
    if (&other == this) {
      if (x.passive() && y.passive()) return false;
      if (pair.a == pair.b) return true;
    }
    return overlap(x, y);
  }
  // push(NodePair) for the wanted parts of a pair of which at least one is no leaf.
  template <class Push>
  void split(const BoxTree& other, NodePair pair, Push&& push) const {
    const Node &x = nodes_[pair.a], &y = other.nodes_[pair.b];
    const auto offer = [&](std::int32_t a, std::int32_t b) {
      if (wanted(other, {a, b})) push(NodePair{a, b});
    };
    if (&other == this && pair.a == pair.b) {
      offer(x.first + 1, x.first + 1);
      offer(x.first, x.first + 1);
      offer(x.first, x.first);
      return;
    }
    const int nx = x.count() == 0 ? 2 : 1, ny = y.count() == 0 ? 2 : 1;
    for (int i = nx; i-- > 0;)
      for (int j = ny; j-- > 0;) offer(nx == 2 ? x.first + i : pair.a, ny == 2 ? y.first + j : pair.b);
  }

  template <class T, class Visit>
  std::vector<T> collect(const BoxTree& other, const std::vector<NodePair>& tasks, Visit&& visit) const {
    return parallel_collect<T>(static_cast<std::int64_t>(tasks.size()), 1,
                               [&](std::int64_t begin, std::int64_t end, std::vector<T>& out) {
                                 for (std::int64_t i = begin; i < end; ++i)
                                   traverse(other, tasks[i],
                                            [&](Index p, Index q) { return visit(p, q, out); });
                               });
  }

  template <class Visit>
  void traverse(const BoxTree& other, NodePair task, Visit&& visit) const {
    std::vector<NodePair> stack;
    stack.reserve(4 * static_cast<std::size_t>(depth_ + other.depth_) + 4);
    stack.push_back(task);
    const bool self = &other == this, filtered = self && !active_.empty();
    while (!stack.empty()) {
      const NodePair pair = stack.back();
      stack.pop_back();
      const Node &x = nodes_[pair.a], &y = other.nodes_[pair.b];
      const int nx = x.count(), ny = y.count();
      if (nx == 0 || ny == 0) {
        split(other, pair, [&](NodePair p) { stack.push_back(p); });
        continue;
      }
      const bool same = self && pair.a == pair.b;
      for (unsigned rows = same ? (1u << nx) - 1 : overlapping(y.low, y.high, x.first, nx); rows != 0;
           rows &= rows - 1) {
        const int i = __builtin_ctz(rows);
        const std::int32_t p = x.first + i;
        unsigned found = other.overlapping(*this, p, y.first, ny);
        if (same) found &= ~((2u << i) - 1);
        for (; found != 0; found &= found - 1) {
          const std::int32_t q = y.first + __builtin_ctz(found);
          if (filtered && !active_[p] && !active_[q]) continue;
          if (!visit(p, q)) return;
        }
      }
    }
  }

  // The walk of all queries: meets_node(node), meets_items(first, count) -> bits.
  template <class MeetsNode, class MeetsItems, class Visit>
  void query(MeetsNode&& meets_node, MeetsItems&& meets_items, Visit&& visit) const {
    if (nodes_.empty() || !meets_node(nodes_[0])) return;
    constexpr std::size_t enough = 128;  // deeper trees come only from coordinates of wildly different sizes
    std::array<std::int32_t, enough> shallow;
    std::vector<std::int32_t> deep;
    std::int32_t* stack = shallow.data();
    if (static_cast<std::size_t>(depth_) + 2 > enough) {
      deep.resize(static_cast<std::size_t>(depth_) + 2);
      stack = deep.data();
    }
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (const int n = node.count()) {
        for (unsigned found = meets_items(node.first, n); found != 0; found &= found - 1)
          visit(item_[node.first + __builtin_ctz(found)]);
        continue;
      }
      if (meets_node(nodes_[node.first + 1])) stack[top++] = node.first + 1;
      if (meets_node(nodes_[node.first])) stack[top++] = node.first;
    }
  }

  RawVector<Node> nodes_;    // siblings side by side, after their parent
  RawVector<Index> item_;    // place -> item
  RawVector<float> bounds_;  // six rows of stride_: low x, y, z, high x, y, z of the item at each place
  std::size_t stride_ = 0;
  std::vector<std::uint8_t> active_;  // by place; empty: all
  std::vector<Subtree> subtrees_;
  std::int32_t top_nodes_ = 0;  // the nodes above the subtrees and their roots come first
  int depth_ = 0;
};

template <class Visit>
void BoxTree::query_box(const double* low, const double* high, Visit&& visit) const {
  const FloatBox box = rounded({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
  const auto meets_node = [&](const Node& x) {
    for (int k = 0; k < 3; ++k)
      if (!(x.low[k] <= box.high[k] && box.low[k] <= x.high[k])) return false;
    return true;
  };
  query(
      meets_node, [&](std::int32_t first, int count) { return overlapping(box.low, box.high, first, count); },
      visit);
}

template <class Visit>
void BoxTree::query_ray(const double* origin, const double* direction, double slack, Visit&& visit) const {
  // Everything in floats, errors on the safe side. Rounding the origin moves it by an ulp of the largest
  // number in play, and so does each difference below: covered by a wider slack. What is left are the
  // relative errors of the inverse and of the product, 2e-7 together, of either side of the comparison.
  double size = std::max(reach(), std::fabs(slack)), length = 0;
  for (int k = 0; k < 3; ++k) {
    size = std::max(size, std::fabs(origin[k]));
    length = std::max(length, std::fabs(direction[k]));
  }
  if (!(size > 1e-30 && size < 1e37)) {  // what follows could leave the range of floats
    for (const Index i : item_) visit(i);
    return;
  }
  const float wide = round_up(slack + 4e-7 * size);
  float from[3], inverse[3];
  bool along[3];  // the direction moves along this axis, as far as floats can tell
  for (int k = 0; k < 3; ++k) {
    from[k] = static_cast<float>(origin[k]);
    inverse[k] = static_cast<float>(1 / (direction[k] / length));
    along[k] = direction[k] != 0 && std::isfinite(inverse[k]);
  }
  constexpr float more = 1 + 1e-6f;
  // An axis that the ray does not move along only asks whether the ray is between the sides; one where the
  // inverse leaves the range of floats asks nothing.
  const auto meets_node = [&](const Node& x) {
    float near = 0, far = HUGE_VALF;
    for (int k = 0; k < 3; ++k) {
      const float lo = x.low[k] - wide - from[k], hi = x.high[k] + wide - from[k];
      if (!along[k]) {
        if (direction[k] == 0 && (lo > 0 || hi < 0)) return false;
        continue;
      }
      const float s = lo * inverse[k], t = hi * inverse[k];
      near = std::max(near, std::min(s, t));
      far = std::min(far, std::max(s, t));
    }
    return !(near > far * more);
  };
  const auto meets_items = [&](std::int32_t first, int count) {
    unsigned out = 0;
    for (int i = 0; i < count; i += 4) {
      Lanes near = Lanes::all(0), far = Lanes::all(HUGE_VALF);
      unsigned between = 15;
      for (int k = 0; k < 3; ++k) {
        const Lanes o = Lanes::all(from[k]), w = Lanes::all(wide);
        const Lanes lo = Lanes::load(low(k) + first + i) - w - o,
                    hi = Lanes::load(high(k) + first + i) + w - o;
        if (!along[k]) {
          if (direction[k] == 0) between &= ((lo <= Lanes::all(0)) & (Lanes::all(0) <= hi)).bits();
          continue;
        }
        const Lanes s = lo * Lanes::all(inverse[k]), t = hi * Lanes::all(inverse[k]);
        near = max(min(s, t), near);
        far = min(max(s, t), far);
      }
      out |= (between & (near <= far * Lanes::all(more)).bits()) << i;
    }
    return out & ((1u << count) - 1);
  };
  query(meets_node, meets_items, visit);
}

}  // namespace overtet
